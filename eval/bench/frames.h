/* SPDX-License-Identifier: Apache-2.0 */
/* How long an action model takes for one frame of a stream. */
#ifndef EVAL_BENCH_FRAMES_H
#define EVAL_BENCH_FRAMES_H

#include "models/model.h"

/* bench_frames - ST-GCN's stream of m, an action model, the median of 400 frames. LT_ENOMEM. */
lt_status bench_frames(const model *m, double *median_ms);

#endif
