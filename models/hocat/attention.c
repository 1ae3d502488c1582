/* SPDX-License-Identifier: Apache-2.0 */
#include "models/hocat/attention.h"

static lt_conv_layer conv1x1(lt_params *set, const char *prefix, int channels)
{
    return lt_conv_layer_new(set, prefix, channels, channels, 1, true, NULL);
}

static hocat_block block_new(lt_params *set, const char *prefix, int channels, int mlp_ratio)
{
    hocat_block b;

    b.q = conv1x1(set, lt_name(set, "%s.q", prefix), channels);
    b.k = conv1x1(set, lt_name(set, "%s.k", prefix), channels);
    b.v = conv1x1(set, lt_name(set, "%s.v", prefix), channels);
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

/* x, object (B, T, C); the residual of the feed-forward part is y itself, not its norm */
static lt_tensor *block_forward(const hocat_block *b, lt_tensor *x, lt_tensor *object, int heads)
{
    lt_tensor *q = lt_conv_layer_on_rows(&b->q, x);
    lt_tensor *k = lt_conv_layer_on_rows(&b->k, object);
    lt_tensor *v = lt_conv_layer_on_rows(&b->v, object);
    lt_tensor *y = lt_add(lt_attention(q, k, v, heads), x);
    lt_tensor *hidden = lt_linear_layer_forward(&b->fc1, lt_layer_norm_layer_forward(&b->norm, y));

    return lt_add(lt_linear_layer_forward(&b->fc2, lt_gelu(hidden)), y);
}

lt_tensor *hocat_attention_forward(const hocat_attention *m, lt_tensor *hand, lt_tensor *object)
{
    lt_tensor *x = lt_map_to_tokens(hand), *minor = lt_map_to_tokens(object);

    for (int i = 0; i < m->depth; i++)
        x = block_forward(&m->block[i], x, minor, m->heads);
    return lt_tokens_to_map(x, lt_dim(hand, 2), lt_dim(hand, 3));
}

lt_tensor *hocat_fused_forward(const hocat_attention *m, lt_tensor *hand, lt_tensor *object)
{
    lt_tensor *both = lt_map_to_tokens(lt_concat((lt_tensor *[]){ hand, object }, 2, 1));
    lt_tensor *y = lt_tokens_to_map(block_forward(&m->block[0], both, both, m->heads), lt_dim(hand, 2),
                                    lt_dim(hand, 3));

    return lt_slice(y, 1, 0, lt_dim(hand, 1));
}
