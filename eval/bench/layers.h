/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Single layers to measure, dressed as models: the graph holds many copies of the layer, all reading the
 * same input, each with weights of its own, so that weights come from memory as they do inside a network.
 */
#ifndef EVAL_BENCH_LAYERS_H
#define EVAL_BENCH_LAYERS_H

#include "models/model.h"

#include <stdio.h>

/**
 * layer_new - a layer by its text, "conv2d:c=256,k=3,hw=16"
 *
 *   set      gets the weights, initialised; *out lives as long
 *   copies   how many the graph holds
 *
 * Errors: no such layer or key, or a value out of range; the line says what there is.
 */
lt_status layer_new(const char *text, const lt_hand_layer *hand, lt_params *set, model *out, int *copies);

/* layer_list - all layers with their keys and defaults, a line each */
void layer_list(FILE *f);

#endif
