/* SPDX-License-Identifier: Apache-2.0 */
#include "models/detect/trunk.h"

const int neck_channels[DETECT_LEVELS] = { 64, 128, 256 };

void backbone_new(backbone *m, lt_params *set, const char *prefix)
{
#define NAME(n) lt_name(set, "%s." #n, prefix)
    m->down0 = conv_block_new(set, NAME(0), 3, 16, 3, 2);
    m->down1 = conv_block_new(set, NAME(1), 16, 32, 3, 2);
    m->c2f2 = c2f_new(set, NAME(2), 32, 32, 1, true);
    m->down3 = conv_block_new(set, NAME(3), 32, 64, 3, 2);
    m->c2f4 = c2f_new(set, NAME(4), 64, 64, 2, true);
    m->down5 = conv_block_new(set, NAME(5), 64, 128, 3, 2);
    m->c2f6 = c2f_new(set, NAME(6), 128, 128, 2, true);
    m->down7 = conv_block_new(set, NAME(7), 128, 256, 3, 2);
    m->c2f8 = c2f_new(set, NAME(8), 256, 256, 1, true);
    m->sppf9 = sppf_new(set, NAME(9), 256);
}

backbone_out backbone_forward(const backbone *m, lt_tensor *image)
{
    lt_tensor *x = conv_block_forward(&m->down0, image);
    backbone_out out;

    x = c2f_forward(&m->c2f2, conv_block_forward(&m->down1, x));
    out.c[0] = x = c2f_forward(&m->c2f4, conv_block_forward(&m->down3, x));
    out.c[1] = x = c2f_forward(&m->c2f6, conv_block_forward(&m->down5, x));
    x = c2f_forward(&m->c2f8, conv_block_forward(&m->down7, x));
    out.c[2] = sppf_forward(&m->sppf9, x);
    return out;
}

void neck_new(neck *m, lt_params *set, const char *prefix)
{
    m->c2f12 = c2f_new(set, NAME(12), 256 + 128, 128, 1, false);
    m->c2f15 = c2f_new(set, NAME(15), 128 + 64, 64, 1, false);
    m->down16 = conv_block_new(set, NAME(16), 64, 64, 3, 2);
    m->c2f18 = c2f_new(set, NAME(18), 64 + 128, 128, 1, false);
    m->down19 = conv_block_new(set, NAME(19), 128, 128, 3, 2);
    m->c2f21 = c2f_new(set, NAME(21), 128 + 256, 256, 1, false);
#undef NAME
}

static lt_tensor *joined(lt_tensor *a, lt_tensor *b)
{
    return lt_concat((lt_tensor *[]){ a, b }, 2, 1);
}

neck_out neck_forward(const neck *m, const backbone_out *c)
{
    lt_tensor *down = c2f_forward(&m->c2f12, joined(lt_upsample_nearest(c->c[2], 2), c->c[1]));
    neck_out out;

    out.p[0] = c2f_forward(&m->c2f15, joined(lt_upsample_nearest(down, 2), c->c[0]));
    out.p[1] = c2f_forward(&m->c2f18, joined(conv_block_forward(&m->down16, out.p[0]), down));
    out.p[2] = c2f_forward(&m->c2f21, joined(conv_block_forward(&m->down19, out.p[1]), c->c[2]));
    return out;
}
