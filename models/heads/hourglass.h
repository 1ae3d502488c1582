/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stacked-hourglass parts of the hand decoder: a pre-activation bottleneck, one hourglass, and the
 * heat-map head behind it.
 *
 * Source: Newell et al. 2016, "Stacked hourglass networks"; Semi-Hand-Object networks/hand_head.py.
 */
#ifndef MODELS_HEADS_HOURGLASS_H
#define MODELS_HEADS_HOURGLASS_H

#include "libtensor/nn/layers.h"

enum { HOURGLASS_MAX_DEPTH = 6 };

/* PB(C): BN, LReLU, 1x1 to C/2; BN, LReLU, 3x3; BN, LReLU, 1x1 to C; plus its input. */
typedef struct {
    lt_batch_norm_layer bn1, bn2, bn3;
    lt_conv_layer conv1, conv2, conv3;
} preact_bottleneck;

preact_bottleneck preact_bottleneck_new(lt_params *set, const char *prefix, int channels);
lt_tensor *preact_bottleneck_forward(const preact_bottleneck *m, lt_tensor *x);

/* hg(n, x) = PB(x) + up(PB(low)), low = hg(n - 1, PB(pool(x))), and PB(PB(pool(x))) at the bottom. */
typedef struct {
    int depth;
    preact_bottleneck up[HOURGLASS_MAX_DEPTH], low1[HOURGLASS_MAX_DEPTH], low3[HOURGLASS_MAX_DEPTH];
    preact_bottleneck bottom;
} hourglass;

void hourglass_new(hourglass *m, lt_params *set, const char *prefix, int channels, int depth);
lt_tensor *hourglass_forward(const hourglass *m, lt_tensor *x);

/* Hourglass, PB, 1x1 + BN + LReLU -> encoding; 1x1 -> one logit map a joint, softmax with a learned
 * temperature t_j, soft-argmax. */
typedef struct {
    hourglass hg;
    preact_bottleneck residual;
    lt_conv_layer fc, score;
    lt_batch_norm_layer fc_bn;
    lt_param *temperature;          /* (joints) */
} heatmap_head;

typedef struct {
    lt_tensor *encoding;            /* (B, C, R, R) */
    lt_tensor *logits;              /* (B, joints, R R), the temperature in them */
    lt_tensor *heatmaps;            /* (B, joints, R, R), each sums to 1 */
    lt_tensor *joints2d;            /* (B, joints, 2) in [0, 1] of the map without its margin */
    int margin;                     /* cells around the map that joints2d does not count */
} heatmap_out;

/* heatmap_softmax - logits t_j S_j and H_j, their softmax over all cells, for scores S (B, J, h, w) and temperatures
 * t (J) */
void heatmap_softmax(lt_tensor *scores, lt_param *temperature, heatmap_out *out);

void heatmap_head_new(heatmap_head *m, lt_params *set, const char *prefix, int channels, int joints, int depth);
heatmap_out heatmap_head_forward(const heatmap_head *m, lt_tensor *x);

#endif
