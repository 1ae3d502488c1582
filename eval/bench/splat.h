/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The splat rasteriser to measure, dressed as a model: 10,000 Gaussians on 224 x 224 pixels unless its config says
 * otherwise. Nothing is trained: its training step is forward and backward.
 */
#ifndef EVAL_BENCH_SPLAT_H
#define EVAL_BENCH_SPLAT_H

#include "models/model.h"

extern const model_class bench_splat_class;

#endif
