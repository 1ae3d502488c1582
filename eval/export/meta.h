/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: what an exported model says of itself.
 */
#ifndef EVAL_EXPORT_META_H
#define EVAL_EXPORT_META_H

#include "eval/export/export.h"

/* export_config - the model's group of a config, as JSON in the arena; NULL without memory */
const char *export_config(lt_arena *arena, const model *m);

/* export_text - text from outside with bytes that are no UTF-8 replaced; NULL without memory */
const char *export_text(lt_arena *arena, const char *text);

#endif
