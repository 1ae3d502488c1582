/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/results/export.h"

#include "data/kind.h"
#include "libtensor/base/clock.h"
#include "libtensor/base/printable.h"
#include "libtensor/geometry/mesh/parts.h"
#include "libtensor/io/file.h"
#include "libtensor/io/mesh/glb.h"
#include "libtensor/io/mesh/obj.h"
#include "libtensor/io/mesh/splat.h"
#include "tasks/hogs/results/shapes.h"
#include "tasks/hogs/source.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

typedef struct {
    const task_export *e;
    task_run *run;
    int done;                       /* frames */
} job;

/* ---- files ----------------------------------------------------------------------------------------------------- */

/* As glTF wants its colours; meshes hold them as displays do. */
static void make_linear(lt_mesh *m)
{
    for (int i = 0; i < 3 * m->n_vertices; i++) {
        float *x = &m->color[i / 3][i % 3];

        *x = *x <= 0.04045f ? *x / 12.92f : powf((*x + 0.055f) / 1.055f, 2.4f);
    }
}

static lt_status write_mesh(const char *path, const char *format, const char *name, lt_mesh *m)
{
    if (strcmp(format, "obj") == 0)
        return lt_obj_write(path, m, NULL);
    if (strcmp(format, "glb") != 0)
        return lt_ply_write_mesh(path, m);
    make_linear(m);
    return lt_glb_write(path, &(lt_glb_part){ .name = name, .mesh = m, .color = { 1, 1, 1, 1 } }, 1);
}

static lt_status write_splats(const task_export *e, const char *name, const char *frame, const lt_splat *s, size_t n,
                              int degree)
{
    if (strcmp(e->format, "splat") == 0)
        return lt_splat_write(e->file, s, n);
    if (strcmp(e->format, "glb") == 0)
        return lt_glb_write_splats(e->file, name, s, n, degree);
    return lt_ply_write_splats(e->file, frame, s, n);
}

/* ---- frames ---------------------------------------------------------------------------------------------------- */

static lt_status export_mesh(const job *j, const compiled *c, bool object, lt_arena *arena)
{
    const task_export *e = j->e;
    const int64_t frame = e->frame[j->done];
    const char *part = object ? "object" : "hand";
    const char *path = lt_arena_printf(arena, "%s/frame-%04" PRId64 "-%s.%s", e->folder, frame, part, e->format);
    const double began = lt_clock();
    lt_mesh_topology t;
    lt_mesh m;
    lt_status st = path ? hogs_posed_mesh(arena, c, object, e->rule, e->iso, &m)
                        : lt_error(LT_ENOMEM, "%s: no memory", e->folder);
    const double seconds = lt_clock() - began;

    if (!st)
        st = lt_mesh_topology_of(&m, &t);
    if (!st)
        st = write_mesh(path, e->format, part, &m);
    if (!st)
        e->made(e->ctx, &(task_exported){ .file = path, .part = part, .frame = frame, .vertices = m.n_vertices,
                                          .faces = m.n_faces, .watertight = t.watertight,
                                          .components = t.components, .seconds = seconds });
    return st;
}

static lt_status export_frame(const job *j, const compiled *c, lt_arena *arena)
{
    lt_splat *splat;
    size_t n;
    lt_status st = LT_OK;

    for (int object = 0; object < 2 && !st && j->e->folder; object++)
        st = export_mesh(j, c, object, arena);
    if (st || !j->e->file)
        return st;
    st = hogs_posed_splats(arena, c, &splat, &n);
    return st ? st : write_splats(j->e, "frame", "opencv camera, metres", splat, n, 0);
}

static lt_status visit(void *ctx, const compiled *c, const void *batch)
{
    job *j = ctx;
    const hogs_batch *b = batch;
    lt_arena *arena;
    lt_status st;

    if (!b->count || !b->frame[0].there)
        return lt_error(LT_EINVAL, "frame %" PRId64 ": neither hand nor object is seen in it", j->e->frame[j->done]);
    arena = lt_arena_new();
    st = arena ? export_frame(j, c, arena) : lt_error(LT_ENOMEM, "no memory for a surface");
    lt_arena_free(arena);
    j->done++;
    return st;
}

