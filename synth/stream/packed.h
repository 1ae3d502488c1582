/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Samples in little memory: the picture as a JPEG, masks and depth deflated. A stream hands out what comes back from
 * here, so that a picture is the same whether it was just drawn or kept since an earlier epoch.
 */
#ifndef SYNTH_STREAM_PACKED_H
#define SYNTH_STREAM_PACKED_H

#include "data/dataset.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct packed_sample packed_sample;

/* packed_new - of s, whose masks and depth may be missing, and whose depth is in whole millimetres; NULL: no memory.
 * packed_bytes - of memory that it takes; packed_free */
packed_sample *packed_new(const dataset_sample *s);
size_t packed_bytes(const packed_sample *k);
void packed_free(packed_sample *k);

/* packed_has - whether what is wanted of a sample (dataset_read) is in it; an object's mask where it has an object */
bool packed_has(const packed_sample *k, unsigned want);

/* packed_read - the sample, images into the arena. LT_ENOMEM */
lt_status packed_read(const packed_sample *k, lt_arena *arena, dataset_sample *out);

#ifdef __cplusplus
}
#endif
#endif
