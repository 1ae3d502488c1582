/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tokens of a map with learned positions, layers of deformable attention over them, and the projection
 * behind: one branch's encoder.
 *
 * Source: Bandi and Thomas 2025, Table 2; Zhu et al. 2021, "Deformable DETR", section 4.
 */
#ifndef MODELS_UNIFIED_ENCODER_H
#define MODELS_UNIFIED_ENCODER_H

#include "libtensor/nn/layers.h"

enum { ENCODER_MAX_LAYERS = 8 };

typedef struct {
    int cells;                      /* side of the map */
    int in, width, out;             /* channels of the map, of tokens, of the result */
    int layers, heads, points, ffn;
    double dropout;
} encoder_opts;

typedef struct {
    lt_linear_layer offsets, weights, value, output, linear1, linear2;
    lt_layer_norm_layer norm1, norm2;
} encoder_layer;

typedef struct {
    encoder_opts opts;
    lt_param *position;             /* (cells * cells, in) */
    lt_linear_layer embed, head1, head2;
    lt_layer_norm_layer norm;
    encoder_layer layer[ENCODER_MAX_LAYERS];
} deformable_encoder;

void deformable_encoder_new(deformable_encoder *m, lt_params *set, const char *prefix, const encoder_opts *opts);

/* deformable_encoder_init - after lt_init_default: Xavier for projections; offsets start as a star of directions,
 * one a head, weights even */
void deformable_encoder_init(const deformable_encoder *m, uint64_t seed);

/* deformable_encoder_forward - tokens (B, cells * cells, in) -> (B, cells * cells, out); places are lt_cell_places */
lt_tensor *deformable_encoder_forward(const deformable_encoder *m, lt_tensor *tokens, lt_tensor *places);

#endif
