/* SPDX-License-Identifier: Apache-2.0 */
/*
 * EfficientNet-B0: mobile inverted bottlenecks with squeeze and excitation; torchvision's parameter names.
 *
 * Source: Tan and Le 2019, "EfficientNet", table 1; torchvision models/efficientnet.py.
 */
#ifndef MODELS_BACKBONES_EFFICIENTNET_H
#define MODELS_BACKBONES_EFFICIENTNET_H

#include "libtensor/nn/layers.h"

enum { EFFICIENTNET_STAGES = 7, EFFICIENTNET_MAX_BLOCKS = 4, EFFICIENTNET_FEATURES = 1280 };

typedef struct {
    lt_conv_layer expand, depthwise, squeeze, excite, project;
    lt_batch_norm_layer expand_bn, depthwise_bn, project_bn;
    bool has_expand;                /* not where the hidden width is the input's */
    bool residual;
    double drop;                    /* chance that training leaves the block out */
} efficientnet_block;

typedef struct {
    lt_conv_layer stem, head;
    lt_batch_norm_layer stem_bn, head_bn;
    efficientnet_block block[EFFICIENTNET_STAGES][EFFICIENTNET_MAX_BLOCKS];
    int stages, channels;           /* channels of the result */
    bool has_head;
} efficientnet;

/* Whole: { .in = 3, .stages = 7, .has_head = true }. Stages at stride 2, 4, 8, 16, 16, 32, 32 have 16, 24,
 * 40, 80, 112, 192, 320 channels. A cut, or one with other strides, still takes the whole one's weights. */
typedef struct {
    int in;                         /* channels of the image */
    int stages;                     /* the first so many of the seven */
    int last_stride;                /* of the last stage's first block; 0: B0's own */
    int last_dilation;              /* of the last stage's blocks behind the first; 0: 1 */
    bool has_head;                  /* the 1x1 convolution to EFFICIENTNET_FEATURES channels */
    double stochastic_depth;        /* chance to leave out a residual block after the sixteenth; the
                                     * others' grows towards it from 0. torchvision: 0.2 */
} efficientnet_opts;

/* efficientnet_new - registers the parameters; prefix "" gives torchvision's own names */
void efficientnet_new(efficientnet *m, lt_params *set, const char *prefix, const efficientnet_opts *opts);

/* efficientnet_forward - image (B, in, H, W) -> (B, channels, H / stride, W / stride) */
lt_tensor *efficientnet_forward(const efficientnet *m, lt_tensor *image);

/* efficientnet_init - as trained from scratch, after lt_init_default: convolutions Kaiming normal over
 * fan-out, their biases 0 */
void efficientnet_init(const efficientnet *m, uint64_t seed);

#endif
