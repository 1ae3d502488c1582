/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Prepares batches ahead of the training loop on threads of its own. What a batch holds is the
 * source's affair; which samples it holds is a function of (seed, epoch, position), never of timing.
 */
#ifndef DATA_LOADER_H
#define DATA_LOADER_H

#include "libtensor/base/arena.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Where samples come from. fill is called from several threads at once, for different slots; what it puts into
 * scratch is gone when it returns. */
typedef struct {
    const void *ctx;
    int64_t count;
    const char *(*name)(const void *ctx, int64_t index);
    void *(*batch_new)(const void *ctx, int capacity);              /* NULL: no memory */
    void (*batch_free)(void *batch);
    /* start: count samples are about to be filled into slots 0 .. count - 1 */
    void (*start)(void *batch, int count);
    lt_status (*fill)(const void *ctx, uint64_t epoch, int64_t index, lt_arena *scratch, void *batch, int slot);
    /* skip: the slot's sample could not be read; make it count for nothing */
    void (*skip)(void *batch, int slot, int64_t index);
    bool ordered;                   /* each epoch goes by the samples' numbers: no order is drawn for it */
} loader_source;

typedef struct {
    int batch;                      /* samples in a batch over all ranks; the epoch's last may be smaller */
    int threads;                    /* that prepare samples; at least 1 */
    int ahead;                      /* batches ready before they are asked for; at least 1 */
    bool shuffle;                   /* each epoch in an order of its own, from seed; off: as in the file */
    uint64_t seed;
    int first_slot, n_slots;        /* this rank's share of each batch; n_slots 0: all of it */
    double tolerate;                /* share of unreadable samples that is skipped; 0: the first one stops */
} loader_options;

/* Where the loader is: the next batch starts at sample next of epoch's order. Save it to go on there. */
typedef struct {
    uint64_t epoch;
    int64_t next;
} loader_position;

typedef struct loader loader;

/* loader_new - starts the threads at position start. Errors: options that cannot be, no memory. */
lt_status loader_new(const loader_source *source, const loader_options *options,
                     loader_position start, loader **out);

/* loader_free - stops the threads, also in the middle of an epoch; loader_free(NULL) is fine */
void loader_free(loader *l);

/**
 * loader_next - the next batch of the epoch
 *
 * *batch belongs to the loader and is valid until the next call. At the end of an epoch *batch is NULL
 * once, and the call after that begins the next epoch. A rank whose share of a last, small batch is
 * empty gets a batch of 0 samples.
 *
 * Errors: a sample that could not be read, with the line of whoever read it; when more than
 * options.tolerate of the epoch's samples were unreadable, the count and the first of them.
 */
lt_status loader_next(loader *l, void **batch);

/* loader_where - where the batch after the last delivered one starts */
loader_position loader_where(const loader *l);

/* loader_skipped - unreadable samples delivered as skipped so far; line i (below the count) says which
 * and why, once for each sample; valid as long as l */
int loader_skipped(const loader *l);
const char *loader_skipped_line(const loader *l, int i);

#ifdef __cplusplus
}
#endif
#endif
