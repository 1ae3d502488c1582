/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The hand's heat maps: the hourglass of Table 3, a spatial softmax, and the mesh encoder that reads both.
 *
 * Source: Bandi and Thomas 2025, Table 3; Semi-Hand-Object networks/hand_head.py.
 */
#ifndef MODELS_UNIFIED_HOURGLASS_H
#define MODELS_UNIFIED_HOURGLASS_H

#include "models/heads/mano_regressor.h"

typedef struct {
    lt_param *weight, *bias;        /* (C, O, k, k), (O) or NULL */
    int stride, pad;
} transposed_conv;

typedef struct {
    lt_conv_layer conv;
    lt_batch_norm_layer bn;
} conv_norm;

typedef struct {
    conv_norm conv[3], down[3];
    preact_bottleneck bottleneck;
    transposed_conv up[3];
    lt_batch_norm_layer up_bn[2];
    lt_param *temperature;          /* (joints) */
    bool up3_relu;                  /* before the softmax */
    int cells;                      /* side of the map; heat maps have HOURGLASS_MARGIN more on each side */
} unified_hourglass;

enum { HOURGLASS_MARGIN = 2 };

/* unified_hourglass_new - on (B, channels, cells, cells); 7 x 7 cells at its second halving go to 4 x 4 and back by a
 * window of 3, even ones by one of 4. cells: a multiple of 4. */
void unified_hourglass_new(unified_hourglass *m, lt_params *set, const char *prefix, int cells, int channels,
                           int joints, bool up3_relu);

/* unified_hourglass_forward - encoding (B, 2 C, cells / 2, cells / 2), heat maps (B, joints, cells + 4, cells + 4),
 * joints2d in units of the map without its margin */
heatmap_out unified_hourglass_forward(const unified_hourglass *m, lt_tensor *x);

/* Heat maps brought to the encoding's size and beside it, then residuals and pooling down to 2 x 2. */
typedef struct {
    lt_conv_layer heatmap_conv, mix;
    residual_tower tower;
} mesh_encoder;

void mesh_encoder_new(mesh_encoder *m, lt_params *set, const char *prefix, int cells, int channels, int joints);
lt_tensor *mesh_encoder_forward(const mesh_encoder *m, const heatmap_out *heat);

#endif
