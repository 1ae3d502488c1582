/* SPDX-License-Identifier: Apache-2.0 */
#include "models/backbones/resnet.h"

#include "libtensor/nn/init.h"

#include <math.h>

static resnet_bottleneck bottleneck_new(lt_params *set, const char *prefix, int in, int planes, int stride)
{
    const lt_conv_opts spatial = { .stride = stride, .pad = 1 }, shortcut = { .stride = stride };
    resnet_bottleneck b = { .has_downsample = stride != 1 || in != 4 * planes };

    b.conv1 = lt_conv_layer_new(set, lt_name(set, "%s.conv1", prefix), in, planes, 1, false, NULL);
    b.bn1 = lt_batch_norm_layer_new(set, lt_name(set, "%s.bn1", prefix), planes);
    b.conv2 = lt_conv_layer_new(set, lt_name(set, "%s.conv2", prefix), planes, planes, 3, false, &spatial);
    b.bn2 = lt_batch_norm_layer_new(set, lt_name(set, "%s.bn2", prefix), planes);
    b.conv3 = lt_conv_layer_new(set, lt_name(set, "%s.conv3", prefix), planes, 4 * planes, 1, false, NULL);
    b.bn3 = lt_batch_norm_layer_new(set, lt_name(set, "%s.bn3", prefix), 4 * planes);
    if (b.has_downsample) {
        b.downsample = lt_conv_layer_new(set, lt_name(set, "%s.downsample.0", prefix), in, 4 * planes, 1,
                                         false, &shortcut);
        b.downsample_bn = lt_batch_norm_layer_new(set, lt_name(set, "%s.downsample.1", prefix), 4 * planes);
    }
    return b;
}

void resnet_new(resnet *m, lt_params *set, const char *prefix, const resnet_opts *opts)
{
    const char *dot = *prefix ? "." : "";
    int in = opts->width;

    m->slope = opts->slope;
    m->conv1 = lt_conv_layer_new(set, lt_name(set, "%s%sconv1", prefix, dot), 3, in, 7, false,
                                 &(lt_conv_opts){ .stride = 2, .pad = 3 });
    m->bn1 = lt_batch_norm_layer_new(set, lt_name(set, "%s%sbn1", prefix, dot), in);
    for (int s = 0; s < RESNET_STAGES; s++) {
        const int planes = opts->width << s;

        m->blocks[s] = opts->blocks[s];
        m->channels[s] = 4 * planes;
        for (int i = 0; i < opts->blocks[s]; i++) {
            const char *name = lt_name(set, "%s%slayer%d.%d", prefix, dot, s + 1, i);

            m->block[s][i] = bottleneck_new(set, name, in, planes, s > 0 && i == 0 ? 2 : 1);
            in = 4 * planes;
        }
    }
}

static lt_tensor *conv_bn(const lt_conv_layer *conv, const lt_batch_norm_layer *bn, lt_tensor *x)
{
    return lt_batch_norm_layer_forward(bn, lt_conv_layer_forward(conv, x));
}

static lt_tensor *bottleneck_forward(const resnet_bottleneck *b, lt_tensor *x, double slope)
{
    lt_tensor *shortcut = b->has_downsample ? conv_bn(&b->downsample, &b->downsample_bn, x) : x;
    lt_tensor *y = lt_leaky_relu(conv_bn(&b->conv1, &b->bn1, x), slope);

    y = lt_leaky_relu(conv_bn(&b->conv2, &b->bn2, y), slope);
    return lt_leaky_relu(lt_add(conv_bn(&b->conv3, &b->bn3, y), shortcut), slope);
}

resnet_out resnet_forward(const resnet *m, lt_tensor *image, int n_stages)
{
    lt_tensor *x = lt_leaky_relu(conv_bn(&m->conv1, &m->bn1, image), m->slope);
    resnet_out out = { { NULL } };

    x = lt_max_pool2d(x, 3, 2, 1, false);
    for (int s = 0; s < n_stages; s++) {
        for (int i = 0; i < m->blocks[s]; i++)
            x = bottleneck_forward(&m->block[s][i], x, m->slope);
        out.c[s] = x;
    }
    return out;
}

static void init_conv(const lt_conv_layer *conv, uint64_t seed)
{
    lt_init_normal(conv->weight, seed, sqrt(2 / lt_fan_out(conv->weight)));
}

void resnet_init(const resnet *m, uint64_t seed)
{
    init_conv(&m->conv1, seed);
    for (int s = 0; s < RESNET_STAGES; s++)
        for (int i = 0; i < m->blocks[s]; i++) {
            const resnet_bottleneck *b = &m->block[s][i];

            init_conv(&b->conv1, seed);
            init_conv(&b->conv2, seed);
            init_conv(&b->conv3, seed);
            if (b->has_downsample)
                init_conv(&b->downsample, seed);
        }
}
