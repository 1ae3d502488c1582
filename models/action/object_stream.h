/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stream 2: a hand with an object over time. Two graph layers make a token of each frame, a transformer one of all.
 *
 * Source: Vaswani et al. 2017, "Attention is all you need", encoder, with norms first; the class token is Devlin et al.
 * 2019's, "BERT".
 */
#ifndef MODELS_ACTION_OBJECT_STREAM_H
#define MODELS_ACTION_OBJECT_STREAM_H

#include "libtensor/nn/layers.h"

enum { OBJECT_STREAM_TOKEN = 128, OBJECT_STREAM_LAYERS = 3 };

typedef struct {
    lt_linear_layer linear;         /* of each node's channels */
    lt_param *mask;
    lt_batch_norm_layer bn;
} object_graph;

typedef struct {
    lt_layer_norm_layer norm1, norm2;
    lt_attention_layer attention;
    lt_linear_layer fc1, fc2;
} object_encoder;

typedef struct {
    lt_batch_norm_layer bn;         /* of each node's coordinates */
    object_graph graph1, graph2;
    lt_linear_layer token;
    lt_param *class_token, *position;
    object_encoder layer[OBJECT_STREAM_LAYERS];
    lt_layer_norm_layer norm;
    const lt_adjacency *graph;
    double dropout;
} object_stream;

void object_stream_new(object_stream *m, lt_params *set, const char *prefix, int frames, double dropout);
void object_stream_init(const object_stream *m, uint64_t seed);

/* object_stream_forward - x (B, 3, T, 30) and which frames are valid, (B, T) of 1 and 0, to (B, 128). Frames that are
 * not valid are not looked at; where none is, the result has no meaning. */
lt_tensor *object_stream_forward(const object_stream *m, lt_tensor *x, lt_tensor *valid);

#endif
