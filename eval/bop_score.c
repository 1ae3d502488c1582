/* SPDX-License-Identifier: Apache-2.0 */
/* Targets in parallel, a block at a time; counts of hits, so that no order of sums matters. */
#include "eval/bop_score.h"

#include "data/silhouette.h"
#include "eval/symmetry.h"
#include "eval/vsd.h"
#include "libtensor/base/parallel.h"
#include "libtensor/io/file.h"
#include "libtensor/io/number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS = 10, BLOCK = 64, FIELDS = 17 };

static const char header[] = "scene_id,im_id,obj_id,score,R,t,time";
static const double DELTA = 0.015;              /* metres */
static const double WIDTH = 640;                /* of the image that MSPD's pixels are counted in */

static double share(int step) { return 0.05 * (step + 1); }

/* ---- the file ---- */

typedef struct { int scene, image, object; double score; eval_pose pose; } estimate;

/* By target, the best score first. */
static int by_target(const void *a, const void *b)
{
    const estimate *x = a, *y = b;

    if (x->scene != y->scene)
        return x->scene < y->scene ? -1 : 1;
    if (x->image != y->image)
        return x->image < y->image ? -1 : 1;
    if (x->object != y->object)
        return x->object < y->object ? -1 : 1;
    return x->score > y->score ? -1 : x->score < y->score;
}

/* 17 numbers, with a comma or a blank between them. */
static bool parse_numbers(const char *text, double x[FIELDS])
{
    for (int i = 0; i < FIELDS; i++) {
        const bool blank = (i > 4 && i < 13) || (i > 13 && i < 16);
        const char *end;

        if (i && *text++ != (blank ? ' ' : ','))
            return false;
        x[i] = lt_strtod(text, &end);
        if (end == text)
            return false;
        text = end;
    }
    return text[strspn(text, " \r")] == 0;
}

static bool whole(double x)
{
    return x == floor(x) && fabs(x) < 1e9;
}

static lt_status parse_line(const char *path, int64_t number, const char *text, estimate *out)
{
    double x[FIELDS];

    if (!parse_numbers(text, x) || !whole(x[0]) || !whole(x[1]) || !whole(x[2]) || !isfinite(x[3]))
        return lt_error(LT_EFORMAT, "%s:%lld: expected %s, with 9 numbers for R and 3 for t", path, (long long)number,
                        header);
    *out = (estimate){ (int)x[0], (int)x[1], (int)x[2], x[3], { { 0 }, { x[13], x[14], x[15] } } };
    memcpy(out->pose.R, x + 4, sizeof(out->pose.R));
    return LT_OK;
}

static lt_status parse(lt_arena *arena, const char *path, char *text, estimate **out, int64_t *n)
{
    int64_t lines = 1, number = 1;
    char *rest = NULL, *line = strtok_r(text, "\n", &rest);

    if (!line || strncmp(line, header, strlen(header)))
        return lt_error(LT_EFORMAT, "%s: expected \"%s\" first", path, header);
    for (const char *p = rest; *p; p++)
        lines += *p == '\n';
    *out = lt_arena_array(arena, (size_t)lines, sizeof(**out));
    if (!*out)
        return lt_error(LT_ENOMEM, "%s: no memory for %lld lines", path, (long long)lines);
    *n = 0;
    while ((line = strtok_r(NULL, "\n", &rest))) {
        const lt_status st = parse_line(path, ++number, line, &(*out)[*n]);
        if (st)
            return st;
        (*n)++;
    }
    qsort(*out, (size_t)*n, sizeof(**out), by_target);
    return LT_OK;
}

/* The best estimate of a target, or NULL. */
static const estimate *find(const estimate *all, int64_t n, const dexycb_place *place)
{
    const estimate key = { place->scene, place->image, place->target[place->grasped], INFINITY, { { 0 }, { 0 } } };
    int64_t lo = 0, hi = n;

    while (lo < hi) {
        const int64_t middle = (lo + hi) / 2;
        if (by_target(&all[middle], &key) < 0)
            lo = middle + 1;
        else
            hi = middle;
    }
    if (lo == n || all[lo].scene != key.scene || all[lo].image != key.image || all[lo].object != key.object)
        return NULL;
    return &all[lo];
}

