/* SPDX-License-Identifier: Apache-2.0 */
#include "models/action/object_stream.h"

#include "libtensor/nn/init.h"
#include "models/action/skeleton.h"

#include <math.h>

enum { CHANNELS = 64, HEADS = 4, HIDDEN = 256, V = SKELETON_HAND_OBJECT, D = OBJECT_STREAM_TOKEN };

static const double HIDDEN_FRAME = 64;          /* taken off the logits of what is not looked at: a share of 1e-28 */

static object_graph graph_new(lt_params *set, const char *prefix, int in)
{
    return (object_graph){
        .linear = lt_linear_layer_new(set, prefix, in, CHANNELS, true),
        .mask = lt_params_add(set, prefix, "mask", LT_WEIGHT, LT_SHAPE(1, V, V)),
        .bn = lt_batch_norm_layer_new(set, lt_name(set, "%s.bn", prefix), CHANNELS),
    };
}

static object_encoder encoder_new(lt_params *set, const char *prefix)
{
    object_encoder e;

    e.norm1 = lt_layer_norm_layer_new(set, lt_name(set, "%s.norm1", prefix), D);
    e.attention = lt_attention_layer_new(set, lt_name(set, "%s.attn", prefix), D, HEADS);
    e.norm2 = lt_layer_norm_layer_new(set, lt_name(set, "%s.norm2", prefix), D);
    e.fc1 = lt_linear_layer_new(set, lt_name(set, "%s.fc1", prefix), D, HIDDEN, true);
    e.fc2 = lt_linear_layer_new(set, lt_name(set, "%s.fc2", prefix), HIDDEN, D, true);
    return e;
}

void object_stream_new(object_stream *m, lt_params *set, const char *prefix, int frames, double dropout)
{
    *m = (object_stream){ .graph = skeleton_hand_object(lt_params_arena(set)), .dropout = dropout };
    m->bn = lt_batch_norm_layer_new(set, lt_name(set, "%s.bn", prefix), 3 * V);
    m->graph1 = graph_new(set, lt_name(set, "%s.graph1", prefix), 3);
    m->graph2 = graph_new(set, lt_name(set, "%s.graph2", prefix), CHANNELS);
    m->token = lt_linear_layer_new(set, lt_name(set, "%s.token", prefix), CHANNELS * V, D, true);
    m->class_token = lt_params_add(set, prefix, "class_token", LT_WEIGHT, LT_SHAPE(D));
    m->position = lt_params_add(set, prefix, "position", LT_WEIGHT, LT_SHAPE(1 + frames, D));
    for (int i = 0; i < OBJECT_STREAM_LAYERS; i++)
        m->layer[i] = encoder_new(set, lt_name(set, "%s.layers.%d", prefix, i));
    m->norm = lt_layer_norm_layer_new(set, lt_name(set, "%s.norm", prefix), D);
}

void object_stream_init(const object_stream *m, uint64_t seed)
{
    lt_init_constant(m->graph1.mask, 1);
    lt_init_constant(m->graph2.mask, 1);
    lt_init_normal(m->class_token, seed, 0.02);
    lt_init_normal(m->position, seed, 0.02);
}

/* x (B, C, T, V): a linear layer of each node as a convolution of 1 x 1, then the graph */
static lt_tensor *graph_forward(const object_graph *m, const lt_adjacency *of, lt_tensor *x)
{
    lt_graph *g = x->graph;
    lt_tensor *weight = lt_reshape(lt_use(g, m->linear.weight), LT_SHAPE(CHANNELS, lt_dim(x, 1), 1, 1));

    x = lt_conv2d(x, weight, lt_use(g, m->linear.bias), NULL);
    x = lt_aggregate(x, lt_use(g, m->mask), of);
    return lt_relu(lt_batch_norm_layer_forward(&m->bn, x));
}

/* A token for each frame: (B, T, D) */
static lt_tensor *tokens_of(const object_stream *m, lt_tensor *x)
{
    const int64_t B = lt_dim(x, 0), T = lt_dim(x, 2);

    x = lt_reshape(lt_permute(x, (int[]){ 0, 1, 3, 2 }), LT_SHAPE(B, 3 * V, T));
    x = lt_reshape(lt_batch_norm_layer_forward(&m->bn, x), LT_SHAPE(B, 3, V, T));
    x = lt_permute(x, (int[]){ 0, 1, 3, 2 });
    x = graph_forward(&m->graph2, m->graph, graph_forward(&m->graph1, m->graph, x));
    x = lt_reshape(lt_permute(x, (int[]){ 0, 2, 1, 3 }), LT_SHAPE(B, T, CHANNELS * V));
    return lt_linear_layer_forward(&m->token, x);
}

