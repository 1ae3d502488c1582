/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An MLP that each of many sets (a subject's hand, an object) has its own of. Which one is read is data, and a step
 * moves that one alone: each layer is a parameter of a row a set (libtensor/graph/rows.h).
 */
#ifndef MODELS_HOGS_SET_MLP_H
#define MODELS_HOGS_SET_MLP_H

#include "libtensor/graph/rows.h"
#include "libtensor/ops/ops.h"

enum { SET_MLP_LAYERS = 5 };

typedef struct {
    lt_param *weight[SET_MLP_LAYERS], *bias[SET_MLP_LAYERS];    /* (sets, O, K), (sets, O) */
    int layers;
    double slope;                   /* of the leaky relu between layers */
} set_mlp;

/* set_mlp_new - sizes: how wide the input is, then the result of each layer. Parameters PREFIX.0.weight, .0.bias .. */
void set_mlp_new(set_mlp *m, lt_params *set, const char *prefix, int sets, const int *sizes, int layers);

/* set_mlp_init - uniform in +-1 / sqrt(fan in), biases too */
void set_mlp_init(const set_mlp *m, uint64_t seed);

/* set_mlp_touch - the set's MLP takes part in the step to come: lt_param_touch */
lt_status set_mlp_touch(const set_mlp *m, int64_t which);

/* One layer's weight (O, K) and bias (O) of the set whose number is in which: (1), LT_I32 */
typedef struct {
    lt_tensor *weight, *bias;
} set_layer;

set_layer set_mlp_layer(const set_mlp *m, int layer, lt_tensor *which);

/* set_mlp_rest - what comes behind a layer's result x (N, C): its leaky relu and the layers after it */
lt_tensor *set_mlp_rest(const set_mlp *m, int layer, lt_tensor *x, lt_tensor *which);

/* set_mlp_forward - (N, K) -> (N, O) */
lt_tensor *set_mlp_forward(const set_mlp *m, lt_tensor *x, lt_tensor *which);

#endif
