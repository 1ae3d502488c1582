/* SPDX-License-Identifier: Apache-2.0 */
#include "models/heads/hourglass.h"

static const double SLOPE = 0.01;

preact_bottleneck preact_bottleneck_new(lt_params *set, const char *prefix, int channels)
{
    const int half = channels / 2;
    const lt_conv_opts pad = { .pad = 1 };

    return (preact_bottleneck){
        .bn1 = lt_batch_norm_layer_new(set, lt_name(set, "%s.bn1", prefix), channels),
        .conv1 = lt_conv_layer_new(set, lt_name(set, "%s.conv1", prefix), channels, half, 1, true, NULL),
        .bn2 = lt_batch_norm_layer_new(set, lt_name(set, "%s.bn2", prefix), half),
        .conv2 = lt_conv_layer_new(set, lt_name(set, "%s.conv2", prefix), half, half, 3, true, &pad),
        .bn3 = lt_batch_norm_layer_new(set, lt_name(set, "%s.bn3", prefix), half),
        .conv3 = lt_conv_layer_new(set, lt_name(set, "%s.conv3", prefix), half, channels, 1, true, NULL),
    };
}

static lt_tensor *bn_act_conv(const lt_batch_norm_layer *bn, const lt_conv_layer *conv, lt_tensor *x)
{
    return lt_conv_layer_forward(conv, lt_leaky_relu(lt_batch_norm_layer_forward(bn, x), SLOPE));
}

lt_tensor *preact_bottleneck_forward(const preact_bottleneck *m, lt_tensor *x)
{
    lt_tensor *y = bn_act_conv(&m->bn1, &m->conv1, x);

    y = bn_act_conv(&m->bn2, &m->conv2, y);
    return lt_add(bn_act_conv(&m->bn3, &m->conv3, y), x);
}

void hourglass_new(hourglass *m, lt_params *set, const char *prefix, int channels, int depth)
{
    m->depth = depth;
    for (int i = 0; i < depth; i++) {
        m->up[i] = preact_bottleneck_new(set, lt_name(set, "%s.up.%d", prefix, i), channels);
        m->low1[i] = preact_bottleneck_new(set, lt_name(set, "%s.low1.%d", prefix, i), channels);
        m->low3[i] = preact_bottleneck_new(set, lt_name(set, "%s.low3.%d", prefix, i), channels);
    }
    m->bottom = preact_bottleneck_new(set, lt_name(set, "%s.bottom", prefix), channels);
}

static lt_tensor *level(const hourglass *m, int i, lt_tensor *x)
{
    lt_tensor *up = preact_bottleneck_forward(&m->up[i], x);
    lt_tensor *low = preact_bottleneck_forward(&m->low1[i], lt_max_pool2d(x, 2, 2, 0, false));

    low = i + 1 < m->depth ? level(m, i + 1, low) : preact_bottleneck_forward(&m->bottom, low);
    return lt_add(up, lt_upsample_nearest(preact_bottleneck_forward(&m->low3[i], low), 2));
}

lt_tensor *hourglass_forward(const hourglass *m, lt_tensor *x)
{
    return level(m, 0, x);
}

void heatmap_head_new(heatmap_head *m, lt_params *set, const char *prefix, int channels, int joints, int depth)
{
    hourglass_new(&m->hg, set, lt_name(set, "%s.hg", prefix), channels, depth);
    m->residual = preact_bottleneck_new(set, lt_name(set, "%s.res", prefix), channels);
    m->fc = lt_conv_layer_new(set, lt_name(set, "%s.fc.0", prefix), channels, channels, 1, true, NULL);
    m->fc_bn = lt_batch_norm_layer_new(set, lt_name(set, "%s.fc.1", prefix), channels);
    m->score = lt_conv_layer_new(set, lt_name(set, "%s.score", prefix), channels, joints, 1, true, NULL);
    m->temperature = lt_params_add(set, prefix, "temperature", LT_WEIGHT, LT_SHAPE(joints));
}

void heatmap_softmax(lt_tensor *scores, lt_param *temperature, heatmap_out *out)
{
    const int64_t B = lt_dim(scores, 0), J = lt_dim(scores, 1), cells = lt_dim(scores, 2) * lt_dim(scores, 3);
    lt_tensor *t = lt_reshape(lt_use(scores->graph, temperature), LT_SHAPE(J, 1));

    out->logits = lt_mul(lt_reshape(scores, LT_SHAPE(B, J, cells)), t);
    out->heatmaps = lt_reshape(lt_softmax(out->logits), scores->shape);
}

heatmap_out heatmap_head_forward(const heatmap_head *m, lt_tensor *x)
{
    lt_tensor *y = preact_bottleneck_forward(&m->residual, hourglass_forward(&m->hg, x));
    heatmap_out out = { .margin = 0 };

    out.encoding = lt_leaky_relu(lt_batch_norm_layer_forward(&m->fc_bn, lt_conv_layer_forward(&m->fc, y)), SLOPE);
    heatmap_softmax(lt_conv_layer_forward(&m->score, out.encoding), m->temperature, &out);
    out.joints2d = lt_soft_argmax2d(out.heatmaps);
    return out;
}
