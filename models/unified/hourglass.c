/* SPDX-License-Identifier: Apache-2.0 */
#include "models/unified/hourglass.h"

enum { UP3_WINDOW = 6 };

static conv_norm conv_norm_new(lt_params *set, const char *prefix, int in, int out, int k)
{
    const lt_conv_opts opts = { .pad = k / 2 };

    return (conv_norm){
        .conv = lt_conv_layer_new(set, lt_name(set, "%s.conv", prefix), in, out, k, false, &opts),
        .bn = lt_batch_norm_layer_new(set, lt_name(set, "%s.bn", prefix), out),
    };
}

static lt_tensor *conv_norm_relu(const conv_norm *m, lt_tensor *x)
{
    return lt_relu(lt_batch_norm_layer_forward(&m->bn, lt_conv_layer_forward(&m->conv, x)));
}

static transposed_conv transposed_new(lt_params *set, const char *prefix, int in, int out, int k, int pad, bool bias)
{
    return (transposed_conv){
        .weight = lt_params_add(set, prefix, "weight", LT_WEIGHT, LT_SHAPE(in, out, k, k)),
        .bias = bias ? lt_params_add(set, prefix, "bias", LT_WEIGHT, LT_SHAPE(out)) : NULL,
        .stride = 2, .pad = pad,
    };
}

static lt_tensor *transposed_forward(const transposed_conv *m, lt_tensor *x)
{
    lt_tensor *bias = m->bias ? lt_use(x->graph, m->bias) : NULL;

    return lt_conv_transpose2d(x, lt_use(x->graph, m->weight), bias, m->stride, m->pad);
}

void unified_hourglass_new(unified_hourglass *m, lt_params *set, const char *prefix, int cells, int channels,
                           int joints, bool up3_relu)
{
    const int c[4] = { channels, 2 * channels, 4 * channels, 8 * channels };
    const int up1 = cells / 4 % 2 ? 3 : 4;

    m->cells = cells;
    m->up3_relu = up3_relu;
    for (int i = 0; i < 3; i++) {
        m->conv[i] = conv_norm_new(set, lt_name(set, "%s.conv%d", prefix, i + 1), c[i], c[i], 3);
        m->down[i] = conv_norm_new(set, lt_name(set, "%s.down%d", prefix, i + 1), c[i], c[i + 1], 1);
    }
    m->bottleneck = preact_bottleneck_new(set, lt_name(set, "%s.bottleneck", prefix), c[3]);
    m->up[0] = transposed_new(set, lt_name(set, "%s.up1.conv", prefix), c[3], c[2], up1, 1, false);
    m->up_bn[0] = lt_batch_norm_layer_new(set, lt_name(set, "%s.up1.bn", prefix), c[2]);
    m->up[1] = transposed_new(set, lt_name(set, "%s.up2.conv", prefix), c[2], c[1], 4, 1, false);
    m->up_bn[1] = lt_batch_norm_layer_new(set, lt_name(set, "%s.up2.bn", prefix), c[1]);
    m->up[2] = transposed_new(set, lt_name(set, "%s.up3", prefix), c[1], joints, UP3_WINDOW, 0, true);
    m->temperature = lt_params_add(set, prefix, "temperature", LT_WEIGHT, LT_SHAPE(joints));
}

/* Window 6 at stride 2 puts a margin of two cells around the map: (u G - 2) / cells of it. */
static lt_tensor *without_margin(const unified_hourglass *m, lt_tensor *joints2d)
{
    const lt_real margin = -(lt_real)HOURGLASS_MARGIN / (lt_real)m->cells;
    const double grid = m->cells + 2 * HOURGLASS_MARGIN;

    return lt_add(lt_scale(joints2d, grid / m->cells), lt_constant(joints2d->graph, LT_F32, LT_SHAPE(1), &margin));
}

heatmap_out unified_hourglass_forward(const unified_hourglass *m, lt_tensor *x)
{
    lt_tensor *e[3], *z;
    heatmap_out out = { .margin = HOURGLASS_MARGIN };

    for (int i = 0; i < 3; i++) {
        e[i] = conv_norm_relu(&m->conv[i], x);
        x = conv_norm_relu(&m->down[i], lt_max_pool2d(e[i], 2, 2, 0, true));
    }
    x = preact_bottleneck_forward(&m->bottleneck, x);
    for (int i = 0; i < 2; i++)
        x = lt_add(lt_relu(lt_batch_norm_layer_forward(&m->up_bn[i], transposed_forward(&m->up[i], x))), e[2 - i]);
    out.encoding = x;                                                                   /* E */
    z = transposed_forward(&m->up[2], x);                                               /* Z */
    heatmap_softmax(m->up3_relu ? lt_relu(z) : z, m->temperature, &out);
    out.joints2d = without_margin(m, lt_soft_argmax2d(out.heatmaps));
    return out;
}

/* ---- the mesh encoder --------------------------------------------------------------------------------- */

void mesh_encoder_new(mesh_encoder *m, lt_params *set, const char *prefix, int cells, int channels, int joints)
{
    const lt_conv_opts half = { .stride = 2 };
    int levels = 0;

    for (int side = cells / 2; side > 2; side = (side + 1) / 2)
        levels++;
    m->heatmap_conv = lt_conv_layer_new(set, lt_name(set, "%s.heatmap_conv", prefix), joints, channels, UP3_WINDOW,
                                        true, &half);
    m->mix = lt_conv_layer_new(set, lt_name(set, "%s.mix", prefix), 3 * channels, 4 * channels, 1, true, NULL);
    residual_tower_new(&m->tower, set, lt_name(set, "%s.reg", prefix), 4 * channels, levels);
}

lt_tensor *mesh_encoder_forward(const mesh_encoder *m, const heatmap_out *heat)
{
    lt_tensor *maps = lt_conv_layer_forward(&m->heatmap_conv, heat->heatmaps);
    lt_tensor *both = lt_concat((lt_tensor *[]){ heat->encoding, maps }, 2, 1);

    return residual_tower_forward(&m->tower, lt_conv_layer_forward(&m->mix, both));
}
