/* SPDX-License-Identifier: Apache-2.0 */
/* The samples of a split, batch after batch. */
#ifndef TASKS_HAND_OBJECT_EACH_BATCH_H
#define TASKS_HAND_OBJECT_EACH_BATCH_H

#include "data/hand_object.h"
#include "tasks/hand_object/evaluate.h"

/* done: samples before the batch */
typedef lt_status (*eval_batch_fn)(void *ctx, const hand_object_batch *b, int64_t done);

/* eval_each_batch - call fn for all batches of o->data (with o->limit: of samples spread over it), in its order,
 * cropped as in testing. Errors: a sample that cannot be read, LT_ESTOPPED by o->progress, those of fn. */
lt_status eval_each_batch(const evaluate_options *o, eval_batch_fn fn, void *ctx);

#endif
