/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A model ready to run on batches of one size: its record and the plan made of it.
 */
#ifndef ESTIMATE_COMPILED_H
#define ESTIMATE_COMPILED_H

#include "data/hand_object.h"
#include "libtensor/graph/plan.h"
#include "models/model.h"

typedef struct {
    model_record record;            /* of a part; owns the graph */
    lt_plan *plan;
    int parts;
} compiled;

/* compiled_new - record and compile m for batches of `batch`: to train, or outputs and losses alone. Errors: those of
 * lt_compile; inputs that hand-object data do not have. m must outlive it. */
lt_status compiled_new(const model *m, int batch, bool train, compiled *out);
void compiled_free(compiled *c);

/* compiled_output - where the plan keeps an output, or NULL when the model has none of that name */
const lt_real *compiled_output(const compiled *c, const char *name);

enum { COMPILED_AHEAD = 2 };            /* batches that compiled_walk prepares ahead */

/**
 * compiled_walk - run through all samples of a source in order
 *
 *   source     whose batches are hand_object_batch
 *   threads    that prepare samples
 *   tolerate   share of unreadable samples that is skipped
 *   visit      called after each run; sample i of the batch is at place i of the outputs, and those with
 *              b->weight[i] 0 do not count
 *   skipped    told of each sample that could not be read, behind the last batch: the i-th, and why
 *   stop       asked before each batch, may be NULL; true: LT_ESTOPPED
 *
 * Parameters may have changed since the last walk. Errors: those of the loader.
 */
typedef void (*compiled_visit)(void *ctx, const compiled *c, const hand_object_batch *b);
typedef void (*compiled_skipped)(void *ctx, int i, const char *line);
lt_status compiled_walk(const compiled *c, const loader_source *source, int threads, double tolerate,
                        compiled_visit visit, compiled_skipped skipped, void *ctx, bool (*stop)(void));

#endif