/* What is added to logits of keys: (B, 1, 1, 1 + T), 0 for the class token */
static lt_tensor *penalty_of(lt_tensor *valid)
{
    const int64_t B = lt_dim(valid, 0), T = lt_dim(valid, 1);
    const lt_real one = 1;
    lt_tensor *ones = lt_constant(valid->graph, LT_F32, LT_SHAPE(1), &one);
    lt_tensor *frames = lt_scale(lt_sub(valid, ones), HIDDEN_FRAME);

    frames = lt_concat((lt_tensor *[]){ lt_scale(lt_slice(frames, 1, 0, 1), 0), frames }, 2, 1);
    return lt_reshape(frames, LT_SHAPE(B, 1, 1, 1 + T));
}

/* (B, S, D) as a matrix for each head, (B HEADS, S, D / HEADS), or turned */
static lt_tensor *heads_of(lt_tensor *x, bool turned)
{
    const int64_t B = lt_dim(x, 0), S = lt_dim(x, 1), d = D / HEADS;

    x = lt_reshape(x, LT_SHAPE(B, S, HEADS, d));
    if (turned)
        return lt_reshape(lt_permute(x, (int[]){ 0, 2, 3, 1 }), LT_SHAPE(B * HEADS, d, S));
    return lt_reshape(lt_permute(x, (int[]){ 0, 2, 1, 3 }), LT_SHAPE(B * HEADS, S, d));
}

/* Few tokens, so that scores may be there whole, for the penalty to be added */
static lt_tensor *attend(const lt_attention_layer *a, lt_tensor *x, lt_tensor *penalty)
{
    const int64_t B = lt_dim(x, 0), S = lt_dim(x, 1), d = D / HEADS;
    lt_tensor *q = heads_of(lt_linear_layer_forward(&a->q, x), false);
    lt_tensor *k = heads_of(lt_linear_layer_forward(&a->k, x), true);
    lt_tensor *v = heads_of(lt_linear_layer_forward(&a->v, x), false);
    lt_tensor *scores = lt_reshape(lt_scale(lt_matmul(q, k), 1 / sqrt(d)), LT_SHAPE(B, HEADS, S, S));

    scores = lt_reshape(lt_softmax(lt_add(scores, penalty)), LT_SHAPE(B * HEADS, S, S));
    x = lt_reshape(lt_matmul(scores, v), LT_SHAPE(B, HEADS, S, d));
    x = lt_reshape(lt_permute(x, (int[]){ 0, 2, 1, 3 }), LT_SHAPE(B, S, D));
    return lt_linear_layer_forward(&a->out, x);
}

static lt_tensor *encode(const object_stream *m, const object_encoder *e, lt_tensor *x, lt_tensor *penalty)
{
    lt_tensor *y = attend(&e->attention, lt_layer_norm_layer_forward(&e->norm1, x), penalty);

    x = lt_add(x, lt_dropout(y, m->dropout));
    y = lt_relu(lt_linear_layer_forward(&e->fc1, lt_layer_norm_layer_forward(&e->norm2, x)));
    y = lt_linear_layer_forward(&e->fc2, lt_dropout(y, m->dropout));
    return lt_add(x, lt_dropout(y, m->dropout));
}

lt_tensor *object_stream_forward(const object_stream *m, lt_tensor *x, lt_tensor *valid)
{
    lt_graph *g = x->graph;
    const int64_t B = lt_dim(x, 0);
    lt_tensor *zero = lt_reshape(lt_scale(lt_sample_index(x), 0), LT_SHAPE(B, 1, 1));
    lt_tensor *first = lt_add(zero, lt_use(g, m->class_token));            /* one a sample: (B, 1, D) */
    lt_tensor *penalty = penalty_of(valid);

    x = lt_add(lt_concat((lt_tensor *[]){ first, tokens_of(m, x) }, 2, 1), lt_use(g, m->position));
    for (int i = 0; i < OBJECT_STREAM_LAYERS; i++)
        x = encode(m, &m->layer[i], x, penalty);
    return lt_layer_norm_layer_forward(&m->norm, lt_reshape(lt_slice(x, 1, 0, 1), LT_SHAPE(B, D)));
}
