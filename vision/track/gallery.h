/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How something looked: the embeddings of its last appearances.
 */
#ifndef VISION_TRACK_GALLERY_H
#define VISION_TRACK_GALLERY_H

#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    float *row;                     /* (budget, size) of length 1 */
    int budget, size, n, next;
} gallery;

/* gallery_init - an empty one; LT_ENOMEM. gallery_fini - zeroed ones are fine. */
lt_status gallery_init(gallery *g, int budget, int size);
void gallery_fini(gallery *g);

/* gallery_unit - an embedding at length 1; false where it has none that is a number */
bool gallery_unit(const float *embedding, int size, float *unit);

/* gallery_add - one more appearance, in place of the oldest when it is full */
void gallery_add(gallery *g, const float *unit);

/**
 * gallery_distances - the smallest cosine distance of each to any that are kept; 2, the largest that there is, to an
 * empty gallery
 *
 *   units     (n, size) of length 1
 *   scratch   budget * n numbers
 *   out       (n)
 */
void gallery_distances(const gallery *g, const float *units, int n, float *scratch, double *out);

#ifdef __cplusplus
}
#endif
#endif
