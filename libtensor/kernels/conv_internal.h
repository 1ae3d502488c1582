/* SPDX-License-Identifier: Apache-2.0 */
/* What the directions of a convolution share: sizes, and how a window lies on a map. For conv*.c only. */
#ifndef LT_KERNELS_CONV_INTERNAL_H
#define LT_KERNELS_CONV_INTERNAL_H

#include "libtensor/kernels/conv.h"

static inline int64_t conv_group_c(const lt_conv2d_params *p) { return p->c / p->groups; }
static inline int64_t conv_group_o(const lt_conv2d_params *p) { return p->o / p->groups; }

static inline int64_t conv_weight_count(const lt_conv2d_params *p)
{
    return p->o * conv_group_c(p) * p->kh * p->kw;
}

static inline bool conv_pointwise(const lt_conv2d_params *p)
{
    return p->kh == 1 && p->kw == 1 && p->stride_h == 1 && p->stride_w == 1 && !p->pad_h && !p->pad_w;
}

/* Neither input nor output, or too large a window: nothing is done. */
static inline bool conv_nothing(const lt_conv2d_params *p)
{
    return p->n < 1 || p->c < 1 || p->o < 1 || lt_conv2d_out_h(p) < 1 || lt_conv2d_out_w(p) < 1
           || (int64_t)p->kh * p->kw > LT_CONV_MOST_TAPS;
}

/* The taps of the window, and where their weights stand. */
typedef struct { lt_tap at[LT_CONV_MOST_TAPS]; int weight[LT_CONV_MOST_TAPS]; int n; } conv_taps;

static inline void conv_window_taps(conv_taps *t, const lt_conv2d_params *p)
{
    t->n = 0;
    for (int ky = 0; ky < p->kh; ky++)
        for (int kx = 0; kx < p->kw; kx++) {
            t->at[t->n] = (lt_tap){ ky * p->dil_h - p->pad_h, kx * p->dil_w - p->pad_w };
            t->weight[t->n] = t->n;
            t->n++;
        }
}

/* How the window of output position (row, column) lies on x. */
static inline lt_conv_image conv_window_image(const lt_conv2d_params *p, const lt_real *x, const conv_taps *t)
{
    const lt_conv_image g = {
        .x = x, .h = p->h, .w = p->w, .grid_w = lt_conv2d_out_w(p),
        .step_h = p->stride_h, .step_w = p->stride_w, .taps = t->n, .tap = t->at,
    };
    return g;
}

#endif
