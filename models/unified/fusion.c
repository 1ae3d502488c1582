/* SPDX-License-Identifier: Apache-2.0 */
#include "models/unified/fusion.h"

#include "libtensor/nn/init.h"

/* ---- colour and depth --------------------------------------------------------------------------------- */

void adaptive_attention_new(adaptive_attention *m, lt_params *set, const char *prefix, int channels, bool sigmoid)
{
    const lt_conv_opts pad = { .pad = 1 };

    m->channel = lt_linear_layer_new(set, lt_name(set, "%s.channel", prefix), channels, channels, false);
    m->spatial = lt_conv_layer_new(set, lt_name(set, "%s.spatial", prefix), channels, 1, 3, true, &pad);
    m->sigmoid = sigmoid;
}

void adaptive_attention_init(const adaptive_attention *m, uint64_t seed)
{
    lt_init_xavier(m->channel.weight, seed, 1);
    lt_init_xavier(m->spatial.weight, seed, 0.1);
    lt_init_constant(m->spatial.bias, 1);
}

lt_tensor *adaptive_attention_forward(const adaptive_attention *m, lt_tensor *features)
{
    lt_tensor *channel = lt_sigmoid(lt_linear_layer_forward(&m->channel, lt_global_avg_pool(features)));
    lt_tensor *spatial = lt_conv_layer_forward(&m->spatial, lt_relu(features));         /* (B, 1, H, W) */

    channel = lt_reshape(channel, LT_SHAPE(lt_dim(channel, 0), lt_dim(channel, 1), 1, 1));
    return lt_mul(lt_mul(features, channel), m->sigmoid ? lt_sigmoid(spatial) : spatial);
}

/* ---- hand and object ---------------------------------------------------------------------------------- */

static cross_side side_new(lt_params *set, const char *prefix, int channels)
{
    return (cross_side){
        .q = lt_linear_layer_new(set, lt_name(set, "%s.q", prefix), channels, channels, true),
        .k = lt_linear_layer_new(set, lt_name(set, "%s.k", prefix), channels, channels, true),
        .v = lt_linear_layer_new(set, lt_name(set, "%s.v", prefix), channels, channels, true),
    };
}

void cross_attention_new(cross_attention *m, lt_params *set, const char *prefix, int channels)
{
    m->hand = side_new(set, lt_name(set, "%s.hand", prefix), channels);
    m->object = side_new(set, lt_name(set, "%s.object", prefix), channels);
}

/* x + softmax(Q_x K_other^T / sqrt(C)) V_other */
static lt_tensor *see(const cross_side *own, lt_tensor *x, const cross_side *its, lt_tensor *other)
{
    lt_tensor *q = lt_linear_layer_forward(&own->q, x), *k = lt_linear_layer_forward(&its->k, other);

    return lt_add(lt_attention(q, k, lt_linear_layer_forward(&its->v, other), 1), x);
}

void cross_attention_forward(const cross_attention *m, lt_tensor **hand, lt_tensor **object)
{
    lt_tensor *h = *hand, *o = *object;

    *hand = see(&m->hand, h, &m->object, o);
    *object = see(&m->object, o, &m->hand, h);
}
