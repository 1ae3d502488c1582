/* SPDX-License-Identifier: Apache-2.0 */
/* The shape of what a convolution makes. */
#include "libtensor/kernels/conv/conv.h"

/* Of n cells and their padding; 0 where the window does not fit */
static int64_t out_size(int64_t n, int pad, int window, int dilation, int stride)
{
    const int64_t free = n + 2 * (int64_t)pad - (int64_t)dilation * (window - 1) - 1;

    return free < 0 ? 0 : free / stride + 1;
}

int64_t lt_conv2d_out_h(const lt_conv2d_params *p)
{
    return out_size(p->h, p->pad_h, p->kh, p->dil_h, p->stride_h);
}

int64_t lt_conv2d_out_w(const lt_conv2d_params *p)
{
    return out_size(p->w, p->pad_w, p->kw, p->dil_w, p->stride_w);
}

lt_rect lt_conv2d_all(const lt_conv2d_params *p)
{
    return (lt_rect){ 0, lt_conv2d_out_h(p), 0, lt_conv2d_out_w(p) };
}
