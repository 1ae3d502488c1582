/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/nn/layers.h"

static lt_param *weight(lt_params *set, const char *prefix, const char *name, lt_shape shape)
{
    return lt_params_add(set, prefix, name, LT_WEIGHT, shape);
}

lt_conv_layer lt_conv_layer_new(lt_params *set, const char *prefix, int64_t in, int64_t out, int k,
                                bool bias, const lt_conv_opts *opts)
{
    lt_conv_layer m = { .opts = opts ? *opts : (lt_conv_opts){ 0 } };
    const int groups = m.opts.groups ? m.opts.groups : 1;

    m.weight = weight(set, prefix, "weight", LT_SHAPE(out, in / groups, k, k));
    m.bias = bias ? weight(set, prefix, "bias", LT_SHAPE(out)) : NULL;
    return m;
}

static lt_tensor *use(lt_tensor *x, lt_param *p)
{
    return p ? lt_use(x->graph, p) : NULL;
}

lt_tensor *(lt_conv_layer_forward)(const lt_conv_layer *m, lt_tensor *x)
{
    return lt_conv2d(x, use(x, m->weight), use(x, m->bias), &m->opts);
}

lt_tensor *(lt_conv_layer_on_rows)(const lt_conv_layer *m, lt_tensor *x)
{
    const lt_shape *s = &m->weight->shape;

    return lt_linear(x, lt_reshape(use(x, m->weight), LT_SHAPE(s->dim[0], s->dim[1])), use(x, m->bias));
}

lt_linear_layer lt_linear_layer_new(lt_params *set, const char *prefix, int64_t in, int64_t out, bool bias)
{
    return (lt_linear_layer){
        .weight = weight(set, prefix, "weight", LT_SHAPE(out, in)),
        .bias = bias ? weight(set, prefix, "bias", LT_SHAPE(out)) : NULL,
    };
}

lt_tensor *(lt_linear_layer_forward)(const lt_linear_layer *m, lt_tensor *x)
{
    return lt_linear(x, use(x, m->weight), use(x, m->bias));
}

lt_batch_norm_layer lt_batch_norm_layer_new(lt_params *set, const char *prefix, int64_t channels)
{
    return (lt_batch_norm_layer){
        .weight = weight(set, prefix, "weight", LT_SHAPE(channels)),
        .bias = weight(set, prefix, "bias", LT_SHAPE(channels)),
        .running_mean = lt_params_add(set, prefix, "running_mean", LT_STATISTIC, LT_SHAPE(channels)),
        .running_var = lt_params_add(set, prefix, "running_var", LT_STATISTIC, LT_SHAPE(channels)),
        .eps = 1e-5,
    };
}

lt_tensor *(lt_batch_norm_layer_forward)(const lt_batch_norm_layer *m, lt_tensor *x)
{
    return lt_batch_norm(x, use(x, m->weight), use(x, m->bias), use(x, m->running_mean),
                         use(x, m->running_var), m->eps);
}

lt_layer_norm_layer lt_layer_norm_layer_new(lt_params *set, const char *prefix, int64_t channels)
{
    return (lt_layer_norm_layer){
        .weight = weight(set, prefix, "weight", LT_SHAPE(channels)),
        .bias = weight(set, prefix, "bias", LT_SHAPE(channels)),
        .eps = 1e-5,
    };
}

lt_tensor *(lt_layer_norm_layer_forward)(const lt_layer_norm_layer *m, lt_tensor *x)
{
    return lt_layer_norm(x, use(x, m->weight), use(x, m->bias), m->eps);
}

lt_attention_layer lt_attention_layer_new(lt_params *set, const char *prefix, int64_t channels, int heads)
{
    return (lt_attention_layer){
        .q = lt_linear_layer_new(set, lt_name(set, "%s.q", prefix), channels, channels, true),
        .k = lt_linear_layer_new(set, lt_name(set, "%s.k", prefix), channels, channels, true),
        .v = lt_linear_layer_new(set, lt_name(set, "%s.v", prefix), channels, channels, true),
        .out = lt_linear_layer_new(set, lt_name(set, "%s.out", prefix), channels, channels, true),
        .heads = heads,
    };
}

lt_tensor *(lt_attention_layer_forward)(const lt_attention_layer *m, lt_tensor *x, lt_tensor *context)
{
    lt_tensor *from = context ? context : x;
    lt_tensor *q = lt_linear_layer_forward(&m->q, x);
    lt_tensor *k = lt_linear_layer_forward(&m->k, from);
    lt_tensor *v = lt_linear_layer_forward(&m->v, from);

    return lt_linear_layer_forward(&m->out, lt_attention(q, k, v, m->heads));
}

lt_se_layer lt_se_layer_new(lt_params *set, const char *prefix, int64_t channels, int reduction)
{
    const int64_t narrow = reduction > 0 ? channels / reduction : 0;

    return (lt_se_layer){
        .fc1 = lt_linear_layer_new(set, lt_name(set, "%s.fc1", prefix), channels, narrow, false),
        .fc2 = lt_linear_layer_new(set, lt_name(set, "%s.fc2", prefix), narrow, channels, false),
    };
}

lt_tensor *(lt_se_layer_gate)(const lt_se_layer *m, lt_tensor *means)
{
    lt_tensor *e = lt_relu(lt_linear_layer_forward(&m->fc1, means));

    e = lt_sigmoid(lt_linear_layer_forward(&m->fc2, e));
    return lt_reshape(e, LT_SHAPE(lt_dim(e, 0), lt_dim(e, 1), 1, 1));
}

lt_tensor *(lt_se_layer_forward)(const lt_se_layer *m, lt_tensor *x)
{
    return lt_mul(x, lt_se_layer_gate(m, lt_global_avg_pool(x)));
}

lt_tensor *(lt_map_to_tokens)(lt_tensor *map)
{
    const int64_t B = lt_dim(map, 0), C = lt_dim(map, 1), T = lt_dim(map, 2) * lt_dim(map, 3);

    return lt_permute(lt_reshape(map, LT_SHAPE(B, C, T)), (int[]){ 0, 2, 1 });
}

lt_tensor *(lt_tokens_to_map)(lt_tensor *tokens, int64_t H, int64_t W)
{
    return lt_reshape(lt_permute(tokens, (int[]){ 0, 2, 1 }), LT_SHAPE(lt_dim(tokens, 0), lt_dim(tokens, 2), H, W));
}
