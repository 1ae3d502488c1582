/* SPDX-License-Identifier: Apache-2.0 */
#include "models/hogs/set_mlp.h"

#include "libtensor/nn/init.h"

#include <assert.h>
#include <math.h>

static const double SLOPE = 0.01;

void set_mlp_new(set_mlp *m, lt_params *set, const char *prefix, int sets, const int *sizes, int layers)
{
    assert(layers <= SET_MLP_LAYERS);
    *m = (set_mlp){ .layers = layers, .slope = SLOPE };
    for (int i = 0; i < layers; i++) {
        const char *name = lt_name(set, "%s.%d", prefix, i);

        m->weight[i] = lt_params_add_rows(set, name, "weight", LT_SHAPE(sets, sizes[i + 1], sizes[i]));
        m->bias[i] = lt_params_add_rows(set, name, "bias", LT_SHAPE(sets, sizes[i + 1]));
    }
}

void set_mlp_init(const set_mlp *m, uint64_t seed)
{
    for (int i = 0; i < m->layers; i++) {
        const double bound = 1 / sqrt((double)m->weight[i]->shape.dim[2]);

        lt_init_uniform(m->weight[i], seed, bound);
        lt_init_uniform(m->bias[i], seed, bound);
    }
}

lt_status set_mlp_touch(const set_mlp *m, int64_t which)
{
    lt_status st = LT_OK;

    for (int i = 0; i < m->layers && !st; i++) {
        st = lt_param_touch(m->weight[i], which, 1);
        if (!st)
            st = lt_param_touch(m->bias[i], which, 1);
    }
    return st;
}

set_layer set_mlp_layer(const set_mlp *m, int layer, lt_tensor *which)
{
    const lt_shape *s = &m->weight[layer]->shape;
    lt_graph *g = which->graph;

    return (set_layer){
        .weight = lt_reshape(lt_rows(lt_use(g, m->weight[layer]), which, 1), LT_SHAPE(s->dim[1], s->dim[2])),
        .bias = lt_reshape(lt_rows(lt_use(g, m->bias[layer]), which, 1), LT_SHAPE(s->dim[1])),
    };
}

lt_tensor *set_mlp_rest(const set_mlp *m, int layer, lt_tensor *x, lt_tensor *which)
{
    for (int i = layer + 1; i < m->layers; i++) {
        const set_layer l = set_mlp_layer(m, i, which);

        x = lt_linear(lt_leaky_relu(x, m->slope), l.weight, l.bias);
    }
    return x;
}

lt_tensor *set_mlp_forward(const set_mlp *m, lt_tensor *x, lt_tensor *which)
{
    const set_layer first = set_mlp_layer(m, 0, which);

    return set_mlp_rest(m, 0, lt_linear(x, first.weight, first.bias), which);
}
