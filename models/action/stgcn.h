/* SPDX-License-Identifier: Apache-2.0 */
/*
 * ST-GCN, stream 1: joints of a body over time to one feature, by units that mix neighbours in the graph, then moments.
 *
 * Source: Yan et al. 2018, "Spatial temporal graph convolutional networks for skeleton-based action recognition";
 * sizes of "full" as in yysijie/st-gcn.
 */
#ifndef MODELS_ACTION_STGCN_H
#define MODELS_ACTION_STGCN_H

#include "libtensor/nn/layers.h"

enum { STGCN_MOST_UNITS = 10 };

typedef enum { STGCN_SMALL, STGCN_FULL } stgcn_size;

/* y = relu(bn(aggregate(conv(x)))); relu(dropout(bn(conv over time(y))) + residual(x)) */
typedef struct {
    int in, out, stride;
    lt_conv_layer spatial, temporal, residual;  /* the last where sizes change: 1 x 1 */
    lt_param *mask;
    lt_batch_norm_layer spatial_bn, temporal_bn, residual_bn;
    double dropout;
    bool first;                                 /* no residual */
} stgcn_unit;

typedef struct {
    int n, kernel, features;
    stgcn_unit unit[STGCN_MOST_UNITS];
    lt_batch_norm_layer bn;                     /* of each joint's coordinates */
    const lt_adjacency *graph;
} stgcn;

/* stgcn_new - kernel: moments that a unit looks at, odd; dropout: a factor on the size's. Without memory the set has
 * LT_ENOMEM. */
void stgcn_new(stgcn *m, lt_params *set, const char *prefix, stgcn_size size, int kernel, double dropout);
void stgcn_init(const stgcn *m, uint64_t seed);

/* stgcn_forward - (B, 3, T, 65) to (B, features): the mean over joints and moments of the last unit's result */
lt_tensor *stgcn_forward(const stgcn *m, lt_tensor *x);

/* Its parts, of which a stream takes one frame at a time (stream.h): stgcn_normalise - the joints' norm;
 * stgcn_mix - neighbours: (B, in, T, 65) to (B, out, T, 65); stgcn_unit_end - moments of that, with so many zeros
 * before and behind, and the residual of x, which is as long as the result where pad is 0 */
lt_tensor *stgcn_normalise(const stgcn *m, lt_tensor *x);
lt_tensor *stgcn_mix(const stgcn *m, const stgcn_unit *u, lt_tensor *x);
lt_tensor *stgcn_unit_end(const stgcn_unit *u, lt_tensor *y, lt_tensor *x, int pad);

#endif
