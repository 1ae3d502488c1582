/* SPDX-License-Identifier: Apache-2.0 */
#include "models/action/stgcn.h"

#include "libtensor/base/rng.h"
#include "libtensor/nn/init.h"
#include "models/action/skeleton.h"

/* Channels of each unit; where they double, moments are halved. */
static const struct { double dropout; int channels[STGCN_MOST_UNITS + 1]; } sizes[] = {
    [STGCN_SMALL] = { 0.3, { 32, 32, 64, 64, 128, 128 } },
    [STGCN_FULL] = { 0.5, { 64, 64, 64, 64, 128, 128, 128, 256, 256, 256 } },
};

static lt_conv_layer temporal_new(lt_params *set, const char *prefix, int channels, int kernel, int stride)
{
    return (lt_conv_layer){
        .weight = lt_params_add(set, prefix, "weight", LT_WEIGHT, LT_SHAPE(channels, channels, kernel, 1)),
        .bias = lt_params_add(set, prefix, "bias", LT_WEIGHT, LT_SHAPE(channels)),
        .opts = { .stride = stride, .pad = kernel / 2, .only_h = true },
    };
}

static stgcn_unit unit_new(lt_params *set, const char *prefix, int in, int out, int kernel, double dropout)
{
    const bool first = in == 3;
    stgcn_unit u = { .in = in, .out = out, .stride = in == out || first ? 1 : 2, .first = first,
                     .dropout = first ? 0 : dropout };

    u.spatial = lt_conv_layer_new(set, lt_name(set, "%s.spatial", prefix), in, SKELETON_SUBSETS * out, 1, true, NULL);
    u.mask = lt_params_add(set, prefix, "mask", LT_WEIGHT, LT_SHAPE(SKELETON_SUBSETS, SKELETON_BODY, SKELETON_BODY));
    u.spatial_bn = lt_batch_norm_layer_new(set, lt_name(set, "%s.spatial.bn", prefix), out);
    u.temporal = temporal_new(set, lt_name(set, "%s.temporal", prefix), out, kernel, u.stride);
    u.temporal_bn = lt_batch_norm_layer_new(set, lt_name(set, "%s.temporal.bn", prefix), out);
    if (first || in == out)
        return u;
    u.residual = lt_conv_layer_new(set, lt_name(set, "%s.residual", prefix), in, out, 1, true,
                                   &(lt_conv_opts){ .stride = u.stride, .only_h = true });
    u.residual_bn = lt_batch_norm_layer_new(set, lt_name(set, "%s.residual.bn", prefix), out);
    return u;
}

void stgcn_new(stgcn *m, lt_params *set, const char *prefix, stgcn_size size, int kernel, double dropout)
{
    const int *channels = sizes[size].channels;

    *m = (stgcn){ .kernel = kernel, .graph = skeleton_body(lt_params_arena(set)) };
    m->bn = lt_batch_norm_layer_new(set, lt_name(set, "%s.bn", prefix), 3 * SKELETON_BODY);
    for (int k = 0; channels[k]; k++)
        m->unit[m->n++] = unit_new(set, lt_name(set, "%s.units.%d", prefix, k), k ? channels[k - 1] : 3, channels[k],
                                   kernel, dropout * sizes[size].dropout);
    m->features = channels[m->n - 1];
}

static void init_conv(const lt_conv_layer *c, uint64_t seed)
{
    lt_init_normal(c->weight, seed, 0.02);
    lt_init_constant(c->bias, 0);
}

/* Around 1 */
static void init_norm(const lt_batch_norm_layer *bn, uint64_t seed)
{
    lt_init_normal(bn->weight, seed, 0.02);
    for (int64_t i = 0; i < bn->weight->shape.dim[0]; i++)
        bn->weight->data[i] += 1;
}

void stgcn_init(const stgcn *m, uint64_t seed)
{
    init_norm(&m->bn, seed);
    for (int k = 0; k < m->n; k++) {
        const stgcn_unit *u = &m->unit[k];

        lt_init_constant(u->mask, 1);
        init_conv(&u->spatial, seed);
        init_norm(&u->spatial_bn, seed);
        init_conv(&u->temporal, seed);
        init_norm(&u->temporal_bn, seed);
        if (!u->residual.weight)
            continue;
        init_conv(&u->residual, seed);
        init_norm(&u->residual_bn, seed);
    }
}

/* (B, 3, T, V) with a joint's coordinate in the place of a channel, and back */
lt_tensor *stgcn_normalise(const stgcn *m, lt_tensor *x)
{
    const int64_t B = lt_dim(x, 0), C = lt_dim(x, 1), T = lt_dim(x, 2), V = lt_dim(x, 3);

    x = lt_reshape(lt_permute(x, (int[]){ 0, 1, 3, 2 }), LT_SHAPE(B, C * V, T));
    x = lt_reshape(lt_batch_norm_layer_forward(&m->bn, x), LT_SHAPE(B, C, V, T));
    return lt_permute(x, (int[]){ 0, 1, 3, 2 });
}

lt_tensor *stgcn_mix(const stgcn *m, const stgcn_unit *u, lt_tensor *x)
{
    x = lt_conv_layer_forward(&u->spatial, x);                  /* (B, 3 out, T, V) */
    x = lt_aggregate(x, lt_use(x->graph, u->mask), m->graph);   /* (B, out, T, V) */
    return lt_relu(lt_batch_norm_layer_forward(&u->spatial_bn, x));
}

lt_tensor *stgcn_unit_end(const stgcn_unit *u, lt_tensor *y, lt_tensor *x, int pad)
{
    lt_conv_layer temporal = u->temporal, residual = u->residual;

    temporal.opts.pad = pad;
    temporal.opts.stride = residual.opts.stride = pad ? u->stride : 1;
    y = lt_batch_norm_layer_forward(&u->temporal_bn, lt_conv_layer_forward(&temporal, y));
    if (u->dropout > 0)
        y = lt_dropout(y, u->dropout);
    if (u->residual.weight)
        x = lt_batch_norm_layer_forward(&u->residual_bn, lt_conv_layer_forward(&residual, x));
    return lt_relu(u->first ? y : lt_add(y, x));
}

lt_tensor *stgcn_forward(const stgcn *m, lt_tensor *x)
{
    x = stgcn_normalise(m, x);
    for (int k = 0; k < m->n; k++)
        x = stgcn_unit_end(&m->unit[k], stgcn_mix(m, &m->unit[k], x), x, m->kernel / 2);
    return lt_global_avg_pool(x);
}