/* ---- one target ---- */

typedef struct {
    int64_t index;                  /* of the sample */
    const estimate *estimate;
    int hits[3];                    /* VSD of STEPS * STEPS, MSSD and MSPD of STEPS */
    lt_status status;
    char line[1024];
} target;

typedef struct { const dataset *d; target *target; } job;

/* Rows of R of length 1 and upright on each other, to what a file's digits leave of it */
static bool is_rigid(const eval_pose *p)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double dot = 0;
            for (int k = 0; k < 3; k++)
                dot += p->R[3 * i + k] * p->R[3 * j + k];
            if (!(fabs(dot - (i == j)) < 1e-2))
                return false;
        }
    return eval_pose_finite(p);
}

/* The estimate as the sample shows things: in the mirror where that is mirrored. */
static eval_pose in_sample(const estimate *e, const dataset_sample *s)
{
    eval_pose p = e->pose;

    for (int i = 0; i < 9 && (s->flags & SAMPLE_MIRRORED); i++)
        if (i == 1 || i == 2 || i == 3 || i == 6)
            p.R[i] = -p.R[i];
    if (s->flags & SAMPLE_MIRRORED)
        p.t[0] = -p.t[0];
    eval_pose_of_model(&p, s->flags & SAMPLE_MIRRORED);
    return p;
}

static eval_pose true_pose(const dataset_sample *s)
{
    eval_pose p;

    for (int i = 0; i < 9; i++)
        p.R[i] = s->R[i];
    for (int i = 0; i < 3; i++)
        p.t[i] = s->t[i];
    eval_pose_of_model(&p, s->flags & SAMPLE_MIRRORED);
    return p;
}

static lt_status draw(const dataset_object *o, const eval_pose *p, const dataset_sample *s, lt_arena *arena,
                      float **out)
{
    float R[9], t[3];

    for (int i = 0; i < 9; i++)
        R[i] = (float)p->R[i];
    for (int i = 0; i < 3; i++)
        t[i] = (float)p->t[i];
    *out = lt_arena_array(arena, (size_t)s->width * (size_t)s->height, sizeof(**out));
    if (!*out)
        return lt_error(LT_ENOMEM, "%s: no memory to draw the object", s->name);
    return silhouette_depth(&o->mesh, R, t, &s->camera, *out, s->width, s->height, arena);
}

static lt_status count_vsd(const dataset_object *o, const dataset_sample *s, const eval_pose *e, const eval_pose *g,
                           lt_arena *arena, int *hits)
{
    const eval_vsd_view view = { s->width, s->height, s->camera, s->depth, DELTA, o->diameter };
    double tau[STEPS], errors[STEPS];
    float *at_e, *at_g;
    lt_status st = draw(o, e, s, arena, &at_e);

    if (!st)
        st = draw(o, g, s, arena, &at_g);
    if (st)
        return st;
    for (int k = 0; k < STEPS; k++)
        tau[k] = share(k);
    eval_vsd(&view, at_e, at_g, STEPS, tau, errors);
    for (int k = 0; k < STEPS; k++)
        for (int step = 0; step < STEPS; step++)
            *hits += errors[k] < share(step);
    return LT_OK;
}

static lt_status count_surface(const dataset_object *o, const dataset_sample *s, const eval_pose *e, const eval_pose *g,
                               lt_arena *arena, int hits[2])
{
    const ycb_object *ycb = ycb_find(o->ycb_id);
    const int n = o->mesh.n_vertices;
    double *x = lt_arena_array(arena, 3 * (size_t)n, sizeof(*x)), mssd, mspd;
    eval_pose *symmetry = lt_arena_array(arena, EVAL_TURNS, sizeof(*symmetry));
    int n_symmetries;

    if (!x || !symmetry)
        return lt_error(LT_ENOMEM, "%s: no memory for %d vertices", s->name, n);
    for (int i = 0; i < 3 * n; i++)
        x[i] = o->mesh.vertex[i / 3][i % 3];
    n_symmetries = ycb ? eval_symmetries(ycb, symmetry) : 0;
    mssd = eval_mssd(n, x, e, g, n_symmetries, symmetry);
    mspd = eval_mspd(n, x, e, g, n_symmetries, symmetry, &s->camera);
    for (int step = 0; step < STEPS; step++) {
        hits[0] += mssd < share(step) * (double)o->diameter;
        hits[1] += mspd < 5 * (step + 1) * s->width / WIDTH;
    }
    return LT_OK;
}

