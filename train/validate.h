/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How good the model is in the middle of a run: joint errors and losses on samples it does not learn from.
 * The papers' tables are eval's; this is for choosing a checkpoint.
 */
#ifndef TRAIN_VALIDATE_H
#define TRAIN_VALIDATE_H

#include "estimate/compiled.h"
#include "train/log.h"
#include "train/source.h"

/**
 * validate_run - score the model as it is on the validation samples
 *
 *   c       of kind COMPILED_CHECK
 *   told    by compiled_walk of samples that could not be read, with ctx
 *   out     step and epoch are the caller's; the errors are NaN when no sample has joints or the model does
 *           not predict them, the losses when a sample lacks a hand pose, as those of HO3D's evaluation do
 *
 * Errors: those of compiled_walk; LT_ESTOPPED when stop says so.
 */
lt_status validate_run(const compiled *c, const train_source *s, const train_data_config *data,
                       compiled_skipped told, void *ctx, bool (*stop)(void), train_validation *out);

#endif
