/* SPDX-License-Identifier: Apache-2.0 */
/* Targets in parallel, a block at a time; counts of hits, so that no order of sums matters. */
#include "eval/bop_score.h"

#include "data/silhouette.h"
#include "eval/bop_file.h"
#include "eval/symmetry.h"
#include "eval/vsd.h"
#include "libtensor/base/parallel.h"

#include <math.h>
#include <stdio.h>

enum { STEPS = 10, BLOCK = 64 };

static const double DELTA = 0.015;              /* metres */
static const double WIDTH = 640;                /* of the image that MSPD's pixels are counted in */

static double share(int step) { return 0.05 * (step + 1); }

/* ---- one target ---- */

typedef struct {
    int64_t index;                  /* of the sample */
    const bop_estimate *estimate;
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
    e = t->estimate->pose;
    g = eval_pose_of(s.R, s.t);
    if (s.flags & SAMPLE_MIRRORED)
        eval_pose_mirror(&e);
    eval_pose_of_model(&e, s.flags & SAMPLE_MIRRORED);
    eval_pose_of_model(&g, s.flags & SAMPLE_MIRRORED);
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
    bop_file file;
    int64_t count = 0;
    lt_status st = some ? bop_file_read(arena, path, &file) : lt_error(LT_ENOMEM, "%s: no memory", path);

    for (int64_t i = 0; !st && i < d->count; i++) {
        const dexycb_place place = dexycb_place_of(d, i);
        if (place.keyframe)
            some[count++] = (target){ .index = i, .estimate = bop_file_find(&file, place.scene, place.image, place.target[place.grasped]) };
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
