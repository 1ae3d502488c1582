/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Two views a shape, of the YCB stand-ins and of drawn shapes. Sample i of an epoch is a function of both and of the
 * seed; shapes that validation looks at are drawn from another stream, and never trained on.
 */
#include "tasks/point_pairs/task.h"

#include "assets/ycb/objects.h"
#include "models/points/points.h"
#include "tasks/point_pairs/shapes.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SHAPES = 1, HELD_OUT, VIEWS };           /* random streams */

typedef struct {
    train_data_config common;
    int shapes, held_out;
} point_pairs_config;

#define DATA(field) #field, .offset = offsetof(point_pairs_config, field)

static const lt_config_key data_keys[] = {
    TRAIN_DIR_KEY(point_pairs_config),
    { DATA(shapes), .type = LT_CONFIG_INT, .fallback = "1003", .lo = 0, .hi = 1000000,
      .doc = "drawn shapes to train on, beside 21 stand-ins of YCB's objects" },
    { DATA(held_out), .type = LT_CONFIG_INT, .fallback = "128", .lo = 2, .hi = 4096,
      .doc = "drawn shapes to validate on" },
    TRAIN_LOADER_KEYS(point_pairs_config),
    { .name = NULL },
};

/* What views are taken of. */
typedef struct {
    const task_run *run;
    int stream;                     /* of the shapes: SHAPES, behind the stand-ins, or HELD_OUT */
    int64_t count;
} shape_set;

struct task_run {
    const train_config *config;
    model *model;
    lt_mesh stand_in[YCB_COUNT];
    shape_set trained, checked;
};

/* ---- batches ---- */

typedef struct {
    int count, points;              /* of a view */
    int64_t *index;
    bool *there;
    lt_real (*view)[3];             /* (capacity, 2, points) */
} batch;

static void batch_free(void *batch_)
{
    batch *b = batch_;

    if (!b)
        return;
    free(b->index);
    free(b->there);
    free(b->view);
    free(b);
}

static void *batch_new(const void *ctx, int capacity)
{
    const size_t n = (size_t)capacity;
    batch *b = calloc(1, sizeof(*b));

    if (!b)
        return NULL;
    b->points = points_view(((const shape_set *)ctx)->run->model);
    b->index = calloc(n, sizeof(*b->index));
    b->there = calloc(n, sizeof(*b->there));
    b->view = calloc(2 * n * (size_t)b->points, sizeof(*b->view));
    if (b->index && b->there && b->view)
        return b;
    batch_free(b);
    return NULL;
}

static void batch_start(void *b, int count)
{
    ((batch *)b)->count = count;
}

static lt_real (*view_of(const batch *b, int slot, int k))[3]
{
    return b->view + (size_t)(2 * slot + k) * (size_t)b->points;
}

static lt_status shape_of(const shape_set *s, int64_t index, lt_arena *arena, lt_mesh *out)
{
    const uint64_t seed = (uint64_t)s->run->config->loop.seed;
    lt_rng rng = lt_rng_make(seed, lt_rng_mix((uint64_t)s->stream, (uint64_t)index));

    if (s->stream == SHAPES && index < YCB_COUNT) {
        *out = s->run->stand_in[index];
        return LT_OK;
    }
    return shape_draw(arena, &rng, out);
}

static lt_status batch_fill(const void *ctx, uint64_t epoch, int64_t index, lt_arena *scratch, void *batch_, int slot)
{
    const shape_set *s = ctx;
    const uint64_t of_shape = lt_rng_mix((uint64_t)(VIEWS + s->stream), (uint64_t)index);
    lt_rng rng = lt_rng_make((uint64_t)s->run->config->loop.seed, lt_rng_mix(of_shape, epoch));
    batch *b = batch_;
    lt_mesh mesh;
    lt_status st = shape_of(s, index, scratch, &mesh);

    for (int k = 0; !st && k < 2; k++)
        st = shape_view(scratch, &mesh, &rng, b->points, view_of(b, slot, k));
    b->index[slot] = index;
    b->there[slot] = !st;
    return st;
}

static void batch_skip(void *b, int slot, int64_t index)
{
    ((batch *)b)->index[slot] = index;
    ((batch *)b)->there[slot] = false;
}

static double batch_weight(const void *batch_)
{
    const batch *b = batch_;
    double sum = 0;

    for (int i = 0; i < b->count; i++)
        sum += b->there[i];
    return sum;
}

static const char *shape_name(const void *ctx, int64_t index)
{
    const shape_set *s = ctx;

    return s->stream == SHAPES && index < YCB_COUNT ? ycb_find((int)index + 1)->name : "a drawn shape";
}

static loader_source source_of(const shape_set *s)
{
    return (loader_source){ .ctx = s, .count = s->count, .name = shape_name, .batch_new = batch_new,
                            .batch_free = batch_free, .start = batch_start, .fill = batch_fill, .skip = batch_skip };
}

/* ---- opening ---- */

static lt_status run_open(lt_arena *arena, train_config *c, task_run **out)
{
    const point_pairs_config *d = (const point_pairs_config *)c->data;
    task_run *r = lt_arena_alloc(arena, sizeof(*r));
    lt_status st = LT_OK;

    *out = r;
    if (!r)
        return lt_error(LT_ENOMEM, "no memory to begin");
    r->config = c;
    r->trained = (shape_set){ r, SHAPES, YCB_COUNT + d->shapes };
    r->checked = (shape_set){ r, HELD_OUT, d->held_out };
    for (int i = 0; !st && i < YCB_COUNT; i++)
        st = synth_object_new(arena, i + 1, &r->stand_in[i]);
    return st;
}

