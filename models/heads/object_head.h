/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The object decoder: for each cell of a map and each of 21 control points a confidence and a place in the
 * image, and the losses on them.
 *
 * Source: Semi-Hand-Object networks/object_head.py and networks/loss.py.
 */
#ifndef MODELS_HEADS_OBJECT_HEAD_H
#define MODELS_HEADS_OBJECT_HEAD_H

#include "libtensor/nn/layers.h"

enum { OBJECT_POINTS = 21, OBJECT_LAYERS = 3 };

typedef struct {
    lt_conv_layer conv1[OBJECT_LAYERS], conv2[OBJECT_LAYERS], head;
    lt_batch_norm_layer bn1[OBJECT_LAYERS], bn2[OBJECT_LAYERS];
} object_head;

/* Each (B, 21, R, R); places in units of the pooled box. */
typedef struct {
    lt_tensor *conf, *x, *y;
} object_out;

void object_head_new(object_head *m, lt_params *set, const char *prefix, int channels);
object_out object_head_forward(const object_head *m, lt_tensor *features);

typedef struct {
    lt_tensor *p2d, *conf;          /* unweighted */
} object_losses;

/**
 * object_head_losses - L1 of masked places, L1 of confidences
 *
 *   points   (B, 21, 2) true places in units of the box
 *   mask     (B, R, R) 1 where the object is, hidden parts included
 *   weight   (B) of the samples, or NULL
 *
 * The confidence's target exp(-distance) mask is made from the predictions and is constant.
 */
object_losses object_head_losses(const object_out *o, lt_tensor *points, lt_tensor *mask, lt_tensor *weight);

#endif
