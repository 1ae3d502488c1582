/* SPDX-License-Identifier: Apache-2.0 */
/*
 * OSX's component-aware encoder: a vision transformer whose tokens are the cells of the image and, before them, one for
 * each thing that is asked for.
 *
 * Source: Lin et al. 2023, "One-stage 3D whole-body mesh recovery with component aware transformer", section 3.2;
 * IDEA-Research/OSX main/transformer_utils/mmpose/models/backbones/vit.py.
 */
#ifndef MODELS_BODY_OSX_ENCODER_H
#define MODELS_BODY_OSX_ENCODER_H

#include "models/backbones/vit.h"

enum { OSX_HEIGHT = 256, OSX_WIDTH = 192, OSX_ROWS = 16, OSX_COLUMNS = 12, OSX_CELLS = OSX_ROWS * OSX_COLUMNS };

/* The tokens that are asked, by place; a body joint each from OSX_BODY_TOKEN on */
enum {
    OSX_SHAPE_TOKEN, OSX_CAMERA_TOKEN, OSX_EXPRESSION_TOKEN, OSX_JAW_TOKEN, OSX_HAND_TOKENS, OSX_BODY_TOKEN = 6,
    OSX_BODY_JOINTS = 25, OSX_TOKENS = OSX_BODY_TOKEN + OSX_BODY_JOINTS,
};

enum { OSX_MAX_LAYERS = 24 };

typedef struct {
    int width, layers;
    lt_conv_layer patch;
    lt_param *position, *token;     /* (1 + OSX_CELLS, C): the first row is added to all; (OSX_TOKENS, C) */
    vit_block block[OSX_MAX_LAYERS];
    lt_layer_norm_layer norm;
} osx_encoder;

void osx_encoder_new(osx_encoder *m, lt_params *set, const char *prefix, int width, int layers, int heads,
                     double stochastic_depth);

/* osx_encoder_init - for a training from nothing; lt_init_default has been there */
void osx_encoder_init(const osx_encoder *m, uint64_t seed);

typedef struct {
    lt_tensor *map;                 /* (B, C, OSX_ROWS, OSX_COLUMNS) */
    lt_tensor *tokens;              /* (B, OSX_TOKENS, C) */
} osx_features;

/* osx_encoder_forward - image (B, 3, OSX_HEIGHT, OSX_WIDTH) in [0, 1] */
osx_features osx_encoder_forward(const osx_encoder *m, lt_tensor *image);

#endif
