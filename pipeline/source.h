/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where frames come from, one after the other: images, films, and pictures from a pipe.
 */
#ifndef PIPELINE_SOURCE_H
#define PIPELINE_SOURCE_H

#include "pipeline/frame.h"

typedef struct frame_source frame_source;

/**
 * frame_source_open - the inputs of o, each with its lines in o->boxes, and the objects
 *
 *   skipped   inputs that are no file and no folder with images; told already
 *
 * What is wrong with all of them is found here: LT_EUSAGE, LT_EINVAL, LT_EFORMAT as predict_images has it; LT_ENOMEM.
 */
lt_status frame_source_open(const predict_options *o, frame_source **out, int *skipped);
void frame_source_close(frame_source *s);

/**
 * frame_source_next - the next frame as its source has it; *more: there was one
 *
 * The frame is valid until the next call. Where an error is f->forgiven the call after it goes on with what comes next.
 */
lt_status frame_source_next(frame_source *s, predict_frame *f, bool *more);

#endif
