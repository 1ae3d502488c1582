/* SPDX-License-Identifier: Apache-2.0 */
#include "models/reid/unit.h"

lt_batch_norm_layer reid_norm_new(lt_params *set, const char *prefix, int channels, bool compat)
{
    lt_batch_norm_layer bn = lt_batch_norm_layer_new(set, prefix, channels);

    bn.eps = compat ? 1e-3 : bn.eps;
    return bn;
}

reid_conv reid_conv_new(lt_params *set, const char *prefix, int in, int out, int stride, bool compat)
{
    const lt_conv_opts opts = { .stride = stride, .pad = 1 };

    return (reid_conv){
        .conv = lt_conv_layer_new(set, lt_name(set, "%s.conv", prefix), in, out, 3, false, &opts),
        .bn = reid_norm_new(set, lt_name(set, "%s.bn", prefix), out, compat), .compat = compat,
    };
}

/* A row and a column of zeros behind the map's last ones: of its own made 0, so that any batch will do */
static lt_tensor *padded_behind(lt_tensor *x)
{
    x = lt_concat((lt_tensor *[]){ x, lt_scale(lt_slice(x, 2, 0, 1), 0) }, 2, 2);
    return lt_concat((lt_tensor *[]){ x, lt_scale(lt_slice(x, 3, 0, 1), 0) }, 2, 3);
}

lt_tensor *reid_conv_forward(const reid_conv *m, lt_tensor *x)
{
    reid_conv c = *m;

    /* Strides of 2 over an even map need one row of padding, which TensorFlow puts behind. */
    if (m->compat && m->conv.opts.stride == 2 && lt_dim(x, 2) % 2 == 0) {
        x = padded_behind(x);
        c.conv.opts.pad = 0;
    }
    return lt_elu(lt_batch_norm_layer_forward(&c.bn, lt_conv_layer_forward(&c.conv, x)));
}

reid_unit reid_unit_new(lt_params *set, const char *prefix, int in, int out, bool first, double dropout, bool compat)
{
    const int stride = in == out ? 1 : 2;
    const lt_conv_opts keep = { .stride = 1, .pad = 1 }, halve = { .stride = 2 };
    reid_unit m = { .first = first, .doubles = in != out, .dropout = dropout };

    if (!first)
        m.pre = reid_norm_new(set, lt_name(set, "%s.pre", prefix), in, compat);
    m.conv1 = reid_conv_new(set, lt_name(set, "%s.1", prefix), in, out, stride, compat);
    m.conv2 = lt_conv_layer_new(set, lt_name(set, "%s.2.conv", prefix), out, out, 3, true, &keep);
    if (m.doubles)
        m.projection = lt_conv_layer_new(set, lt_name(set, "%s.projection", prefix), in, out, 1, false, &halve);
    return m;
}

lt_tensor *reid_unit_forward(const reid_unit *m, lt_tensor *x)
{
    lt_tensor *y = m->first ? x : lt_elu(lt_batch_norm_layer_forward(&m->pre, x));

    y = reid_conv_forward(&m->conv1, y);
    if (m->dropout > 0)
        y = lt_dropout(y, m->dropout);
    y = lt_conv_layer_forward(&m->conv2, y);
    return lt_add(y, m->doubles ? lt_conv_layer_forward(&m->projection, x) : x);
}
