/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Between streams: adaptive attention fusion of colour and depth, and cross-attention of hand and object.
 *
 * Source: Bandi and Thomas 2025, section 3; README.md beside this file says what we decided.
 */
#ifndef MODELS_UNIFIED_FUSION_H
#define MODELS_UNIFIED_FUSION_H

#include "libtensor/nn/layers.h"

/* Of one modality: A_c = sigmoid(W_c mean(F)), A_s = conv3x3(relu(F)) */
typedef struct {
    lt_linear_layer channel;
    lt_conv_layer spatial;
    bool sigmoid;                   /* over A_s */
} adaptive_attention;

void adaptive_attention_new(adaptive_attention *m, lt_params *set, const char *prefix, int channels, bool sigmoid);

/* adaptive_attention_init - so that fusion starts near half the sum of both streams */
void adaptive_attention_init(const adaptive_attention *m, uint64_t seed);

/* adaptive_attention_forward - F A_c A_s: (B, C, H, W) -> the same */
lt_tensor *adaptive_attention_forward(const adaptive_attention *m, lt_tensor *features);

/* One head, six projections, both sides at once. */
typedef struct {
    lt_linear_layer q, k, v;
} cross_side;

typedef struct {
    cross_side hand, object;
} cross_attention;

void cross_attention_new(cross_attention *m, lt_params *set, const char *prefix, int channels);

/* cross_attention_forward - hand and object tokens (B, T, C), each plus what it sees of the other */
void cross_attention_forward(const cross_attention *m, lt_tensor **hand, lt_tensor **object);

#endif
