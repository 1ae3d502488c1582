/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/results/evaluate.h"

#include "data/kind.h"
#include "libtensor/geometry/rotation.h"
#include "tasks/hogs/results/hold.h"
#include "tasks/hogs/results/surfaces.h"
#include "tasks/hogs/source.h"

#include <math.h>
#include <string.h>

enum { TRAINING_FRAMES = 2000 };                /* at most, that the mean offset is of */

/* ---- LPIPS of whole frames ------------------------------------------------------------------------------- */

/* In the network's weights, unless there is a file of others */
static lt_status open_lpips(hogs_evaluation *e)
{
    const hogs *m = hogs_of(e->run.m);

    return eval_lpips_new(&(eval_lpips_options){ .network = &m->lpips, .file = e->o->lpips, .n_files = e->o->n_lpips,
                                                 .height = m->config.height, .width = m->config.width }, &e->judge);
}

/* Of the frame drawn (3, H, W), cut to [0, 1] */
static lt_status score_lpips(const hogs_evaluation *e, const lt_real *drawn, const float *truth,
                             double out[HOGS_SCORES])
{
    const hogs *m = hogs_of(e->run.m);
    const int64_t pixels = (int64_t)m->config.width * m->config.height;
    float *cut = lt_alloc(3 * (size_t)pixels * sizeof(*cut));
    const eval_pictures p = { .a = cut, .b = truth, .channels = 3, .height = m->config.height,
                              .width = m->config.width, .plane = pixels, .row = m->config.width };
    eval_lpips_scores s;

    if (!cut)
        return lt_error(LT_ENOMEM, "no memory to score a frame");
    for (int64_t i = 0; i < 3 * pixels; i++)
        cut[i] = fminf(1, fmaxf(0, (float)drawn[i]));
    s = eval_lpips_score(e->judge, &p);
    lt_release(cut);
    out[HOGS_LPIPS_RAW01] = s.raw01;
    out[HOGS_LPIPS_SYM] = s.sym;
    return LT_OK;
}

/* ---- one frame ------------------------------------------------------------------------------------------- */

typedef struct {
    hogs_evaluation *e;
    hogs_row row;                   /* the model's, or swap */
    int64_t total, done;
} visitor;

static lt_status add_pose_row(hogs_evaluation *e, hogs_row row, const hogs_frame *f, const float R[9], const float t[3])
{
    double scores[HOGS_SCORES];
    lt_status st;

    hogs_score_clear(scores);
    st = hogs_score_pose(e->run.train, f, R, t, scores);
    if (!st)
        st = hogs_score_contact(&e->touch, hogs_of(e->run.m), f, R, t, scores);
    if (!st)
        hogs_means_add(&e->means[row], scores);
    return st;
}

/* The initial pose moved by what training frames were off in the mean */
static lt_status add_mean_row(hogs_evaluation *e, const hogs_frame *f)
{
    double R[9], turned[9];
    float rotation[9], t[3];

    for (int k = 0; k < 9; k++)
        R[k] = (double)(f->initial.R[k] + e->mean_R[k]);
    lt_rot_nearest(R, turned);
    for (int k = 0; k < 9; k++)
        rotation[k] = (float)turned[k];
    for (int k = 0; k < 3; k++)
        t[k] = f->initial.t[k] + e->mean_t[k];
    return add_pose_row(e, HOGS_ROW_MEAN, f, rotation, t);
}

static void put_pixel(uint8_t *out, const float *planes, int64_t n, int64_t i)
{
    for (int c = 0; c < 3; c++)
        out[c] = (uint8_t)lround(255 * (double)fminf(1, fmaxf(0, planes[c * n + i])));
}

/* What is true of hand and object, what was drawn of both, of the hand, of the object */
static void keep_picture(hogs_evaluation *e, const hogs_frame *f, const lt_real *drawn, int picture)
{
    const hogs *m = hogs_of(e->run.m);
    const int64_t W = m->config.width, H = m->config.height, n = W * H;
    const float *panel[HOGS_PANELS] = { f->target, drawn, drawn + 3 * n, drawn + 6 * n };

    for (int p = 0; p < HOGS_PANELS; p++)
        for (int64_t i = 0; i < n; i++)
            put_pixel(e->picture + 3 * (((int64_t)picture * H + i / W) * HOGS_PANELS * W + p * W + i % W), panel[p], n,
                      i);
}

/* What of surfaces counts in a frame whose truth is known. HOLD compares shapes in the first of each sequence. */
static hogs_surfaces_wanted wanted_of(const hogs_evaluation *e, const hogs_frame *f)
{
    const bool known = f->known, held = e->held && e->held[f->number];

    return (hogs_surfaces_wanted){
        .shapes = known && e->meshed[f->number], .pose = known && (e->held ? held : e->meshed[f->number]),
        .vertices = known && held && !e->begun[e->sequence[f->number]],
    };
}

