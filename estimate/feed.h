/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From the arrays of a prepared batch to the inputs of a model, by the names of its ports.
 */
#ifndef ESTIMATE_FEED_H
#define ESTIMATE_FEED_H

#include "data/hand_object.h"
#include "estimate/compiled.h"

/* feed_options - how the model wants its crops: size, cells, window, depth */
void feed_options(const model *m, hand_object_options *o);

/**
 * feed_check - whether a hand-object batch has what the model asks for
 *
 * Errors: LT_EINVAL names the port that it does not have, or whose samples have another size.
 */
lt_status feed_check(const model_record *r);

/* feed_parts - in how many parts (lt_compile_opts.parts) a batch to train on is computed: 2 where it can be halved and
 * the model has few weights, for each half prepares them and makes their gradients anew; else 1 */
int feed_parts(const model *m, int batch);

/* feed_recipe - m's graph with its losses, fed with hand_object_batch; m must outlive it */
recipe feed_recipe(const model *m);

/**
 * feed_batch - fill the inputs of a plan with slots first .. first + r->batch - 1 of b
 *
 * Returns the weight of the samples among them. A place without one, behind the end of a last batch or for a
 * sample that could not be read, gets a neighbour's arrays and weight 0, so that it changes no loss and
 * no black image disturbs the batch's statistics. Returns 0, and fills nothing, when no sample counts.
 */
double feed_batch(const lt_plan *p, const model_record *r, const hand_object_batch *b, int first);

#endif
