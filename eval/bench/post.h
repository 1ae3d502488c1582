/* SPDX-License-Identifier: Apache-2.0 */
/* How long it takes from a detector's maps to what people look at. */
#ifndef EVAL_BENCH_POST_H
#define EVAL_BENCH_POST_H

#include "models/model.h"

enum { BENCH_POST_OBJECTS = 30 };

/**
 * bench_post - boxes and masks of 30 objects in a picture as large as the model's, the median of 50 runs
 *
 * Each is found by some ten cells, as after training. *objects: how many were left, 30. Errors: LT_EINVAL, a model that
 * is no csp_seg; LT_ENOMEM.
 */
lt_status bench_post(const model *m, double *median_ms, int *objects);

#endif
