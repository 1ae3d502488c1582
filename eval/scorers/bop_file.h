/* SPDX-License-Identifier: Apache-2.0 */
/*
 * BOP's csv of object poses, as dexycb_results_open writes it: metres, the model's own frame. Read as BOP's toolkit
 * reads it: the header may be missing, and blanks be anywhere between numbers and commas.
 */
#ifndef EVAL_SCORERS_BOP_FILE_H
#define EVAL_SCORERS_BOP_FILE_H

#include "libtensor/base/arena.h"
#include "libtensor/geometry/pose.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    int scene, image, object;
    double score;
    lt_pose pose;                   /* as written: not of need a rigid one */
    int64_t line;                   /* of the file, from 1 */
} bop_estimate;

/* By scene, image, object, then the best score first. */
typedef struct { bop_estimate *estimate; int64_t n; } bop_file;

/* bop_file_read - all estimates, in arena. Errors: another header, a line that is no estimate, with its number and the
 * field; numbers that are not finite are read. */
lt_status bop_file_read(lt_arena *arena, const char *path, bop_file *out);

/* bop_file_find - the estimate of an object with the best score, or NULL */
const bop_estimate *bop_file_find(const bop_file *file, int scene, int image, int object);

#ifdef __cplusplus
}
#endif
#endif