static lt_status measure(const dataset *d, target *t, lt_arena *arena)
{
    dataset_sample s;
    lt_status st = dataset_read(d, t->index, SAMPLE_DEPTH, arena, &s);
    eval_pose e, g;

    if (st)
        return st;
    if (s.object < 0)
        return lt_error(LT_EFORMAT, "%s: has no pose of the object in the hand", s.name);
    if (!t->estimate || !is_rigid(&t->estimate->pose))
        return LT_OK;
    e = in_sample(t->estimate, &s);
    g = true_pose(&s);
    st = count_vsd(&d->objects[s.object], &s, &e, &g, arena, &t->hits[0]);
    return st ? st : count_surface(&d->objects[s.object], &s, &e, &g, arena, &t->hits[1]);
}

static void measure_task(void *ctx, int64_t i)
{
    const job *j = ctx;
    target *t = &j->target[i];
    lt_arena *arena = lt_arena_new();

    t->status = arena ? measure(j->d, t, arena) : lt_error(LT_ENOMEM, "no memory to score object poses");
    if (t->status)
        snprintf(t->line, sizeof(t->line), "%s", lt_last_error());
    lt_arena_free(arena);
}

/* ---- all targets ---- */

typedef struct { int64_t targets, estimated, hits[3]; } totals;

static lt_status measure_block(const dataset *d, target *some, int64_t n, totals *sum)
{
    lt_parallel_for(n, measure_task, &(job){ d, some });
    for (int64_t i = 0; i < n; i++) {
        if (some[i].status)
            return lt_error(some[i].status, "%s", some[i].line);
        sum->targets++;
        sum->estimated += some[i].estimate != NULL;
        for (int k = 0; k < 3; k++)
            sum->hits[k] += some[i].hits[k];
    }
    return LT_OK;
}

static bop_recall recall_of(const totals *sum)
{
    const double n = (double)sum->targets;
    bop_recall r = {
        .targets = sum->targets, .estimated = sum->estimated, .vsd = (double)sum->hits[0] / (n * STEPS * STEPS),
        .mssd = (double)sum->hits[1] / (n * STEPS), .mspd = (double)sum->hits[2] / (n * STEPS),
    };

    r.ar = (r.vsd + r.mssd + r.mspd) / 3;
    return r;
}

lt_status bop_score(const dataset *d, const char *path, bop_progress progress, void *ctx, bop_recall *out)
{
    lt_arena *arena = lt_arena_new();
    target *some = arena ? lt_arena_array(arena, BLOCK, sizeof(*some)) : NULL;
    totals sum = { 0 };
    estimate *all = NULL;
    int64_t n = 0, count = 0;
    uint8_t *text;
    size_t size;
    lt_status st = some ? lt_read_file(arena, path, (size_t)2 << 30, &text, &size)
                        : lt_error(LT_ENOMEM, "%s: no memory", path);

    if (!st)
        st = parse(arena, path, (char *)text, &all, &n);
    for (int64_t i = 0; !st && i < d->count; i++) {
        const dexycb_place place = dexycb_place_of(d, i);
        if (place.keyframe)
            some[count++] = (target){ .index = i, .estimate = find(all, n, &place) };
        if (count < BLOCK && i + 1 < d->count)
            continue;
        st = measure_block(d, some, count, &sum);
        count = 0;
        if (!st && progress && !progress(ctx, i + 1, d->count))
            st = lt_error(LT_ESTOPPED, "%s: stopped after %lld of %lld samples", path, (long long)i + 1,
                          (long long)d->count);
    }
    if (!st)
        *out = recall_of(&sum);
    lt_arena_free(arena);
    return st;
}