/* What was measured of surfaces, into the frame's scores and rows of their own */
static lt_status score_surfaces(hogs_evaluation *e, const hogs_frame *f, const compiled *c, double *scores)
{
    const hogs_surfaces_wanted wanted = wanted_of(e, f);
    hogs_surface_scores s;
    lt_status st;

    if (!wanted.shapes && !wanted.pose)
        return LT_OK;
    st = hogs_score_surfaces(&e->touch, hogs_of(e->run.m), f, c, wanted, &s);
    if (st)
        return st;
    for (int i = HOGS_CD_H; i < HOGS_SCORES; i++)
        scores[i] = s.model[i];
    e->no_surface += s.failed;
    if (e->held && wanted.pose) {
        hogs_means_add(&e->by_sequence[e->sequence[f->number]], s.model);
        e->begun[e->sequence[f->number]] = true;
        e->held_frames++;
    }
    if (!wanted.shapes)
        return LT_OK;
    hogs_means_add(&e->means[HOGS_ROW_NO_ROTATION], s.no_rotation);
    hogs_means_add(&e->means[HOGS_ROW_MINIMUM], s.minimum);
    e->has[HOGS_ROW_NO_ROTATION] = e->has[HOGS_ROW_MINIMUM] = true;
    e->meshes++;
    return LT_OK;
}

static lt_status score_model(visitor *v, const hogs_frame *f, const compiled *c)
{
    hogs_evaluation *e = v->e;
    const lt_real *drawn = compiled_output(c, "frame"), *R = compiled_output(c, "pose_rotation"),
                  *t = compiled_output(c, "pose_translation");
    double *scores = e->per_sample[e->samples];
    lt_status st = hogs_score_frame(e->run.m, e->run.train, f, c, scores);

    if (!st)
        st = hogs_score_contact(&e->touch, hogs_of(e->run.m), f, R, t, scores);
    if (!st)
        st = add_pose_row(e, HOGS_ROW_INITIAL, f, f->initial.R, f->initial.t);
    if (!st && e->has[HOGS_ROW_MEAN])
        st = add_mean_row(e, f);
    if (!st)
        st = score_surfaces(e, f, c, scores);
    if (!st)
        st = score_lpips(e, drawn, f->target, scores);
    if (st)
        return st;
    hogs_means_add(&e->means[HOGS_ROW_MODEL], scores);
    if (e->pictures < HOGS_PICTURES && v->done >= e->pictures * v->total / HOGS_PICTURES)
        keep_picture(e, f, drawn, e->pictures++);
    e->name[e->samples++] = dataset_name(e->run.train, f->index);
    return LT_OK;
}

static lt_status visit(void *ctx, const compiled *c, const void *batch)
{
    visitor *v = ctx;
    const hogs_batch *b = batch;
    const hogs_frame *f = &b->frame[0];
    double scores[HOGS_SCORES];
    lt_status st = LT_OK;

    if (b->count && f->there && v->row == HOGS_ROW_MODEL)
        st = score_model(v, f, c);
    else if (b->count && f->there) {
        hogs_score_clear(scores);
        st = hogs_score_images(hogs_of(v->e->run.m), f, compiled_output(c, "frame"), scores);
        if (!st)
            st = score_lpips(v->e, compiled_output(c, "frame"), f->target, scores);
        hogs_means_add(&v->e->means[v->row], scores);
    }
    v->done++;
    if (!st && v->e->o->progress && !v->e->o->progress(v->e->o->ctx, v->done, v->total))
        return lt_error(LT_ESTOPPED, "stopped");
    return st;
}

static void skipped(void *ctx, int i, const char *line)
{
    (void)ctx, (void)i, (void)line;             /* nothing is tolerated */
}

/* ---- the mean offset of the training frames -------------------------------------------------------------- */

static lt_status add_offset(const dataset *d, const initial_poses *poses, int64_t i, double sum[12], int64_t *n)
{
    const initial_pose *p = initial_poses_at(poses, i);
    lt_arena *arena = p && p->has_hand && p->has_object ? lt_arena_new() : NULL;
    dataset_sample s;
    lt_status st = LT_OK;

    if (!arena)
        return LT_OK;
    st = dataset_annotation(d, i, arena, &s);
    if (!st && (s.flags & SAMPLE_OBJECT) && (s.flags & SAMPLE_ROOT)) {
        for (int k = 0; k < 9; k++)
            sum[k] += (double)s.R[k] - p->R[k];
        for (int k = 0; k < 3; k++)
            sum[9 + k] += ((double)s.t[k] - (double)s.root[k]) - (p->t[k] - p->wrist[k]);
        (*n)++;
    }
    lt_arena_free(arena);
    return st;
}

