/* SPDX-License-Identifier: Apache-2.0 */
#include "models/detect/head.h"

#include "libtensor/nn/init.h"

#include <math.h>

enum { PROTO = 64 };

static head_branch branch_new(lt_params *set, const char *prefix, int in, int middle, int out)
{
    return (head_branch){
        .block[0] = conv_block_new(set, lt_name(set, "%s.0", prefix), in, middle, 3, 1),
        .block[1] = conv_block_new(set, lt_name(set, "%s.1", prefix), middle, middle, 3, 1),
        .last = lt_conv_layer_new(set, lt_name(set, "%s.2", prefix), middle, out, 1, true, NULL),
    };
}

static int between(int x, int lo, int hi)
{
    return x < lo ? lo : x > hi ? hi : x;
}

void detect_head_new(detect_head *m, lt_params *set, const char *prefix, int classes)
{
    const char *up = lt_name(set, "%s.proto.upsample", prefix);
    const int cls = between(classes, neck_channels[0], 100 > neck_channels[0] ? 100 : neck_channels[0]);

    for (int i = 0; i < DETECT_LEVELS; i++) {
        const int in = neck_channels[i];

        m->box[i] = branch_new(set, lt_name(set, "%s.box.%d", prefix, i), in, 64, DETECT_SIDES * DETECT_BINS);
        m->cls[i] = branch_new(set, lt_name(set, "%s.class.%d", prefix, i), in, cls, classes);
        m->mask[i] = branch_new(set, lt_name(set, "%s.mask.%d", prefix, i), in, 32, DETECT_COEFFICIENTS);
    }
    m->bin = lt_params_add(set, prefix, "dfl.conv.weight", LT_WEIGHT, LT_SHAPE(1, DETECT_BINS, 1, 1));
    m->bin->frozen = true;
    m->proto.cv1 = conv_block_new(set, lt_name(set, "%s.proto.cv1", prefix), neck_channels[0], PROTO, 3, 1);
    m->proto.up = lt_params_add(set, up, "weight", LT_WEIGHT, LT_SHAPE(PROTO, PROTO, 2, 2));
    m->proto.up_bias = lt_params_add(set, up, "bias", LT_WEIGHT, LT_SHAPE(PROTO));
    m->proto.cv2 = conv_block_new(set, lt_name(set, "%s.proto.cv2", prefix), PROTO, PROTO, 3, 1);
    m->proto.cv3 = conv_block_new(set, lt_name(set, "%s.proto.cv3", prefix), PROTO, DETECT_COEFFICIENTS, 1, 1);
}

static lt_tensor *branch_forward(const head_branch *m, lt_tensor *x)
{
    x = conv_block_forward(&m->block[1], conv_block_forward(&m->block[0], x));
    return lt_conv_layer_forward(&m->last, x);
}

static lt_tensor *prototypes(const detect_head *m, lt_tensor *x)
{
    lt_graph *g = x->graph;

    x = lt_conv_transpose2d(conv_block_forward(&m->proto.cv1, x), lt_use(g, m->proto.up), lt_use(g, m->proto.up_bias),
                            2, 0);
    return conv_block_forward(&m->proto.cv3, conv_block_forward(&m->proto.cv2, x));
}

detect_maps detect_head_forward(const detect_head *m, const neck_out *p)
{
    detect_maps out = { .proto = prototypes(m, p->p[0]) };

    for (int i = 0; i < DETECT_LEVELS; i++) {
        out.box[i] = branch_forward(&m->box[i], p->p[i]);
        out.cls[i] = branch_forward(&m->cls[i], p->p[i]);
        out.mask[i] = branch_forward(&m->mask[i], p->p[i]);
    }
    return out;
}

void detect_head_init(const detect_head *m)
{
    for (int i = 0; i < DETECT_LEVELS; i++) {
        const double classes = (double)lt_param_numel(m->cls[i].last.bias), cells = 640.0 / (8 << i);

        lt_init_constant(m->box[i].last.bias, 1);
        lt_init_constant(m->cls[i].last.bias, log(5 / classes / (cells * cells)));
    }
    for (int i = 0; i < DETECT_BINS; i++)
        m->bin->data[i] = (lt_real)i;
}
