/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A task of one's own, outside of palmar's tree: how many dots are in a picture. The pictures are drawn as they are
 * needed, so there are no files. Checkpoints, resume, shards, ranks, log and progress come from the trainer.
 *
 *     own_task runs/dots
 */
#include "libtensor/base/rng.h"
#include "libtensor/nn/init.h"
#include "libtensor/nn/layers.h"
#include "train/trainer.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 32, MOST = 9, TRAINED = 512, CHECKED = 64 };

/* ---- the model ------------------------------------------------------------------------------------------------- */

typedef struct { int width; } counter_config;

typedef struct {
    counter_config config;
    lt_conv_layer conv[2];
    lt_linear_layer out;
} counter;

static const lt_config_key model_keys[] = {
    { .name = "width", .offset = offsetof(counter_config, width), .type = LT_CONFIG_INT, .fallback = "16", .lo = 1,
      .hi = 256, .doc = "channels" },
    { .name = NULL },
};

static const char *const variants[] = { "full", NULL }, *const blocks[] = { "conv", "out", NULL };

static void build(model *self, const lt_hand_layer *hand)
{
    counter *m = self->self;
    const lt_conv_opts opts = { .stride = 2, .pad = 2 };

    (void)hand;
    self->variant = variants[0];
    self->image_size = SIDE;
    m->conv[0] = lt_conv_layer_new(self->params, "conv.0", 1, m->config.width, 5, true, &opts);
    m->conv[1] = lt_conv_layer_new(self->params, "conv.1", m->config.width, m->config.width, 5, true, &opts);
    m->out = lt_linear_layer_new(self->params, "out", m->config.width, 1, true);
}

static void init(const model *self, uint64_t seed)
{
    lt_init_default(self->params, seed);
}

static void record(const model *self, bool losses, model_record *r)
{
    const counter *m = self->self;
    lt_tensor *x = model_input(r, "picture", LT_SHAPE(r->batch, 1, SIDE, SIDE)), *weight, *truth;

    for (int i = 0; i < 2; i++)
        x = lt_relu(lt_conv_layer_forward(&m->conv[i], x));
    x = lt_scale(lt_linear_layer_forward(&m->out, lt_global_avg_pool(x)), MOST);
    model_port_add(&r->outputs, "count", lt_output(x, "count"));
    if (!losses)
        return;
    truth = model_input(r, "truth", LT_SHAPE(r->batch, 1));
    weight = model_input(r, "weight", LT_SHAPE(r->batch));
    r->loss = lt_output(lt_mse_loss(x, truth, weight), "loss");
    model_port_add(&r->losses, "count", r->loss);
}

static const model_class counter_class = {
    .name = "counter", .size = sizeof(counter), .paper = "none", .task = "dots", .variants = variants,
    .keys = model_keys, .blocks = blocks, .build = build, .init = init, .record = record,
};

/* ---- the data: sample i of epoch e is a function of both ------------------------------------------------------- */

typedef struct { train_data_config common; } dots_data;

static const lt_config_key data_keys[] = { TRAIN_DIR_KEY(dots_data), TRAIN_LOADER_KEYS(dots_data), { .name = NULL } };

typedef struct {
    int count;
    int64_t *index;
    lt_real *weight, *truth, (*picture)[SIDE * SIDE];
} batch;

static void *batch_new(const void *ctx, int capacity)
{
    const size_t n = (size_t)capacity;
    batch *b = calloc(1, sizeof(*b));

    (void)ctx;
    if (!b)
        return NULL;
    b->index = calloc(n, sizeof(*b->index));
    b->weight = calloc(n, sizeof(*b->weight));
    b->truth = calloc(n, sizeof(*b->truth));
    b->picture = calloc(n, sizeof(*b->picture));
    return b;
}

static void batch_free(void *batch_)
{
    batch *b = batch_;

    if (!b)
        return;
    free(b->index);
    free(b->weight);
    free(b->truth);
    free(b->picture);
    free(b);
}

static void start(void *b, int count)
{
    ((batch *)b)->count = count;
}

/* Called from several threads, for different slots */
static lt_status draw(const void *seed, uint64_t epoch, int64_t index, lt_arena *scratch, void *batch_, int slot)
{
    batch *b = batch_;
    lt_rng rng = lt_rng_make(*(const uint64_t *)seed, epoch << 32 | (uint64_t)index);
    const int dots = (int)lt_rng_range(&rng, 0, MOST + 1);

    (void)scratch;
    memset(b->picture[slot], 0, sizeof(b->picture[slot]));
    for (int i = 0; i < dots; i++) {
        const int x = (int)lt_rng_range(&rng, 0, SIDE - 1), y = (int)lt_rng_range(&rng, 0, SIDE - 1);

        for (int k = 0; k < 4; k++)
            b->picture[slot][(y + k / 2) * SIDE + x + k % 2] = 1;
    }
    b->index[slot] = index;
    b->truth[slot] = (lt_real)dots;
    b->weight[slot] = 1;
    return LT_OK;
}

static void skip(void *b, int slot, int64_t index)
{
    ((batch *)b)->index[slot] = index;
    ((batch *)b)->weight[slot] = 0;
}

static const char *name(const void *ctx, int64_t index)
{
    (void)ctx;
    (void)index;
    return "a drawn picture";
}

