/* SPDX-License-Identifier: Apache-2.0 */
#include "models/detect/blocks.h"

conv_block conv_block_new(lt_params *set, const char *prefix, int in, int out, int k, int stride)
{
    const lt_conv_opts opts = { .stride = stride, .pad = k / 2 };
    conv_block b = {
        .conv = lt_conv_layer_new(set, lt_name(set, "%s.conv", prefix), in, out, k, false, &opts),
        .bn = lt_batch_norm_layer_new(set, lt_name(set, "%s.bn", prefix), out),
    };

    b.bn.eps = 1e-3;
    b.bn.running_mean->momentum = b.bn.running_var->momentum = 0.03;
    return b;
}

lt_tensor *conv_block_forward(const conv_block *m, lt_tensor *x)
{
    return lt_silu(lt_batch_norm_layer_forward(&m->bn, lt_conv_layer_forward(&m->conv, x)));
}

c2f c2f_new(lt_params *set, const char *prefix, int in, int out, int n, bool shortcut)
{
    c2f m = {
        .first = conv_block_new(set, lt_name(set, "%s.cv1", prefix), in, out, 1, 1),
        .last = conv_block_new(set, lt_name(set, "%s.cv2", prefix), (2 + n) * (out / 2), out, 1, 1),
        .n = n, .half = out / 2, .shortcut = shortcut,
    };

    for (int i = 0; i < n; i++)
        for (int k = 0; k < 2; k++)
            m.bottleneck[i][k] = conv_block_new(set, lt_name(set, "%s.m.%d.cv%d", prefix, i, k + 1), m.half, m.half, 3,
                                                1);
    return m;
}

lt_tensor *c2f_forward(const c2f *m, lt_tensor *x)
{
    lt_tensor *part[1 + C2F_MAX_BOTTLENECKS], *chain;

    part[0] = conv_block_forward(&m->first, x);         /* both halves */
    chain = lt_slice(part[0], 1, m->half, m->half);
    for (int i = 0; i < m->n; i++) {
        lt_tensor *y = conv_block_forward(&m->bottleneck[i][0], chain);

        y = conv_block_forward(&m->bottleneck[i][1], y);
        chain = part[1 + i] = m->shortcut ? lt_add(y, chain) : y;
    }
    return conv_block_forward(&m->last, lt_concat(part, 1 + m->n, 1));
}

sppf sppf_new(lt_params *set, const char *prefix, int channels)
{
    return (sppf){
        .first = conv_block_new(set, lt_name(set, "%s.cv1", prefix), channels, channels / 2, 1, 1),
        .last = conv_block_new(set, lt_name(set, "%s.cv2", prefix), 2 * channels, channels, 1, 1),
    };
}

lt_tensor *sppf_forward(const sppf *m, lt_tensor *x)
{
    lt_tensor *part[4] = { conv_block_forward(&m->first, x) };

    for (int i = 1; i < 4; i++)
        part[i] = lt_max_pool2d(part[i - 1], 5, 1, 2, false);
    return conv_block_forward(&m->last, lt_concat(part, 4, 1));
}
