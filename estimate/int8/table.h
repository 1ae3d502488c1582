/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A table of layers that read 8-bit integers as text: what a checkpoint carries of a calibration.
 *
 * {"layers": [{"name": "trunk.layer1.0.conv1", "scale": 0.0131, "signed": false}, ...]}
 */
#ifndef ESTIMATE_INT8_TABLE_H
#define ESTIMATE_INT8_TABLE_H

#include "libtensor/base/arena.h"
#include "libtensor/graph/int8.h"
#include "libtensor/graph/param.h"

/* int8_table_text - as JSON, in the arena; NULL without memory */
const char *int8_table_text(lt_arena *arena, const lt_int8_table *table);

/**
 * int8_table_parse - back to a table, in the arena
 *
 *   path     for error lines
 *   params   of the model, in which every layer must have a parameter
 *
 * Errors: LT_EFORMAT: no JSON of this form; a layer that is there twice, or that the model has not; a scale that is not
 * finite and above 0, also as a float, and also one by it.
 */
lt_status int8_table_parse(lt_arena *arena, const char *path, const char *text, const lt_params *params,
                           const lt_int8_table **out);

#endif