/* Without training data there is no such row. */
static lt_status find_mean_offset(hogs_evaluation *e)
{
    task_run training = { .arena = e->arena, .config = e->run.config };
    double sum[12] = { 0 };
    int64_t n = 0, count;
    lt_status st = hogs_open_data(&training, e->o->config, "train");

    count = st ? 0 : lt_min_i64(training.train->count, TRAINING_FRAMES);
    for (int64_t i = 0; i < count && !st; i++)
        st = add_offset(training.train, training.train_poses, i * training.train->count / count, sum, &n);
    hogs_close_data(&training);
    if (st == LT_ENOMEM)
        return st;
    e->has[HOGS_ROW_MEAN] = !st && n > 0;
    for (int k = 0; k < 9 && e->has[HOGS_ROW_MEAN]; k++)
        e->mean_R[k] = (float)(sum[k] / (double)n);
    for (int k = 0; k < 3 && e->has[HOGS_ROW_MEAN]; k++)
        e->mean_t[k] = (float)(sum[9 + k] / (double)n);
    return LT_OK;
}

/* ---- another frame's image ------------------------------------------------------------------------------- */

/* Whose hand and which object a frame of a split shows */
typedef struct { int subject, object; } pair;

static lt_status pairs_of(lt_arena *arena, const dataset *d, const pair **out)
{
    pair *p = lt_arena_array(arena, (size_t)d->count, sizeof(*p));
    lt_arena *scratch = lt_arena_new();
    lt_status st = p && scratch ? LT_OK : lt_error(LT_ENOMEM, "no memory for %lld frames", (long long)d->count);

    for (int64_t i = 0; i < d->count && !st; i++) {
        dataset_sample s;

        st = dataset_annotation(d, i, scratch, &s);
        if (!st)
            p[i] = (pair){ d->kind->subject(s.name), s.object < 0 ? -1 : d->objects[s.object].ycb_id };
    }
    lt_arena_free(scratch);
    *out = p;
    return st;
}

/* For each frame one of the same hand and object in another sequence; -1: there is none */
static lt_status choose_others(hogs_evaluation *e, const dataset *from, int64_t *out)
{
    const hogs_source *s = &e->run.check_source;
    const pair *own, *other;
    lt_status st = pairs_of(e->arena, s->data, &own);

    if (!st)
        st = pairs_of(e->arena, from, &other);
    for (int64_t i = 0; i < s->count && !st; i++) {
        const char *name = dataset_name(s->data, s->index[i]);
        const pair mine = own[s->index[i]];

        out[i] = -1;
        for (int64_t k = 0; k < from->count && out[i] < 0; k++) {
            const int64_t at = (s->index[i] * 7919 + k) % from->count;

            if (other[at].subject == mine.subject && other[at].object == mine.object
                && !hogs_same_sequence(name, dataset_name(from, at)))
                out[i] = at;
        }
    }
    return st;
}

static lt_status run_over(hogs_evaluation *e, const compiled *c, hogs_row row)
{
    hogs_source *s = &e->run.check_source;
    const loader_source frames = hogs_frames_loader(s);
    visitor v = { .e = e, .row = row, .total = s->count };

    e->has[row] = true;
    return compiled_walk(c, &frames, e->run.config->data->threads, 0, visit, skipped, &v, NULL);
}

/* Of training's frames, as a split may have one sequence alone of a hand with an object */
static lt_status run_swapped(hogs_evaluation *e, const compiled *c)
{
    task_run training = { .arena = e->arena, .config = e->run.config };
    int64_t *others = lt_arena_array(e->arena, (size_t)e->run.check_source.count, sizeof(*others));
    lt_status st = others ? LT_OK : lt_error(LT_ENOMEM, "no memory for the frames");

    if (!st && hogs_open_data(&training, e->o->config, "train")) {
        hogs_close_data(&training);
        return LT_OK;                           /* without training data there is no such row */
    }
    if (!st)
        st = choose_others(e, training.train, others);
    if (!st) {
        e->run.check_source.shown = training.train;
        e->run.check_source.show_as = others;
        st = run_over(e, c, HOGS_ROW_SWAP);
    }
    hogs_close_data(&training);
    return st;
}

/* ---- all of it ------------------------------------------------------------------------------------------- */

