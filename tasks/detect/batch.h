/* SPDX-License-Identifier: Apache-2.0 */
/* Batches of pictures for a detector, and where their samples come from. */
#ifndef TASKS_DETECT_BATCH_H
#define TASKS_DETECT_BATCH_H

#include "data/loader.h"
#include "estimate/compiled.h"
#include "tasks/detect/picture.h"

typedef struct {
    lt_arena *memory;
    int count, capacity, size;
    bool *there;
    int64_t *index;
    int *width, *height;            /* of the dataset's picture; in samples as they are */
    float *image, *objects;
    int32_t *masks;
} detect_batch;

/* What samples are made of */
typedef struct {
    const detection_set *set;
    const detect_config *how;       /* NULL: pictures as they are */
    int size, epochs;               /* of pictures; of the run */
    uint64_t seed;
    int64_t count;                  /* the first of set */
} detect_feed;

/* detect_source - feed must outlive it. Pictures are a function of seed, epoch and number. */
loader_source detect_source(const detect_feed *feed);

/* detect_batch_feed - feed a graph with the inputs of csp_seg_record, or with its image alone. A slot without a sample
 * stands in for its neighbour. Returns r->batch, or 0 where no sample is there at all. */
double detect_batch_feed(const lt_plan *p, const model_record *r, const detect_batch *b, int first, int part, int n);

#endif
