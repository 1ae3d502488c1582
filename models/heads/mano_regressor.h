/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From heat maps and features to the hand model's parameters, and through the hand layer to a mesh.
 *
 * Source: Semi-Hand-Object networks/hand_head.py (fusion encoder) and networks/mano_head.py.
 */
#ifndef MODELS_HEADS_MANO_REGRESSOR_H
#define MODELS_HEADS_MANO_REGRESSOR_H

#include "libtensor/geometry/hand/layer.h"
#include "models/heads/hourglass.h"

/* PB, PB, pool per level, flattened; a pool keeps a last partial window. Parameters PREFIX.level.0, .1 */
typedef struct {
    preact_bottleneck block[HOURGLASS_MAX_DEPTH][2];
    int levels;
} residual_tower;

void residual_tower_new(residual_tower *m, lt_params *set, const char *prefix, int channels, int levels);
lt_tensor *residual_tower_forward(const residual_tower *m, lt_tensor *x);

/* Heat maps and encoding, each through a 1x1 convolution, summed; then a tower down to 2 x 2. */
typedef struct {
    lt_conv_layer heatmap_conv, encoding_conv;
    residual_tower tower;
} fusion_encoder;

void fusion_encoder_new(fusion_encoder *m, lt_params *set, const char *prefix, int channels, int joints,
                        int levels);
lt_tensor *fusion_encoder_forward(const fusion_encoder *m, lt_tensor *heatmaps, lt_tensor *encoding);

/* Two hidden layers; 16 rotations as 6D, 10 shape numbers. */
typedef struct {
    lt_linear_layer fc1, fc2, pose, shape;
    const lt_hand_layer *hand;
} mano_regressor;

typedef struct {
    lt_tensor *rotation;            /* (B, 16, 3, 3) */
    lt_tensor *beta;                /* (B, 10) */
    lt_tensor *vertices;            /* (B, 778, 3) wrist-relative, metres */
    lt_tensor *joints;              /* (B, 21, 3) simple order */
} mano_out;

void mano_regressor_new(mano_regressor *m, lt_params *set, const char *prefix, int features, int hidden1,
                        int hidden2, const lt_hand_layer *hand);
mano_out mano_regressor_forward(const mano_regressor *m, lt_tensor *features);

#endif
