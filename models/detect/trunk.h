/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Backbone and neck: from an image to three maps, of strides 8, 16 and 32. Layers have their numbers in the figure,
 * which published files of weights name them by.
 */
#ifndef MODELS_DETECT_TRUNK_H
#define MODELS_DETECT_TRUNK_H

#include "models/detect/blocks.h"

enum { DETECT_LEVELS = 3 };

typedef struct {
    conv_block down0, down1, down3, down5, down7;
    c2f c2f2, c2f4, c2f6, c2f8;
    sppf sppf9;
} backbone;

typedef struct { lt_tensor *c[DETECT_LEVELS]; } backbone_out;      /* 64, 128, 256 channels */

void backbone_new(backbone *m, lt_params *set, const char *prefix);
backbone_out backbone_forward(const backbone *m, lt_tensor *image);

/* A pyramid down to the finest level and up again.
 * Source: Lin et al. 2017, "Feature pyramid networks"; Liu et al. 2018, "Path aggregation network". */
typedef struct {
    c2f c2f12, c2f15, c2f18, c2f21;
    conv_block down16, down19;
} neck;

typedef struct { lt_tensor *p[DETECT_LEVELS]; } neck_out;

extern const int neck_channels[DETECT_LEVELS];

void neck_new(neck *m, lt_params *set, const char *prefix);
neck_out neck_forward(const neck *m, const backbone_out *c);

#endif
