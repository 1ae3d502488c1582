/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the detector is put together of: a convolution with norm and SiLU, cross-stage partial blocks, and pooling over
 * windows of several sizes.
 */
#ifndef MODELS_DETECT_BLOCKS_H
#define MODELS_DETECT_BLOCKS_H

#include "libtensor/nn/layers.h"

/* Convolution without bias, batch norm (eps 1e-3, momentum 0.03), SiLU */
typedef struct {
    lt_conv_layer conv;
    lt_batch_norm_layer bn;
} conv_block;

/* conv_block_new - k x k, padded by k / 2 */
conv_block conv_block_new(lt_params *set, const char *prefix, int in, int out, int k, int stride);
lt_tensor *conv_block_forward(const conv_block *m, lt_tensor *x);

enum { C2F_MAX_BOTTLENECKS = 2 };

/* Half of the channels go through a chain of bottlenecks; both halves and what each bottleneck made are joined.
 * Source: Wang et al. 2020, "CSPNet"; every bottleneck's result joined as in Wang et al. 2022, "ELAN". */
typedef struct {
    conv_block first, last;         /* 1 x 1 */
    conv_block bottleneck[C2F_MAX_BOTTLENECKS][2];      /* 3 x 3 each */
    int n, half;
    bool shortcut;
} c2f;

c2f c2f_new(lt_params *set, const char *prefix, int in, int out, int n, bool shortcut);
lt_tensor *c2f_forward(const c2f *m, lt_tensor *x);

/* The map beside its maxima over 5 x 5, 9 x 9 and 13 x 13 windows.
 * Source: He et al. 2014, "Spatial pyramid pooling"; each window is one more of 5 x 5 over the one before. */
typedef struct { conv_block first, last; } sppf;

sppf sppf_new(lt_params *set, const char *prefix, int channels);
lt_tensor *sppf_forward(const sppf *m, lt_tensor *x);

#endif
