/* SPDX-License-Identifier: Apache-2.0 */
/* All stages there are; a new one is its file, its line here and in stages.c. */
#ifndef PIPELINE_STAGES_STAGES_H
#define PIPELINE_STAGES_STAGES_H

#include "pipeline/stage.h"

extern const stage read_stage, detect_stage, track_stage, look_stage, estimate_stage, solve_stage, smooth_stage,
    body_stage, judge_stage, draw_stage, write_stage, print_stage;

extern const stage *const stages[];     /* NULL-terminated */

#endif
