/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hand_object/breakdown.h"

#include "eval/metrics/curve.h"
#include "eval/metrics/metrics.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/csv.h"

#include <string.h>

enum { JOINTS = LT_HAND_KEYPOINTS };

/* Samples that have something in common, in a list. */
typedef struct group {
    struct group *next;
    const char *name;
    eval_mean_of pa, relative, add;
    eval_share add01;
    int64_t samples;
} group;

struct eval_breakdown {
    lt_arena *arena;
    eval_mean_of pa[JOINTS], relative[JOINTS];
    group *object, *sequence;
    group *last;                    /* sequence: samples come one sequence after the other */
};

eval_breakdown *eval_breakdown_new(lt_arena *arena)
{
    eval_breakdown *b = lt_arena_alloc(arena, sizeof(*b));

    if (b)
        *b = (eval_breakdown){ .arena = arena };
    return b;
}

static bool is_called(const group *g, const char *name, size_t n)
{
    return g && strlen(g->name) == n && !memcmp(g->name, name, n);
}

/* The group called by the first n bytes of name, made at the end of the list where it is new; NULL without memory. */
static group *group_of(lt_arena *arena, group **list, const char *name, size_t n)
{
    group *g;

    for (; *list; list = &(*list)->next)
        if (is_called(*list, name, n))
            return *list;
    g = lt_arena_alloc(arena, sizeof(*g));
    if (!g)
        return NULL;
    *g = (group){ .name = lt_arena_printf(arena, "%.*s", (int)n, name) };
    if (g->name)
        *list = g;
    return g->name ? g : NULL;
}

static group *sequence_of(eval_breakdown *b, const char *name)
{
    const char *slash = strrchr(name, '/');
    const size_t n = slash ? (size_t)(slash - name) : strlen(name);

    if (!is_called(b->last, name, n))
        b->last = group_of(b->arena, &b->sequence, name, n);
    return b->last;
}

static void add_to(group *g, const eval_breakdown_sample *s, double pa, double relative)
{
    eval_mean_add(&g->pa, pa);
    eval_mean_add(&g->relative, relative);
    g->samples++;
    if (!s->object)
        return;
    eval_mean_add(&g->add, s->add);
    eval_share_add(&g->add01, s->add01);
}

lt_status eval_breakdown_add(eval_breakdown *b, const eval_breakdown_sample *s)
{
    group *sequence = sequence_of(b, s->name);
    group *object = s->object ? group_of(b->arena, &b->object, s->object, strlen(s->object)) : NULL;
    double moved[3 * JOINTS], pa[JOINTS], relative[JOINTS];

    if (!sequence || (s->object && !object))
        return lt_error(LT_ENOMEM, "no memory for the errors of %s", s->name);
    eval_align_procrustes(EVAL_REFLECT, JOINTS, s->joints, s->truth, moved);
    eval_distances(JOINTS, moved, s->truth, pa);
    eval_align_root(JOINTS, s->joints, s->truth, 0, moved);
    eval_distances(JOINTS, moved, s->truth, relative);
    for (int i = 0; i < JOINTS; i++) {
        eval_mean_add(&b->pa[i], pa[i]);
        eval_mean_add(&b->relative[i], relative[i]);
    }
    add_to(sequence, s, eval_mean(JOINTS, pa), eval_mean(JOINTS, relative));
    if (object)
        add_to(object, s, eval_mean(JOINTS, pa), eval_mean(JOINTS, relative));
    return LT_OK;
}

/* ---- the files ------------------------------------------------------------------------------------------ */

static double millimetres(const eval_mean_of *m)
{
    return 1e3 * eval_mean_value(m);
}

static lt_status write_joints(const eval_breakdown *b, const char *path)
{
    static const char *const metric[] = { "pa_mpjpe_mm", "mpjpe_mm" };
    static const char *const name[JOINTS] = {
        "wrist", "thumb CMC", "thumb MCP", "thumb IP", "thumb tip", "index MCP", "index PIP", "index DIP", "index tip",
        "middle MCP", "middle PIP", "middle DIP", "middle tip", "ring MCP", "ring PIP", "ring DIP", "ring tip",
        "little MCP", "little PIP", "little DIP", "little tip",
    };
    lt_csv w;
    const lt_status st = lt_csv_open(&w, path, "joint", LT_COUNT(metric), metric);

    for (int i = 0; !st && i < JOINTS; i++)
        lt_csv_add(&w, name[i], (double[]){ millimetres(&b->pa[i]), millimetres(&b->relative[i]) });
    return st ? st : lt_csv_commit(&w);
}

static lt_status write_groups(const group *list, const char *path, const char *about)
{
    static const char *const metric[] = { "pa_mpjpe_mm", "mpjpe_mm", "add_mm", "add01_percent", "samples" };
    lt_csv w;
    const lt_status st = lt_csv_open(&w, path, about, LT_COUNT(metric), metric);

    for (const group *g = list; !st && g; g = g->next)
        lt_csv_add(&w, g->name, (double[]){ millimetres(&g->pa), millimetres(&g->relative), millimetres(&g->add),
                                              100 * eval_share_value(&g->add01), (double)g->samples });
    return st ? st : lt_csv_commit(&w);
}

lt_status eval_breakdown_write(const eval_breakdown *b, const char *folder)
{
    const char *joints = lt_path_join(b->arena, folder, "per-joint.csv");
    const char *objects = lt_path_join(b->arena, folder, "per-object.csv");
    const char *sequences = lt_path_join(b->arena, folder, "per-sequence.csv");
    lt_status st;

    if (!joints || !objects || !sequences)
        return lt_error(LT_ENOMEM, "no memory to write %s", folder);
    st = write_joints(b, joints);
    st = st ? st : write_groups(b->object, objects, "object");
    return st ? st : write_groups(b->sequence, sequences, "sequence");
}