static loader_source source(const uint64_t *seed, int64_t count)
{
    return (loader_source){ .ctx = seed, .count = count, .name = name, .batch_new = batch_new,
                            .batch_free = batch_free, .start = start, .fill = draw, .skip = skip };
}

/* ---- the task -------------------------------------------------------------------------------------------------- */

struct task_run {
    uint64_t trained, checked;          /* seeds */
    const model *model;
};

static lt_status run_open(lt_arena *arena, train_config *c, task_run **out)
{
    *out = lt_arena_alloc(arena, sizeof(**out));
    if (!*out)
        return lt_error(LT_ENOMEM, "no memory");
    (*out)->trained = 2 * (uint64_t)c->loop.seed;
    (*out)->checked = (*out)->trained + 1;
    return LT_OK;
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

static void describe(const task_run *r, train_progress *p)
{
    (void)r;
    progress_note(p, "data         pictures of 0 to %d dots, drawn as they are needed", MOST);
}

static void facts(const task_run *r, cJSON *env)
{
    (void)r;
    cJSON_AddStringToObject(env, "data", "dots");
    cJSON_AddBoolToObject(env, "synthetic_data", true);
}

static loader_source samples(const task_run *r)
{
    return source(&r->trained, TRAINED);
}

static loader_source checked(const task_run *r)
{
    return source(&r->checked, CHECKED);
}

static size_t sample_bytes(const task_run *r)
{
    (void)r;
    return SIDE * SIDE * sizeof(lt_real);
}

static lt_status record_with_losses(const void *m, model_record *r)
{
    ((const model *)m)->cls->record(m, true, r);
    return LT_OK;
}

/* Slots first .. of the batch into the inputs; a place behind the last sample counts for nothing. */
static double feed(const void *ctx, const lt_plan *p, const model_record *r, const void *batch_, int first, int part,
                   int n)
{
    const batch *b = batch_;
    lt_real *picture = lt_plan_data(p, model_port_find(&r->inputs, "picture"));
    lt_real *truth = lt_plan_data(p, model_port_find(&r->inputs, "truth"));
    lt_real *weight = lt_plan_data(p, model_port_find(&r->inputs, "weight"));
    double sum = 0;

    (void)ctx;
    (void)part;
    (void)n;
    for (int i = 0; i < r->batch; i++) {
        const int from = first + i < b->count ? first + i : b->count - 1;

        weight[i] = from == first + i ? b->weight[from] : 0;
        if (from < 0)
            continue;
        memcpy(picture + i * SIDE * SIDE, b->picture[from], sizeof(b->picture[from]));
        truth[i] = b->truth[from];
        sum += weight[i];
    }
    return sum;
}

static recipe run_recipe(const task_run *r, const task_phase *phase)
{
    (void)phase;
    return (recipe){ .ctx = r->model, .record = record_with_losses, .feed = feed };
}

static double weight_of(const void *batch_)
{
    const batch *b = batch_;
    double sum = 0;

    for (int i = 0; i < b->count; i++)
        sum += b->weight[i];
    return sum;
}

static const char *sample_name(const task_run *r, const void *batch_, int i)
{
    return i < ((const batch *)batch_)->count ? name(r, i) : NULL;
}

/* A record a sample: how far off the count is. */
static lt_status score(task_run *r, const compiled *c, const void *batch_, records *out, bool *no_losses)
{
    const batch *b = batch_;
    const lt_real *count = compiled_output(c, "count");
    lt_status st = LT_OK;

    (void)r;
    (void)no_losses;
    for (int i = 0; st == LT_OK && i < b->count; i++) {
        const double off = fabs((double)count[i] - (double)b->truth[i]);

        st = records_add(out, b->index[i], &off, sizeof(off));
    }
    return st;
}

static void measure(task_run *r, const records *all, double *out)
{
    (void)r;
    out[0] = 0;
    for (int64_t i = 0; i < all->n; i++) {
        double off;

        memcpy(&off, records_at(all, i, NULL), sizeof(off));
        out[0] += off / (double)all->n;
    }
}

static const metric own_metrics[] = {
    { .key = "dots_off", .name = "dots off", .unit = "", .meaning = "mean distance of the count from the truth" },
    { .key = NULL },
};

static const model_class *const models[] = { &counter_class, NULL };
static const char *const metrics[] = { "dots_off", NULL };

static const task dots_task = {
    .name = "dots", .data_size = sizeof(dots_data), .data_keys = data_keys, .models = models, .metrics = metrics,
    .own_metrics = own_metrics, .open = run_open, .close = run_close, .build = run_build, .describe = describe,
    .facts = facts, .samples = samples, .checked = checked, .sample_bytes = sample_bytes, .recipe = run_recipe,
    .weight = weight_of, .sample_name = sample_name, .score = score, .measure = measure,
};

int main(int argc, char **argv)
{
    const task *const tasks[] = { &dots_task, NULL };
    train_options o = { .tasks = tasks, .config = "own_task.json" };
    train_result r;

    if (argc != 2) {
        fprintf(stderr, "usage: own_task OUT\n");
        return 2;
    }
    o.out = argv[1];
    if (train_run(&o, &r)) {
        fprintf(stderr, "own_task: %s\n", lt_last_error());
        return 1;
    }
    printf("dots off by %.2f\n", r.best);
    return 0;
}