static lt_status choose_frames(hogs_evaluation *e)
{
    task_run *r = &e->run;
    hogs_source *s = &r->check_source;
    const int64_t *index;
    int64_t count, *some;
    lt_status st;

    *s = hogs_source_of(r, r->train, r->train_poses);
    st = hogs_frames_of(e->arena, r->train, r->train_poses, &index, &count);
    if (st)
        return st;
    s->count = e->o->limit ? lt_min_i64(count, e->o->limit) : count;
    s->index = some = lt_arena_array(e->arena, (size_t)s->count, sizeof(*some));
    e->name = lt_arena_array(e->arena, (size_t)s->count, sizeof(*e->name));
    e->per_sample = lt_arena_array(e->arena, (size_t)s->count, sizeof(*e->per_sample));
    e->picture = lt_arena_array(e->arena, (size_t)HOGS_PICTURES * HOGS_PANELS * 3 * (size_t)hogs_of(r->m)->config.width,
                                (size_t)hogs_of(r->m)->config.height);
    if (!some || !e->name || !e->per_sample || !e->picture)
        return lt_error(LT_ENOMEM, "no memory to score %lld frames", (long long)s->count);
    for (int64_t i = 0; i < s->count; i++)
        some[i] = index[i * count / s->count];
    return LT_OK;
}

/* Of each object so many frames, spread over its own */
static lt_status choose_meshed(hogs_evaluation *e)
{
    const hogs_source *s = &e->run.check_source;
    const int wanted = e->o->meshes;
    const pair *shown;
    lt_status st = LT_OK;

    e->meshed = lt_arena_array(e->arena, (size_t)s->count, sizeof(*e->meshed));
    if (!e->meshed)
        return lt_error(LT_ENOMEM, "no memory for %lld frames", (long long)s->count);
    if (wanted)
        st = pairs_of(e->arena, s->data, &shown);
    for (int64_t i = 0; i < s->count && !st && wanted; i++) {
        int64_t before = 0, all = 0;

        for (int64_t k = 0; k < s->count; k++) {
            const bool same = shown[s->index[k]].object == shown[s->index[i]].object;

            before += same && k < i;
            all += same;
        }
        /* the first of each of `wanted` equal stretches of them */
        e->meshed[i] = all <= wanted || before == 0 || before * wanted / all != (before - 1) * wanted / all;
    }
    return st;
}

static lt_status score_all(hogs_evaluation *e)
{
    const recipe by = hogs_recipe(&e->run, HOGS_RENDER);
    compiled c = { 0 };
    lt_status st = open_lpips(e);

    if (!st)
        st = compiled_new(&by, 1, false, &c);
    if (!st)
        st = run_over(e, &c, HOGS_ROW_MODEL);
    hogs_hold_average(e);
    e->has[HOGS_ROW_INITIAL] = true;
    if (!st && hogs_of(e->run.m)->is->colour)
        st = run_swapped(e, &c);
    compiled_free(&c);
    return st;
}

static lt_status open_and_score(hogs_evaluation *e, lt_params *set)
{
    lt_status st = hogs_open_data(&e->run, e->o->config, e->o->split);

    if (!st)
        st = hogs_open_model(&e->run, e->o->checkpoint, set);
    if (!st)
        st = choose_frames(e);
    if (!st)
        st = choose_meshed(e);
    if (!st)
        st = hogs_hold_choose(e);
    if (!st)
        st = hogs_touch_open(e->arena, e->run.train, e->run.hands.right, &e->touch);
    if (!st)
        st = find_mean_offset(e);
    return st ? st : score_all(e);
}

lt_status hogs_evaluate(const task_evaluation *o, struct cJSON **scores)
{
    hogs_evaluation *e = lt_arena_alloc(o->arena, sizeof(*e));
    lt_params *set = lt_params_new();
    model m;
    lt_status st;

    *scores = NULL;
    if (!e || !set) {
        lt_params_free(set);
        return lt_error(LT_ENOMEM, "no memory to score a model");
    }
    *e = (hogs_evaluation){ .o = o, .arena = o->arena, .run = { .arena = o->arena, .config = o->config, .m = &m } };
    if (o->hand)
        ((hogs_data_config *)o->config->data)->hand = o->hand;
    st = open_and_score(e, set);
    if (!st) {
        *scores = hogs_evaluation_json(e);
        st = *scores ? hogs_evaluation_write(e, *scores) : lt_error(LT_ENOMEM, "no memory for the scores");
    }
    if (!st && o->tables)
        st = hogs_evaluation_print(e, o->tables, EVAL_TEXT);
    eval_lpips_free(e->judge);
    hogs_lists_free(&e->run.lists);
    hogs_close_data(&e->run);
    lt_params_free(set);
    return st;
}
