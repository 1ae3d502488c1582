/* SPDX-License-Identifier: Apache-2.0 */
/*
 * ResNet with bottleneck blocks, stride on the 3x3 convolution ("v1.5"); torchvision's parameter names.
 *
 * Source: He et al. 2016, "Deep residual learning", table 1; torchvision models/resnet.py.
 */
#ifndef MODELS_BACKBONES_RESNET_H
#define MODELS_BACKBONES_RESNET_H

#include "libtensor/nn/layers.h"

enum { RESNET_STAGES = 4, RESNET_MAX_BLOCKS = 36 };

typedef struct {
    lt_conv_layer conv1, conv2, conv3, downsample;
    lt_batch_norm_layer bn1, bn2, bn3, downsample_bn;
    bool has_downsample;
} resnet_bottleneck;

typedef struct {
    lt_conv_layer conv1;
    lt_batch_norm_layer bn1;
    resnet_bottleneck block[RESNET_STAGES][RESNET_MAX_BLOCKS];
    int blocks[RESNET_STAGES];
    int channels[RESNET_STAGES];    /* of C2 .. C5 */
    double slope;                   /* of every activation: 0 for ReLU */
} resnet;

typedef struct {
    int width;                      /* planes of the first stage: 64 for ResNet-50 */
    int blocks[RESNET_STAGES];      /* 3, 4, 6, 3 for ResNet-50 */
    double slope;
} resnet_opts;

/* resnet_new - registers the parameters; prefix "" gives torchvision's own names */
void resnet_new(resnet *m, lt_params *set, const char *prefix, const resnet_opts *opts);

/* Feature maps at strides 4, 8, 16, 32. */
typedef struct {
    lt_tensor *c[RESNET_STAGES];
} resnet_out;

/* resnet_forward - image (B, 3, H, W); n_stages of the four are computed, the rest stay NULL */
resnet_out resnet_forward(const resnet *m, lt_tensor *image, int n_stages);

/* resnet_init - as trained from scratch: convolutions Kaiming normal over fan-out, norms 1 and 0 */
void resnet_init(const resnet *m, uint64_t seed);

#endif
