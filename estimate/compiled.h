/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A model ready to run on batches of one size: its record and the plan made of it.
 */
#ifndef ESTIMATE_COMPILED_H
#define ESTIMATE_COMPILED_H

#include "data/loader.h"
#include "libtensor/graph/plan.h"
#include "models/model.h"

enum { COMPILED_MAX_PARTS = 2 };

/* How a graph is recorded, and how batches of some kind come into it. */
typedef struct {
    const void *ctx;
    int batch;                      /* samples in a graph to evaluate with; 0: as many as are asked for */

    /* Record for r->batch samples, losses included. Errors: inputs that such batches do not have; what is wrong with
     * the graph itself is found afterwards. */
    lt_status (*record)(const void *ctx, model_record *r);

    /* In how many parts (lt_compile_opts.parts) a batch to train on is computed, at most COMPILED_MAX_PARTS. NULL:
     * one */
    int (*parts)(const void *ctx, int batch);

    /* Fill the inputs of part number `part` of n, of what begins at slot `first`. Returns the weight of the part's own
     * samples; where all parts together have none, nothing need be filled. */
    double (*feed)(const void *ctx, const lt_plan *p, const model_record *r, const void *batch, int first, int part,
                   int n);
} recipe;

typedef struct {
    recipe by;
    model_record record;            /* of a part; owns the graph */
    lt_plan *plan;
    int parts;
} compiled;

/* compiled_new - record and compile for batches of `batch`: to train, or outputs and losses alone. Errors: those of
 * lt_compile and of by->record. What by->ctx points to must outlive it. */
lt_status compiled_new(const recipe *by, int batch, bool train, compiled *out);
void compiled_free(compiled *c);

/* compiled_output - where the plan keeps an output, or NULL when the model has none of that name */
const lt_real *compiled_output(const compiled *c, const char *name);

/* compiled_loss - the value of a loss, after a run; NaN for NULL: the graph has none */
double compiled_loss(const compiled *c, const lt_tensor *loss);

enum { COMPILED_AHEAD = 2 };            /* batches that compiled_walk prepares ahead */

/**
 * compiled_walk - run through all samples of a source in order
 *
 *   source     whose batches the recipe feeds
 *   threads    that prepare samples
 *   tolerate   share of unreadable samples that is skipped
 *   visit      called after each run; sample i of the batch is at place i of the outputs
 *   skipped    told of each sample that could not be read, behind the last batch: the i-th, and why
 *   stop       asked before each batch, may be NULL; true: LT_ESTOPPED
 *
 * Parameters may have changed since the last walk. Errors: those of the loader and of visit.
 */
typedef lt_status (*compiled_visit)(void *ctx, const compiled *c, const void *batch);
typedef void (*compiled_skipped)(void *ctx, int i, const char *line);
lt_status compiled_walk(const compiled *c, const loader_source *source, int threads, double tolerate,
                        compiled_visit visit, compiled_skipped skipped, void *ctx, bool (*stop)(void));

#endif
