/* SPDX-License-Identifier: Apache-2.0 */
/*
 * DexYCB's text of hand joints (HPE): a line "index,x0,y0,z0,...,z20" for each sample, mm.
 */
#ifndef EVAL_SCORERS_HPE_FILE_H
#define EVAL_SCORERS_HPE_FILE_H

#include "libtensor/base/arena.h"
#include "libtensor/geometry/hand/model.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    int64_t index;                  /* of the sample */
    float joints[LT_HAND_KEYPOINTS][3];     /* metres */
    int64_t number;                 /* of the line in the file, from 1 */
} hpe_line;

/* By index */
typedef struct { hpe_line *line; int64_t n; } hpe_file;

/* hpe_file_read - all lines, in arena, with blanks wherever the toolkit allows them. Errors: a line that is not an
 * index and 63 numbers, with its number; a coordinate that is not finite or beyond 10 km, with joint and axis; two
 * of one sample. */
lt_status hpe_file_read(lt_arena *arena, const char *path, hpe_file *out);

/* hpe_file_find - a line of that sample, or NULL */
const hpe_line *hpe_file_find(const hpe_file *file, int64_t index);

#ifdef __cplusplus
}
#endif
#endif
