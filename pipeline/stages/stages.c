/* SPDX-License-Identifier: Apache-2.0 */
#include "pipeline/stages/stages.h"

const stage *const stages[] = {
    &read_stage,                        /* the file, upright, with a camera */
    &detect_stage,                      /* what a detector sees in it */
    &track_stage,                       /* which detection of a film is which */
    &look_stage,                        /* which hands, with which objects */
    &estimate_stage,                    /* crops through the network */
    &solve_stage,                       /* hand and object where the camera saw them */
    &smooth_stage,                      /* a film's frames through filters */
    &body_stage,                        /* whole bodies of people */
    &judge_stage,                       /* how far to believe it */
    &draw_stage,                        /* the overlay */
    &write_stage,                       /* NAME.json and what else there is */
    &print_stage,                       /* the same JSON, a line each */
    NULL,
};
