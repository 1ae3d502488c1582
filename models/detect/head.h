/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The detector's head: for each cell of each level the sides of a box, a logit for each class, and coefficients that
 * make a mask of the prototypes.
 */
#ifndef MODELS_DETECT_HEAD_H
#define MODELS_DETECT_HEAD_H

#include "models/detect/trunk.h"

enum { DETECT_BINS = 16, DETECT_SIDES = 4, DETECT_COEFFICIENTS = 32 };

/* Two 3 x 3 blocks and a 1 x 1 convolution with bias */
typedef struct {
    conv_block block[2];
    lt_conv_layer last;
} head_branch;

typedef struct {
    head_branch box[DETECT_LEVELS], cls[DETECT_LEVELS], mask[DETECT_LEVELS];
    lt_param *bin;                  /* 0 .. 15, whose mean under a side's softmax is its distance: fixed, and counted
                                     * where published counts count it */
    struct {
        conv_block cv1, cv2, cv3;
        lt_param *up, *up_bias;     /* a transposed convolution, 2 x 2 with stride 2 */
    } proto;
} detect_head;

/* H x W cells of a level, in this order: left, top, right, bottom with 16 bins each */
typedef struct {
    lt_tensor *box[DETECT_LEVELS];      /* (B, 64, H, W) */
    lt_tensor *cls[DETECT_LEVELS];      /* (B, classes, H, W) logits */
    lt_tensor *mask[DETECT_LEVELS];     /* (B, 32, H, W) */
    lt_tensor *proto;                   /* (B, 32, h, w), of stride 4 */
} detect_maps;

void detect_head_new(detect_head *m, lt_params *set, const char *prefix, int classes);
detect_maps detect_head_forward(const detect_head *m, const neck_out *p);

/* detect_head_init - biases: boxes of one bin's length, and classes as rare as 5 objects in an image of 640 */
void detect_head_init(const detect_head *m);

#endif
