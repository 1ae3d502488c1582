/* SPDX-License-Identifier: Apache-2.0 */
#include "models/hocat/attention.h"

static void conv1x1(lt_params *set, const char *prefix, int channels, lt_param **weight, lt_param **bias)
{
    *weight = lt_params_add(set, prefix, "weight", LT_WEIGHT, LT_SHAPE(channels, channels, 1, 1));
    *bias = lt_params_add(set, prefix, "bias", LT_WEIGHT, LT_SHAPE(channels));
}

static hocat_block block_new(lt_params *set, const char *prefix, int channels, int mlp_ratio)
{
    hocat_block b;

    conv1x1(set, lt_name(set, "%s.q", prefix), channels, &b.q_weight, &b.q_bias);
    conv1x1(set, lt_name(set, "%s.k", prefix), channels, &b.k_weight, &b.k_bias);
    conv1x1(set, lt_name(set, "%s.v", prefix), channels, &b.v_weight, &b.v_bias);
    b.norm = lt_layer_norm_layer_new(set, lt_name(set, "%s.norm", prefix), channels);
    b.fc1 = lt_linear_layer_new(set, lt_name(set, "%s.mlp.fc1", prefix), channels, mlp_ratio * channels, true);
    b.fc2 = lt_linear_layer_new(set, lt_name(set, "%s.mlp.fc2", prefix), mlp_ratio * channels, channels, true);
    return b;
}

void hocat_attention_new(hocat_attention *m, lt_params *set, const char *prefix, int channels, int depth,
                         int heads, int mlp_ratio)
{
    m->depth = depth;
    m->heads = heads;
    for (int i = 0; i < depth; i++)
        m->block[i] = block_new(set, lt_name(set, "%s.%d", prefix, i), channels, mlp_ratio);
}

/* On tokens a 1x1 convolution is a linear layer. */
static lt_tensor *project(lt_tensor *tokens, lt_param *weight, lt_param *bias)
{
    lt_graph *g = tokens->graph;
    lt_tensor *w = lt_reshape(lt_use(g, weight), LT_SHAPE(weight->shape.dim[0], weight->shape.dim[1]));

    return lt_linear(tokens, w, lt_use(g, bias));
}

/* x, object (B, T, C); the residual of the feed-forward part is y itself, not its norm */
static lt_tensor *block_forward(const hocat_block *b, lt_tensor *x, lt_tensor *object, int heads)
{
    lt_tensor *q = project(x, b->q_weight, b->q_bias);
    lt_tensor *k = project(object, b->k_weight, b->k_bias);
    lt_tensor *v = project(object, b->v_weight, b->v_bias);
    lt_tensor *y = lt_add(lt_attention(q, k, v, heads), x);
    lt_tensor *hidden = lt_linear_layer_forward(&b->fc1, lt_layer_norm_layer_forward(&b->norm, y));

    return lt_add(lt_linear_layer_forward(&b->fc2, lt_gelu(hidden)), y);
}

/* (B, C, R, R) -> (B, R R, C) */
static lt_tensor *to_tokens(lt_tensor *map)
{
    const int64_t B = lt_dim(map, 0), C = lt_dim(map, 1), T = lt_dim(map, 2) * lt_dim(map, 3);

    return lt_permute(lt_reshape(map, LT_SHAPE(B, C, T)), (int[]){ 0, 2, 1 });
}

lt_tensor *hocat_attention_forward(const hocat_attention *m, lt_tensor *hand, lt_tensor *object)
{
    lt_tensor *x = to_tokens(hand), *minor = to_tokens(object);

    for (int i = 0; i < m->depth; i++)
        x = block_forward(&m->block[i], x, minor, m->heads);
    return lt_reshape(lt_permute(x, (int[]){ 0, 2, 1 }), hand->shape);
}
