/* SPDX-License-Identifier: Apache-2.0 */
/* Key frames in parallel, a block at a time; counts of hits, so that no order of sums matters. */
#include "eval/scorers/bop_score.h"

#include "assets/ycb/symmetry.h"
#include "data/slip.h"
#include "eval/metrics/object_pose.h"
#include "eval/metrics/vsd.h"
#include "eval/scorers/bop_file.h"
#include "eval/scorers/models_info.h"
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/rotation.h"
#include "vision/silhouette.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { STEPS = 10, BLOCK = 64, LOOK = 256 };        /* LOOK: poses that slips are looked for in */

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

/* ---- the models ---- */

/* What the dataset's own models show, by YCB id */
static lt_status measure_models(const dataset *d, lt_arena *arena, bop_model out[YCB_COUNT + 1])
{
    for (int i = 0; i < d->n_objects; i++) {
        const ycb_object *ycb = ycb_find(d->objects[i].ycb_id);
        lt_pose *symmetry = lt_arena_array(arena, YCB_TURNS, sizeof(*symmetry));
        if (!symmetry)
            return lt_error(LT_ENOMEM, "%s: no memory", d->objects[i].name);
        out[ycb->id] = (bop_model){ (double)d->objects[i].diameter, ycb_symmetries(ycb, symmetry), symmetry };
    }
    return LT_OK;
}

/* ---- one target ---- */

typedef struct {
    const dataset_object *o;
    const bop_model *model;
    const dexycb_scene *scene;
    lt_pose e, g;                 /* estimated, true */
} target;

static const double FAR = 1e4;                  /* metres, beyond which nothing is */

static bool is_near(const double t[3])
{
    return fabs(t[0]) < FAR && fabs(t[1]) < FAR && fabs(t[2]) < FAR;
}

static bool is_rigid(const lt_pose *p)
{
    return lt_pose_finite(p) && lt_rot_is_near(p->R, 1e-2) && is_near(p->t);
}

static lt_status draw(const target *t, const lt_pose *p, lt_arena *arena, float **out)
{
    float R[9], at[3];

    for (int i = 0; i < 9; i++)
        R[i] = (float)p->R[i];
    for (int i = 0; i < 3; i++)
        at[i] = (float)p->t[i];
    *out = lt_arena_array(arena, DEXYCB_WIDTH * DEXYCB_HEIGHT, sizeof(**out));
    if (!*out)
        return lt_error(LT_ENOMEM, "%s: no memory to draw the object", t->o->name);
    return silhouette_depth(&t->o->mesh, R, at, &t->scene->camera, *out, DEXYCB_WIDTH, DEXYCB_HEIGHT, arena);
}

