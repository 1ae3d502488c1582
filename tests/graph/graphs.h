/* SPDX-License-Identifier: Apache-2.0 */
/* A graph and parameters for each test, and what its plans hold. */
#ifndef TESTS_GRAPH_GRAPHS_H
#define TESTS_GRAPH_GRAPHS_H

#include "libtensor/graph/plan.h"
#include "libtensor/nn/init.h"
#include "libtensor/nn/layers.h"
#include "tests/suite.h"

#include <string.h>

static lt_graph *g;
static lt_params *set;

static inline void start(void)
{
    g = lt_graph_new();
    set = lt_params_new();
}

static inline void stop(void)
{
    lt_graph_free(g);
    lt_params_free(set);
}

static inline lt_tensor *input(const char *name, lt_shape s)
{
    return lt_input(g, name, LT_F32, s.rank, s.dim);
}

static inline void fill(const lt_plan *p, const lt_tensor *t, uint64_t stream)
{
    lt_rng r = lt_rng_make(5, stream);
    lt_real *x = lt_plan_data(p, t);

    for (int64_t i = 0; i < lt_numel(t); i++)
        x[i] = (lt_real)lt_rng_range(&r, -1, 1);
}

static inline lt_real at(const lt_plan *p, const lt_tensor *t, int64_t i)
{
    return ((const lt_real *)lt_plan_data(p, t))[i];
}

static inline int steps_of(const lt_plan *p, const char *op, const char *phase)
{
    int n = 0;

    for (int i = 0; i < lt_plan_steps(p); i++) {
        const lt_step_info s = lt_plan_step(p, i);

        n += strcmp(s.op, op) == 0 && strcmp(s.phase, phase) == 0;
    }
    return n;
}

/* ---- layers of values that do not matter, and what an inference plan makes of them ---- */

static inline lt_tensor *weight(const char *layer, const char *name, lt_shape shape)
{
    lt_param *p = lt_params_add(set, layer, name, LT_WEIGHT, shape);
    lt_rng r = lt_rng_make(3, (uint64_t)lt_param_numel(p));

    for (int64_t i = 0; i < lt_param_numel(p); i++)
        p->data[i] = (lt_real)lt_rng_range(&r, -0.2, 0.2);
    return lt_use(g, p);
}

static inline lt_tensor *conv(const char *layer, lt_tensor *x, int64_t outputs, int k, int stride)
{
    lt_tensor *w = weight(layer, "weight", LT_SHAPE(outputs, lt_dim(x, 1), k, k));

    return lt_conv2d(x, w, weight(layer, "bias", LT_SHAPE(outputs)),
                     &(lt_conv_opts){ .pad = k / 2, .stride = stride });
}

static inline lt_tensor *linear(const char *layer, lt_tensor *x, int64_t outputs)
{
    lt_tensor *w = weight(layer, "weight", LT_SHAPE(outputs, lt_dim(x, -1)));

    return lt_linear(x, w, weight(layer, "bias", LT_SHAPE(outputs)));
}

static inline lt_plan *compile_filled(const lt_tensor *x, const lt_compile_opts *opts)
{
    lt_plan *p = lt_compile(g, opts);

    ck_assert_msg(p != NULL, "%s", lt_last_error());
    fill(p, x, 0);
    return p;
}

static inline void compute(const lt_tensor *x, const lt_tensor *y, const lt_compile_opts *opts, lt_real *out)
{
    lt_plan *p = compile_filled(x, opts);

    lt_run(p);
    memcpy(out, lt_plan_data(p, y), (size_t)lt_numel(y) * sizeof(*out));
    lt_plan_free(p);
}

/* ---- gradients ---- */

/* The gradients of a plan's run, one behind the other; those of parameters are cleared for the next plan. */
static inline int64_t run_for_gradients(lt_plan *p, const lt_tensor *x, lt_real *out)
{
    int64_t n = lt_numel(x);

    lt_run(p);
    memcpy(out, lt_plan_grad(p, x), (size_t)n * sizeof(*out));
    for (const lt_param *param = lt_params_first(set); param; param = param->next)
        for (int64_t j = 0; param->grad && j < lt_param_numel(param); j++)
            out[n++] = param->grad[j];
    lt_params_zero_grad(set);
    return n;
}

#endif