static void run_close(task_run *r)
{
    (void)r;
}

static lt_status run_build(task_run *r, const train_config *c, lt_params *set, model *out)
{
    r->model = out;
    return train_config_model(c, NULL, set, out);
}

static void run_describe(const task_run *r, train_progress *p)
{
    progress_note(p, "data         two views of %d points of each of %lld shapes, %d of them YCB's stand-ins; %lld "
                  "held out", points_view(r->model), (long long)r->trained.count, YCB_COUNT,
                  (long long)r->checked.count);
}

static void run_facts(const task_run *r, cJSON *env)
{
    (void)r;
    cJSON_AddStringToObject(env, "data", "stand-ins and drawn shapes");
    cJSON_AddBoolToObject(env, "synthetic_data", true);
}

static loader_source run_samples(const task_run *r)
{
    return source_of(&r->trained);
}

static loader_source run_checked(const task_run *r)
{
    return source_of(&r->checked);
}

static size_t run_sample_bytes(const task_run *r)
{
    return 2 * (size_t)points_view(r->model) * 3 * sizeof(lt_real);
}

static const char *run_sample_name(const task_run *r, const void *batch_, int i)
{
    const batch *b = batch_;

    return i < b->count ? shape_name(&r->trained, b->index[i]) : NULL;
}

/* ---- the graph ---- */

static lt_status record(const void *m, model_record *r)
{
    ((const model *)m)->cls->record(m, true, r);
    return LT_OK;
}

static lt_real *input(const lt_plan *p, const model_record *r, const char *name)
{
    return lt_plan_data(p, model_port_find(&r->inputs, name));
}

/* A place without a sample gets the views of one that is there, for batch norm, and is nobody's other. */
static double feed(const void *ctx, const lt_plan *p, const model_record *r, const void *batch_, int first, int part,
                   int n)
{
    static const lt_real NOBODY = (lt_real)-1e4;
    const batch *b = batch_;
    const size_t view = 3 * (size_t)b->points;
    lt_real *points = input(p, r, "points"), *others = input(p, r, "others"), *weight = input(p, r, "weight");
    const int rows = 2 * r->batch;
    double sum = 0;

    (void)ctx, (void)part, (void)n;
    for (int i = 0; i < r->batch && b->count; i++) {
        const bool there = first + i < b->count && b->there[first + i];
        const int from = first + i < b->count ? first + i : b->count - 1;

        memcpy(points + 2 * (size_t)i * view, view_of(b, from, 0), 2 * view * sizeof(*points));
        weight[2 * i] = weight[2 * i + 1] = there;
        sum += there;
    }
    for (int i = 0; i < rows * rows; i++)
        others[i] = i / rows == i % rows || !(weight[i % rows] > 0) ? NOBODY : 0;
    return sum;
}

static recipe run_recipe(const task_run *r, const task_phase *phase)
{
    (void)phase;
    return (recipe){ .ctx = r->model, .record = record, .feed = feed };
}

/* ---- scores ---- */

/* A record a sample: the embeddings of both views. */
typedef struct { lt_real view[2][POINTS_EMBEDDING]; } pair;

static lt_status run_score(task_run *r, const compiled *c, const void *batch_, records *out, bool *no_losses)
{
    const batch *b = batch_;
    const lt_real *embedding = compiled_output(c, "embedding");
    lt_status st = LT_OK;

    (void)r, (void)no_losses;
    for (int i = 0; !st && i < b->count; i++)
        if (b->there[i])
            st = records_add(out, b->index[i], embedding + 2 * (size_t)i * POINTS_EMBEDDING, sizeof(pair));
    return st;
}

static double similarity(const lt_real *a, const lt_real *b)
{
    double sum = 0;

    for (int k = 0; k < POINTS_EMBEDDING; k++)
        sum += (double)a[k] * b[k];
    return sum;
}

static const lt_real *embedding_of(const records *all, int64_t view)
{
    const pair *p = records_at(all, view / 2, NULL);

    return p->view[view % 2];
}

/* Whether no other view is nearer than the twin. */
static bool finds_twin(const records *all, int64_t view)
{
    const lt_real *mine = embedding_of(all, view);
    const double twin = similarity(mine, embedding_of(all, view ^ 1));

    for (int64_t i = 0; i < 2 * all->n; i++)
        if (i != view && i != (view ^ 1) && !(similarity(mine, embedding_of(all, i)) < twin))
            return false;
    return true;
}

static void run_measure(task_run *r, const records *all, double *out)
{
    int64_t found = 0;

    (void)r;
    for (int64_t i = 0; i < 2 * all->n; i++)
        found += finds_twin(all, i);
    out[0] = all->n ? (double)found / (2 * (double)all->n) : NAN;
}

static const char *const metrics[] = { "twins_found", NULL };
static const metric own_metrics[] = {
    { "twins_found", "twins", "", true, "share of views whose nearest other view is of the same held-out shape",
      "palmar" },
    { .key = NULL },
};

const task point_pairs_task = {
    .name = "point-pairs", .data_size = sizeof(point_pairs_config), .data_keys = data_keys,
    .metrics = metrics, .own_metrics = own_metrics, .open = run_open, .close = run_close, .build = run_build,
    .describe = run_describe, .facts = run_facts, .samples = run_samples, .checked = run_checked,
    .sample_bytes = run_sample_bytes, .recipe = run_recipe, .weight = batch_weight, .sample_name = run_sample_name,
    .score = run_score, .measure = run_measure,
};