static lt_status count_vsd(const target *t, lt_arena *arena, int64_t *hits)
{
    const eval_vsd_view view = { DEXYCB_WIDTH, DEXYCB_HEIGHT, t->scene->camera, t->scene->depth, DELTA,
                                 t->model->diameter };
    double tau[STEPS], errors[STEPS];
    float *at_e, *at_g;
    lt_status st = draw(t, &t->e, arena, &at_e);

    if (!st)
        st = draw(t, &t->g, arena, &at_g);
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

static lt_status count_surface(const target *t, lt_arena *arena, int64_t hits[2])
{
    const int n = t->o->mesh.n_vertices;
    const bop_model *m = t->model;
    double *x = lt_arena_array(arena, 3 * (size_t)n, sizeof(*x)), mssd, mspd;

    if (!x)
        return lt_error(LT_ENOMEM, "%s: no memory for %d vertices", t->o->name, n);
    for (int i = 0; i < 3 * n; i++)
        x[i] = t->o->mesh.vertex[i / 3][i % 3];
    mssd = eval_mssd(n, x, &t->e, &t->g, m->n_symmetries, m->symmetry);
    mspd = eval_mspd(n, x, &t->e, &t->g, m->n_symmetries, m->symmetry, &t->scene->camera);
    for (int step = 0; step < STEPS; step++) {
        hits[0] += mssd < share(step) * m->diameter;
        hits[1] += mspd < 5 * (step + 1) * DEXYCB_WIDTH / WIDTH;
    }
    return LT_OK;
}

static lt_status measure(target *t, const bop_estimate *estimate, lt_arena *arena, totals *out)
{
    lt_status st;

    *out = (totals){ .targets = 1, .estimated = estimate != NULL };
    if (!estimate || !is_rigid(&estimate->pose))
        return LT_OK;
    t->e = estimate->pose;
    st = count_vsd(t, arena, &out->hits[0]);
    return st ? st : count_surface(t, arena, &out->hits[1]);
}

/* ---- one frame ---- */

typedef struct {
    int64_t index;                  /* of the sample */
    totals all, grasped;
    slip_pose pose[DEXYCB_MAX_OBJECTS];         /* the estimates that are poses */
    int n_poses;
    lt_outcome outcome;
} frame;

typedef struct {
    const dataset *d;
    const char *models_info;        /* NULL: what the dataset's models show */
    bop_model model[YCB_COUNT + 1];
    bop_file file;
    frame *frame;
    slip_pose *look;                /* (LOOK), n_look of them: the first that are scored */
    int n_look;
} job;

static void keep_pose(const target *t, frame *f)
{
    slip_pose *p = &f->pose[f->n_poses++];

    *p = (slip_pose){ .found = t->e, .wanted = t->g };
    for (int i = 0; i < 8 * 3; i++)
        p->corner[i / 3][i % 3] = (double)t->o->control[i / 3][i % 3];
    if (t->o->ycb_id)
        memcpy(p->centre, ycb_find(t->o->ycb_id)->centre, sizeof(p->centre));
}

static lt_status measure_frame(const job *j, frame *f, lt_arena *arena)
{
    const dexycb_place place = dexycb_place_of(j->d, f->index);
    dexycb_scene s;
    lt_status st = dexycb_read_scene(j->d, f->index, arena, &s);

    for (int i = 0; !st && i < place.n_targets; i++) {
        const int id = place.target[i];
        target t = { .o = s.model[i], .model = &j->model[id], .scene = &s };
        const bop_estimate *estimate;
        totals one;
        if (!s.pose[i].known)
            continue;
        if (j->models_info && !(t.model->diameter > 0))
            return lt_error(LT_EFORMAT, "%s: has no object %d, %s", j->models_info, id, t.o->name);
        t.g = lt_pose_of(s.pose[i].R, s.pose[i].t);
        estimate = bop_file_find(&j->file, place.scene, place.image, id);
        st = measure(&t, estimate, arena, &one);
        add(&f->all, &one);
        if (estimate && is_rigid(&estimate->pose))
            keep_pose(&t, f);
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

    lt_outcome_keep(&f->outcome, arena ? measure_frame(j, f, arena)
                                       : lt_error(LT_ENOMEM, "no memory to score object poses"));
    lt_arena_free(arena);
}

/* ---- all frames ---- */

static lt_status measure_block(job *j, int64_t n, totals *all, totals *grasped)
{
    lt_parallel_for(n, frame_task, j);
    for (int64_t i = 0; i < n; i++) {
        const lt_status st = lt_outcome_tell(&j->frame[i].outcome);

        if (st)
            return st;
        add(all, &j->frame[i].all);
        add(grasped, &j->frame[i].grasped);
        for (int k = 0; k < j->frame[i].n_poses && j->n_look < LOOK; k++)
            j->look[j->n_look++] = j->frame[i].pose[k];
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

static lt_status prepare(job *j, lt_arena *arena, const char *path)
{
    lt_status st;

    j->frame = arena ? lt_arena_array(arena, BLOCK, sizeof(*j->frame)) : NULL;
    j->look = arena ? lt_arena_array(arena, LOOK, sizeof(*j->look)) : NULL;
    if (!j->frame || !j->look)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    st = bop_file_read(arena, path, &j->file);
    if (st)
        return st;
    return j->models_info ? models_info_read(arena, j->models_info, j->model) : measure_models(j->d, arena, j->model);
}

/* ---- what is to be said of the file ---- */

static const bop_estimate *earlier(const bop_estimate *a, const bop_estimate *b)
{
    return !a || b->line < a->line ? b : a;
}

static void say_no_poses(const bop_file *file, const char *path, eval_notes *notes)
{
    const bop_estimate *first = NULL;
    int64_t n = 0;

    for (int64_t i = 0; i < file->n; i++)
        if (!is_rigid(&file->estimate[i].pose)) {
            first = earlier(first, &file->estimate[i]);
            n++;
        }
    if (n)
        eval_note(notes, "no-pose", "%s: %lld of %lld estimates are no pose and count as misses; the first, line %lld: "
                  "%s", path, (long long)n, (long long)file->n, (long long)first->line,
                  !is_near(first->pose.t) ? "t is not finite, or farther than 10 km" :
                  !lt_all_finite(9, first->pose.R) ? "R has a number that is not finite" : "R is no rotation matrix");
}

/* What of an estimate's ids occurs in the split. */
typedef struct { bool scene, image, keyframe, object; } known_ids;

static void look_up(const dataset *d, const bop_estimate *e, known_ids *known, int *last_scene)
{
    *known = (known_ids){ 0 };
    *last_scene = 0;
    for (int64_t i = 0; i < d->count; i++) {
        const dexycb_place p = dexycb_place_of(d, i);
        *last_scene = p.scene > *last_scene ? p.scene : *last_scene;
        if (p.scene != e->scene)
            continue;
        known->scene = true;
        known->image |= p.image == e->image;
        known->keyframe |= p.image == e->image && p.keyframe;
        for (int k = 0; k < p.n_targets; k++)
            known->object |= p.target[k] == e->object;
    }
}

/* All estimates of a target, of which the best counts, are for something. */
static void mark_targets(const dataset *d, const bop_file *file, bool *is_target)
{
    for (int64_t i = 0; i < d->count; i++) {
        const dexycb_place p = dexycb_place_of(d, i);
        for (int k = 0; p.keyframe && k < p.n_targets; k++) {
            const bop_estimate *e = bop_file_find(file, p.scene, p.image, p.target[k]);
            for (; e && e < file->estimate + file->n && e->scene == p.scene && e->image == p.image &&
                   e->object == p.target[k]; e++)
                is_target[e - file->estimate] = true;
        }
    }
}

static lt_status say_unknown(const dataset *d, const bop_file *file, const char *path, lt_arena *arena,
                             eval_notes *notes)
{
    bool *is_target = lt_arena_array(arena, (size_t)file->n, sizeof(*is_target));
    const bop_estimate *first = NULL;
    known_ids known;
    char why[96];
    int64_t n = 0;
    int last;

    if (!is_target)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    mark_targets(d, file, is_target);
    for (int64_t i = 0; i < file->n; i++)
        if (!is_target[i]) {
            first = earlier(first, &file->estimate[i]);
            n++;
        }
    if (!n)
        return LT_OK;
    look_up(d, first, &known, &last);
    if (!known.scene)
        snprintf(why, sizeof(why), "scene %d, and there are 0 to %d", first->scene, last);
    else if (!known.image)
        snprintf(why, sizeof(why), "scene %d has no image %d", first->scene, first->image);
    else if (!known.keyframe)
        snprintf(why, sizeof(why), "image %d of scene %d is no key frame", first->image, first->scene);
    else
        snprintf(why, sizeof(why), "scene %d has no object %d", first->scene, first->object);
    eval_note(notes, "unknown-id", "%s: %lld of %lld estimates are for nothing that is scored in split %s; the first, "
              "line %lld: %s", path, (long long)n, (long long)file->n, d->split, (long long)first->line, why);
    return LT_OK;
}

static void look_for_slip(const job *j, const char *path, eval_notes *notes)
{
    slip s;

    slip_in_poses(j->look, j->n_look, (slip_file){ 0 }, &s);
    if (s.code)
        eval_note(notes, s.code, "%s: it looks as if %s", path, s.text);
}

lt_status bop_score(const dataset *d, const char *path, const char *models_info, eval_notes *notes,
                    bop_progress progress, void *ctx, bop_recalls *out)
{
    lt_arena *arena = lt_arena_new();
    job j = { .d = d, .models_info = models_info };
    totals all = { 0 }, grasped = { 0 };
    int64_t count = 0;
    lt_status st = prepare(&j, arena, path);

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
    if (!st && notes) {
        say_no_poses(&j.file, path, notes);
        st = say_unknown(d, &j.file, path, arena, notes);
        look_for_slip(&j, path, notes);
    }
    if (!st)
        *out = (bop_recalls){ recall_of(&all), recall_of(&grasped) };
    lt_arena_free(arena);
    return st;
}
