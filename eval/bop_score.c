/* SPDX-License-Identifier: Apache-2.0 */
/* Key frames in parallel, a block at a time; counts of hits, so that no order of sums matters. */
#include "eval/bop_score.h"

#include "data/silhouette.h"
#include "eval/bop_file.h"
#include "eval/symmetry.h"
#include "eval/vsd.h"
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/rotation.h"

#include <stdio.h>

enum { STEPS = 10, BLOCK = 64 };

static const double DELTA = 0.015;              /* metres */
static const double WIDTH = 640;                /* of the image that MSPD's pixels are counted in */

static double share(int step) { return 0.05 * (step + 1); }

/* Hits: VSD of STEPS * STEPS a target, MSSD and MSPD of STEPS. */
typedef struct { int64_t targets, estimated, hits[3]; } totals;

static void add(totals *sum, const totals *some)
{
    sum->targets += some->targets;
    sum->estimated += some->estimated;
    for (int k = 0; k < 3; k++)
        sum->hits[k] += some->hits[k];
}

/* ---- one target ---- */

static bool is_rigid(const eval_pose *p)
{
    return lt_rot_is_near(p->R, 1e-2) && eval_pose_finite(p);
}

static lt_status draw(const dataset_object *o, const eval_pose *p, const dexycb_scene *s, lt_arena *arena,
                      float **out)
{
    float R[9], t[3];

    for (int i = 0; i < 9; i++)
        R[i] = (float)p->R[i];
    for (int i = 0; i < 3; i++)
        t[i] = (float)p->t[i];
    *out = lt_arena_array(arena, DEXYCB_WIDTH * DEXYCB_HEIGHT, sizeof(**out));
    if (!*out)
        return lt_error(LT_ENOMEM, "%s: no memory to draw the object", o->name);
    return silhouette_depth(&o->mesh, R, t, &s->camera, *out, DEXYCB_WIDTH, DEXYCB_HEIGHT, arena);
}

static lt_status count_vsd(const dataset_object *o, const dexycb_scene *s, const eval_pose *e, const eval_pose *g,
                           lt_arena *arena, int64_t *hits)
{
    const eval_vsd_view view = { DEXYCB_WIDTH, DEXYCB_HEIGHT, s->camera, s->depth, DELTA, o->diameter };
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

static lt_status count_surface(const dataset_object *o, const dexycb_scene *s, const eval_pose *e, const eval_pose *g,
                               lt_arena *arena, int64_t hits[2])
{
    const int n = o->mesh.n_vertices;
    double *x = lt_arena_array(arena, 3 * (size_t)n, sizeof(*x)), mssd, mspd;
    eval_pose *symmetry = lt_arena_array(arena, EVAL_TURNS, sizeof(*symmetry));
    int n_symmetries;

    if (!x || !symmetry)
        return lt_error(LT_ENOMEM, "%s: no memory for %d vertices", o->name, n);
    for (int i = 0; i < 3 * n; i++)
        x[i] = o->mesh.vertex[i / 3][i % 3];
    n_symmetries = eval_symmetries(ycb_find(o->ycb_id), symmetry);
    mssd = eval_mssd(n, x, e, g, n_symmetries, symmetry);
    mspd = eval_mspd(n, x, e, g, n_symmetries, symmetry, &s->camera);
    for (int step = 0; step < STEPS; step++) {
        hits[0] += mssd < share(step) * (double)o->diameter;
        hits[1] += mspd < 5 * (step + 1) * DEXYCB_WIDTH / WIDTH;
    }
    return LT_OK;
}

static lt_status measure(const dexycb_scene *s, int i, const bop_estimate *estimate, lt_arena *arena, totals *out)
{
    const dataset_object *o = s->model[i];
    const eval_pose g = eval_pose_of(s->pose[i].R, s->pose[i].t);
    lt_status st;

    *out = (totals){ .targets = 1, .estimated = estimate != NULL };
    if (!estimate || !is_rigid(&estimate->pose))
        return LT_OK;
    st = count_vsd(o, s, &estimate->pose, &g, arena, &out->hits[0]);
    return st ? st : count_surface(o, s, &estimate->pose, &g, arena, &out->hits[1]);
}

/* ---- one frame ---- */

typedef struct {
    int64_t index;                  /* of the sample */
    totals all, grasped;
    lt_status status;
    char line[1024];
} frame;

typedef struct {
    const dataset *d;
    const bop_file *file;
    frame *frame;
} job;

static lt_status measure_frame(const job *j, frame *f, lt_arena *arena)
{
    const dexycb_place place = dexycb_place_of(j->d, f->index);
    dexycb_scene s;
    lt_status st = dexycb_read_scene(j->d, f->index, arena, &s);

    for (int i = 0; !st && i < place.n_targets; i++) {
        totals one;
        if (!s.pose[i].known)
            continue;
        st = measure(&s, i, bop_file_find(j->file, place.scene, place.image, place.target[i]), arena, &one);
        add(&f->all, &one);
        if (i == place.grasped)
            add(&f->grasped, &one);
    }
    return st;
}

static void frame_task(void *ctx, int64_t i)
{
    const job *j = ctx;
    frame *f = &j->frame[i];
    lt_arena *arena = lt_arena_new();

    f->status = arena ? measure_frame(j, f, arena) : lt_error(LT_ENOMEM, "no memory to score object poses");
    if (f->status)
        snprintf(f->line, sizeof(f->line), "%s", lt_last_error());
    lt_arena_free(arena);
}

/* ---- all frames ---- */

static lt_status measure_block(job *j, int64_t n, totals *all, totals *grasped)
{
    lt_parallel_for(n, frame_task, j);
    for (int64_t i = 0; i < n; i++) {
        if (j->frame[i].status)
            return lt_error(j->frame[i].status, "%s", j->frame[i].line);
        add(all, &j->frame[i].all);
        add(grasped, &j->frame[i].grasped);
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

lt_status bop_score(const dataset *d, const char *path, bop_progress progress, void *ctx, bop_recalls *out)
{
    lt_arena *arena = lt_arena_new();
    bop_file file;
    job j = { d, &file, arena ? lt_arena_array(arena, BLOCK, sizeof(*j.frame)) : NULL };
    totals all = { 0 }, grasped = { 0 };
    int64_t count = 0;
    lt_status st = j.frame ? bop_file_read(arena, path, &file) : lt_error(LT_ENOMEM, "%s: no memory", path);

    for (int64_t i = 0; !st && i < d->count; i++) {
        if (dexycb_place_of(d, i).keyframe)
            j.frame[count++] = (frame){ .index = i };
        if (count < BLOCK && i + 1 < d->count)
            continue;
        st = measure_block(&j, count, &all, &grasped);
        count = 0;
        if (!st && progress && !progress(ctx, i + 1, d->count))
            st = lt_error(LT_ESTOPPED, "%s: stopped after %lld of %lld samples", path, (long long)i + 1,
                          (long long)d->count);
    }
    if (!st)
        *out = (bop_recalls){ recall_of(&all), recall_of(&grasped) };
    lt_arena_free(arena);
    return st;
}
