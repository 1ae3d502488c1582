/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The hand-object cross-attention transformer: the hand's map asks, the object's map under the hand box
 * answers, in a stack of blocks that share keys' and values' source.              [HOCAT section 3.3]
 */
#ifndef MODELS_HOCAT_ATTENTION_H
#define MODELS_HOCAT_ATTENTION_H

#include "libtensor/nn/layers.h"

enum { HOCAT_MAX_DEPTH = 8 };

typedef struct {
    lt_conv_layer q, k, v;          /* 1 x 1 */
    lt_layer_norm_layer norm;
    lt_linear_layer fc1, fc2;
} hocat_block;

typedef struct {
    hocat_block block[HOCAT_MAX_DEPTH];
    int depth, heads;
} hocat_attention;

void hocat_attention_new(hocat_attention *m, lt_params *set, const char *prefix, int channels, int depth,
                         int heads, int mlp_ratio);

/* hocat_attention_forward - hand and object (B, C, R, R) -> (B, C, R, R) */
lt_tensor *hocat_attention_forward(const hocat_attention *m, lt_tensor *hand, lt_tensor *object);

/* hocat_fused_forward - the same by one block for 2 C channels that asks itself: hand and object side by side, of which
 * the hand's channels stay                                                           [HFL networks/CR.py] */
lt_tensor *hocat_fused_forward(const hocat_attention *m, lt_tensor *hand, lt_tensor *object);

#endif
