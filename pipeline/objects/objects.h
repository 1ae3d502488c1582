/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The models of objects that are named: scanned ones from a folder, or the embedded stand-ins.
 */
#ifndef PIPELINE_OBJECTS_OBJECTS_H
#define PIPELINE_OBJECTS_OBJECTS_H

#include "pipeline/frame.h"

/* predict_load_objects - those that the lines of b name, which point to them then, and *given of --object, or NULL */
lt_status predict_load_objects(lt_arena *arena, const predict_options *o, predict_boxes *b,
                               const predict_object **given);

/* predict_load_object - one, as o->models has it */
lt_status predict_load_object(lt_arena *arena, const predict_options *o, const char *asked, predict_object *out);

#endif
