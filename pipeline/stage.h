/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A stage takes a frame one step further. A pipeline is a row of stages, each opened once, through which frames go one
 * after the other. What stages there are says one table, pipeline/stages/stages.c.
 */
#ifndef PIPELINE_STAGE_H
#define PIPELINE_STAGE_H

#include "pipeline/frame.h"

enum { MOST_STAGES = 16 };              /* in a row */

typedef struct {
    const char *name;
    unsigned needs, gives;          /* of frame_part */
    bool (*forgives)(lt_status st); /* whether such an error is the frame's alone; NULL: none is */

    lt_status (*open)(const predict_options *o, void **state);      /* NULL: it keeps nothing */
    lt_status (*run)(void *state, predict_frame *f);
    void (*miss)(void *state, predict_frame *f);    /* told when a stage before failed on this frame; NULL: no matter */
    void (*close)(void *state);
} stage;

typedef struct pipeline pipeline;

/**
 * pipeline_open - the stages of these names in a row
 *
 *   o        must outlive it
 *   given    what frames have before the first stage, of frame_part
 *   names    NULL-terminated
 *
 * Errors: those of the stages; LT_EINVAL: no such stage, or one that needs what none before it gives.
 */
lt_status pipeline_open(const predict_options *o, unsigned given, const char *const *names, pipeline **out);

/* pipeline_run - a frame through all stages; where one fails f->forgiven says whether the next frame may do better */
lt_status pipeline_run(pipeline *p, predict_frame *f);
void pipeline_close(pipeline *p);

#endif
