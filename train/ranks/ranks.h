/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The processes of one run. Each computes some of a step's shards; rank 0 adds what they found, in the order of the
 * shards' numbers, tells the others, and alone writes files. So any number of ranks gives the same bits.
 */
#ifndef TRAIN_RANKS_H
#define TRAIN_RANKS_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

enum { TRAIN_RANKS_MAX = 1024 };

/* How they talk. Messages between two ranks arrive whole and in order. */
typedef struct {
    int rank, size;
    lt_status (*send)(void *ctx, int to, const void *data, size_t bytes);
    lt_status (*receive)(void *ctx, int from, void *data, size_t bytes);
    void (*fail)(void *ctx);        /* this rank cannot go on: end the others, which wait for it */
    void *ctx;
} train_ranks;

/* In all functions, r NULL: a run of one process. */

static inline bool ranks_lead(const train_ranks *r)
{
    return !r || r->rank == 0;
}

/* Shards [*first, *end) of n are this rank's: neighbours, as many as others have where that is possible. */
void ranks_own(const train_ranks *r, int n, int *first, int *end);

/* ranks_share - all: what each rank has as mine, `bytes` of it, by rank; the same on all of them afterwards */
lt_status ranks_share(const train_ranks *r, const void *mine, size_t bytes, void *all);

/* ranks_tell - what rank 0 has in data is in data on all others */
lt_status ranks_tell(const train_ranks *r, void *data, size_t bytes);

/* ranks_most - the largest that any rank has */
lt_status ranks_most(const train_ranks *r, int *x);

/* ranks_add - the sum over all ranks, in their order */
lt_status ranks_add(const train_ranks *r, double *x);

#endif