static void skipped(void *ctx, int i, const char *line)
{
    (void)ctx, (void)i, (void)line;                     /* nothing is tolerated */
}

/* The frames that are asked for, by their numbers among those with poses */
static lt_status choose_frames(const job *j, hogs_source *s)
{
    const task_export *e = j->e;
    int64_t *chosen = lt_arena_array(j->run->arena, (size_t)e->n_frames, sizeof(*chosen));
    const int64_t *index;
    int64_t count;
    lt_status st = chosen ? hogs_frames_of(j->run->arena, s->data, s->poses, &index, &count)
                          : lt_error(LT_ENOMEM, "no memory for %d frames", e->n_frames);

    for (int i = 0; i < e->n_frames && !st; i++) {
        if (e->frame[i] >= count)
            st = lt_error(LT_EINVAL, "frame %" PRId64 ": %s, split %s, has %" PRId64 " with poses, counted from 0",
                          e->frame[i], s->data->root, s->data->split, count);
        else
            chosen[i] = index[e->frame[i]];
    }
    s->index = chosen;
    s->count = e->n_frames;
    return st;
}

static lt_status export_frames(job *j)
{
    task_run *r = j->run;
    const hogs_data_config *d = hogs_data_of(r->config);
    hogs_source *s = &r->check_source;
    const recipe by = hogs_recipe(r, HOGS_RENDER);
    loader_source frames;
    compiled c = { 0 };
    lt_status st;

    *s = hogs_source_of(r, r->train, r->train_poses);
    st = choose_frames(j, s);
    if (!st)
        st = compiled_new(&by, 1, false, &c);
    frames = hogs_frames_loader(s);
    if (!st)
        st = compiled_walk(&c, &frames, d->common.threads, 0, visit, skipped, j, NULL);
    compiled_free(&c);
    return st;
}

/* ---- sets ------------------------------------------------------------------------------------------------------ */

static lt_status unknown_set(lt_arena *arena, const task_export *e, const hogs *m)
{
    const char *all = "";

    for (int i = 0; i < hogs_n_sets(m) && all; i++)
        all = lt_arena_printf(arena, "%s%s%s", all, i ? ", " : "", hogs_set_name(arena, m, i));
    return lt_error(LT_EINVAL, "%s: no set \"%s\"; it has %s", e->checkpoint, e->set, all ? all : "others");
}

static lt_status export_set(const job *j)
{
    const hogs *m = hogs_of(j->run->m);
    lt_arena *arena = j->run->arena;

    for (int i = 0; i < hogs_n_sets(m); i++) {
        const char *name = hogs_set_name(arena, m, i);
        lt_splat *splat;
        size_t n;
        lt_status st;

        if (!name || strcmp(name, j->e->set) != 0)
            continue;
        st = hogs_canonical_splats(arena, m, i, &splat, &n);
        return st ? st : write_splats(j->e, name, "canonical, metres", splat, n, 3);
    }
    return unknown_set(arena, j->e, m);
}

lt_status hogs_export(const task_export *e)
{
    lt_params *set = lt_params_new();
    model m;
    task_run run = { .arena = e->arena, .config = e->config, .m = &m };
    job j = { .e = e, .run = &run };
    const dataset_kind *kind;
    const char *split;
    lt_status st = set ? dataset_find_kind(e->config->data->dir, &kind)
                       : lt_error(LT_ENOMEM, "no memory for the model");

    if (e->hand)
        ((hogs_data_config *)e->config->data)->hand = e->hand;
    if (!st) {
        split = dataset_validation_split(kind, e->config->data->dir);
        st = hogs_open_data(&run, e->config, split ? split : "train");
    }
    if (!st)
        st = hogs_open_model(&run, e->checkpoint, set);
    if (!st && e->folder)
        st = lt_make_dirs(e->folder);
    if (!st)
        st = e->set ? export_set(&j) : export_frames(&j);
    hogs_lists_free(&run.lists);
    hogs_close_data(&run);
    lt_params_free(set);
    return st;
}
