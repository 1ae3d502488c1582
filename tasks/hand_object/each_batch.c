/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hand_object/each_batch.h"

#include "estimate/feed.h"
#include "libtensor/base/parallel.h"

typedef struct {
    const dataset *data;
    const hand_object_options *options;
    hand_object_batch *batch;
    int64_t first, total, samples;  /* of the evenly spread samples: the batch starts at first */
    lt_status status[256];
} fill_job;

/* Read and crop one sample of the batch; the first error in the batch's order is the one reported. */
static void fill_slot(void *ctx, int64_t slot)
{
    fill_job *j = ctx;
    const int64_t index = (j->first + slot) * j->total / j->samples;
    lt_arena *arena = lt_arena_new();
    dataset_sample s;
    lt_status st = arena ? dataset_read(j->data, index, hand_object_want(j->options), arena, &s)
                         : lt_error(LT_ENOMEM, "no memory for a sample");

    if (st == LT_OK)
        st = hand_object_prepare(&s, j->options, 0, index, j->batch, (int)slot);
    j->status[slot] = st;
    lt_arena_free(arena);
}

static lt_status first_error(fill_job *j)
{
    for (int s = 0; s < j->batch->count; s++)
        if (j->status[s]) {
            fill_slot(j, s);                    /* again on this thread, whose error line is ours */
            return j->status[s];
        }
    return LT_OK;
}

lt_status eval_each_batch(const evaluate_options *o, eval_batch_fn fn, void *ctx)
{
    hand_object_options options = hand_object_defaults(false, 0);
    fill_job job = { .data = o->data, .options = &options, .total = o->data->count };
    lt_status st = LT_OK;

    feed_options(o->m, &options);
    options.bilinear = o->bilinear;
    job.samples = o->limit > 0 ? lt_min_i64(o->limit, job.total) : job.total;
    job.batch = hand_object_batch_new(o->batch, options.size, options.cells);
    if (!job.batch)
        return lt_error(LT_ENOMEM, "no memory for a batch of %d", o->batch);
    for (; st == LT_OK && job.first < job.samples; job.first += job.batch->count) {
        job.batch->count = (int)lt_min_i64(o->batch, job.samples - job.first);
        lt_parallel_for(job.batch->count, fill_slot, &job);
        st = first_error(&job);
        if (st == LT_OK)
            st = fn(ctx, job.batch, job.first);
        if (st == LT_OK && o->progress && !o->progress(o->progress_ctx, job.first + job.batch->count, job.samples))
            st = lt_error(LT_ESTOPPED, "stopped after %lld of %lld samples",
                          (long long)(job.first + job.batch->count), (long long)job.samples);
    }
    hand_object_batch_free(job.batch);
    return st;
}
