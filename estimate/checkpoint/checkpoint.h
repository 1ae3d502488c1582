/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A run at one moment, in one safetensors file: weights, running statistics, what the optimiser remembers,
 * and as metadata where it was. The same run gives the same bytes, whenever and wherever it is made.
 *
 * Metadata keys: "format" (palmar-checkpoint), "version", "model", "variant", "config" (JSON), "step", "epoch",
 * "next", "seed", "skipped", "optim_steps", "validated", "best", "best_step", "isa", "tips" (vertices of the hand),
 * "crc32" (of everything else); in one that is made for inference, "int8" (estimate/int8/table.h).
 */
#ifndef ESTIMATE_CHECKPOINT_H
#define ESTIMATE_CHECKPOINT_H

#include "data/loader.h"
#include "libtensor/io/array/array.h"
#include "libtensor/optim/optim.h"
#include "models/model.h"

/* Where a run was, apart from its arrays. */
typedef struct {
    int64_t step;                   /* steps tried, skipped ones included */
    int64_t skipped;                /* steps without a finite gradient */
    int64_t optim_steps;
    loader_position position;       /* of the next batch */
    uint64_t seed;
    int64_t validated;              /* the step of the last validation; 0 before one */
    double best;                 /* the task's first metric, at its best so far; infinite before a validation */
    int64_t best_step;              /* of that validation; 0 before one */
} checkpoint_state;

/* What a run keeps beside its model and its optimiser, in arrays of lt_real. */
typedef struct {
    void *ctx;
    int (*save)(void *ctx, lt_named_array *out, int room);          /* how many; names and data as long as ctx */
    /* From all that a file holds, before its shapes are compared with the parameters': these may be resized first. */
    lt_status (*load)(void *ctx, const char *path, const lt_named_array *entry, size_t n);
} checkpoint_own;

enum { CHECKPOINT_OWN = 64 };       /* arrays at most */

/**
 * checkpoint_save - write everything to path, atomically
 *
 *   config   resolved, as text
 *   own      NULL: nothing
 *
 * Errors: LT_ENUMERIC names a parameter that is not finite (nothing is written then); LT_ENOSPC, LT_EIO:
 * what was at path is as it was, and no temporary file stays.
 */
lt_status checkpoint_save(const char *path, const model *m, const lt_optim *optim, const char *config,
                          const checkpoint_state *state, const checkpoint_own *own);

/**
 * checkpoint_load - put back what checkpoint_save wrote
 *
 * Parameters that are stepped by rows (libtensor/graph/rows.h) get as many rows as the file has. Model and optimiser
 * are as they were before on any error, but for that and for what own->load did. Errors: LT_EFORMAT for a file that is
 * damaged or no checkpoint; LT_EINVAL for one of another model, variant, size or optimiser, with a line naming both,
 * and for one of a later version of palmar.
 */
lt_status checkpoint_load(const char *path, const model *m, lt_optim *optim, checkpoint_state *state,
                          const checkpoint_own *own);

/* checkpoint_check - whether the file is of this model, whose parameters need no values for it; errors as
 * checkpoint_load_model */
lt_status checkpoint_check(const char *path, const model *m);

/* checkpoint_average - among a file's n arrays, the average over a run's steps of the weight of this name; NULL where
 * the run kept none */
const lt_named_array *checkpoint_average(const lt_named_array *entry, size_t n, const char *weight);

/**
 * checkpoint_load_model - weights and running statistics alone, to evaluate or predict
 *
 * Names and shapes are held against the file's before a model that is only described (lt_params_defer) gets memory.
 * Where the run kept an average of the weights, that is what is loaded. m->int8 becomes the file's table, which
 * lives as long as the parameters, or NULL. Errors as checkpoint_load, and those of int8_table_parse.
 */
lt_status checkpoint_load_model(const char *path, model *m);

/**
 * checkpoint_save_inference - a checkpoint for inference: m's weights and its table if it has one, and what the
 * metadata of checkpoint `from` say, nothing of the optimiser, and of the folder that it was trained on the last name
 * alone; atomically
 *
 *   half     weights of layers in half precision, for half of the size; biases and statistics stay as they are
 *
 * m was loaded from `from`, so its weights are the average where one was kept. Errors: those of reading and writing;
 * LT_ENUMERIC for a weight that is not finite, or too large for half precision.
 */
lt_status checkpoint_save_inference(const char *path, const char *from, const model *m, bool half);

/* What must be known before a checkpoint's model can be made. */
typedef struct {
    const char *config;             /* JSON text, in the arena */
    int64_t step;
    const char *isa;                /* instruction set that it was computed with, in the arena; NULL: it does not say */
    int tips[5];                    /* vertices that its hand layer took for finger tips; HO3D's if it does not say */
} checkpoint_head;

/* checkpoint_head_read - errors: those of reading; LT_EFORMAT where the file is no checkpoint or says it wrongly */
lt_status checkpoint_head_read(lt_arena *arena, const char *path, checkpoint_head *out);

/* checkpoint_bytes - about how large the file will be */
size_t checkpoint_bytes(const model *m, const lt_optim *optim);

#endif
