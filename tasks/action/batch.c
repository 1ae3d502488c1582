/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/action/batch.h"

#include "libtensor/base/rng.h"

#include <stdlib.h>
#include <string.h>

static void batch_free(void *batch)
{
    action_batch *b = batch;

    if (!b)
        return;
    free(b->index);
    free(b->cls);
    free(b->body);
    free(b->hand_object);
    free(b->valid);
    free(b->on);
    free(b);
}

static size_t body_of(int T)
{
    return (size_t)T * 3 * ACTION_BODY;
}

static size_t hand_object_of(int T)
{
    return (size_t)T * 3 * ACTION_HAND_OBJECT;
}

static void *batch_new(const void *ctx, int capacity)
{
    const action_feed *f = ctx;
    const size_t n = (size_t)capacity;
    action_batch *b = calloc(1, sizeof(*b));

    if (!b)
        return NULL;
    b->T = f->T;
    b->index = calloc(n, sizeof(*b->index));
    b->cls = calloc(n, sizeof(*b->cls));
    b->body = calloc(n * body_of(f->T), sizeof(*b->body));
    b->hand_object = calloc(n * hand_object_of(f->T), sizeof(*b->hand_object));
    b->valid = calloc(n * (size_t)f->T, sizeof(*b->valid));
    b->on = calloc(n, sizeof(*b->on));
    if (b->index && b->cls && b->body && b->hand_object && b->valid && b->on)
        return b;
    batch_free(b);
    return NULL;
}

static void batch_start(void *b, int count)
{
    ((action_batch *)b)->count = count;
}

static void batch_skip(void *batch, int slot, int64_t index)
{
    ((action_batch *)batch)->index[slot] = index;   /* of no use: windows are in memory, and none fails */
}

static lt_status batch_fill(const void *ctx, uint64_t epoch, int64_t index, lt_arena *scratch, void *batch, int slot)
{
    const action_feed *f = ctx;
    const action_window *w = &f->window[index];
    action_batch *b = batch;
    float *body = b->body + (size_t)slot * body_of(f->T);
    float *hand_object = b->hand_object + (size_t)slot * hand_object_of(f->T);
    lt_rng rng = lt_rng_make(f->seed, lt_rng_mix(epoch, (uint64_t)index));
    const int valid = action_window_read(f->set, w, f->T, body, hand_object, b->valid + slot * f->T);
    const bool hidden = lt_rng_uniform(&rng) < f->hide && f->set->clip[w->clip].cls >= ACTION_WITH_OBJECT;

    (void)scratch;
    b->index[slot] = index;
    b->cls[slot] = f->set->clip[w->clip].cls;
    b->on[slot] = valid >= f->min_valid && !hidden && f->streams != STREAMS_BODY;
    if (f->streams == STREAMS_HAND_OBJECT)
        memset(body, 0, body_of(f->T) * sizeof(*body));
    return LT_OK;
}

static const char *window_name(const void *ctx, int64_t index)
{
    const action_feed *f = ctx;

    return f->set->clip[f->window[index].clip].name;
}

loader_source action_source(const action_feed *feed)
{
    return (loader_source){ .ctx = feed, .count = feed->count, .name = window_name, .batch_new = batch_new,
                            .batch_free = batch_free, .start = batch_start, .fill = batch_fill, .skip = batch_skip };
}

static lt_real *input(const lt_plan *p, const model_record *r, const char *name)
{
    const lt_tensor *t = model_port_find(&r->inputs, name);

    return t ? lt_plan_data(p, t) : NULL;
}

static void copy(lt_real *to, int slot, const float *from, int window, size_t n)
{
    for (size_t k = 0; to && k < n; k++)
        to[(size_t)slot * n + k] = (lt_real)from[(size_t)window * n + k];
}

double action_batch_feed(const lt_plan *p, const model_record *r, const action_batch *b, int first)
{
    lt_real *target = input(p, r, "class"), *weight = input(p, r, "weight");
    double sum = 0;

    if (target)
        memset(target, 0, (size_t)r->batch * ACTION_CLASSES * sizeof(*target));
    for (int i = 0; i < r->batch && b->count; i++) {
        const bool there = first + i < b->count;
        const int from = there ? first + i : 0;

        copy(input(p, r, "body"), i, b->body, from, body_of(b->T));
        copy(input(p, r, "hand_object"), i, b->hand_object, from, hand_object_of(b->T));
        copy(input(p, r, "valid"), i, b->valid, from, (size_t)b->T);
        copy(input(p, r, "on"), i, b->on, from, 1);
        if (target)
            target[i * ACTION_CLASSES + b->cls[from]] = 1;
        if (weight)
            weight[i] = there;
        sum += there;
    }
    return sum;
}
