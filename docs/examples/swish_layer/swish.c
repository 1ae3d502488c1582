/* SPDX-License-Identifier: Apache-2.0 */
/* swish: y = x sigmoid(beta x), with one beta that is learned.          [Ramachandran et al. 2017]
 *   x (any shape), beta (1)  ->  y (the shape of x)
 *   with s = sigmoid(beta x):
 *   dx    += dy (s + beta x s (1 - s))
 *   dbeta += the sum of dy x^2 s (1 - s)
 */
#include "libtensor/base/parallel.h"
#include "libtensor/graph/onnx/onnx.h"
#include "libtensor/graph/op.h"
#include "libtensor/graph/plan.h"
#include "libtensor/nn/init.h"
#include "libtensor/nn/layers.h"
#include "libtensor/optim/optim.h"

#include <math.h>
#include <stdio.h>

enum { X, BETA };
enum { CHUNK = 4096 };              /* elements of a task: part of the result, not a tuning knob */

static lt_status infer(lt_call *c)
{
    if (lt_want_shape(c, BETA, "beta", LT_SHAPE(1)))
        return LT_ESHAPE;
    c->out->shape = c->in[X]->shape;
    return LT_OK;
}

/* One number for each task, so that dbeta is summed in the same order on any number of threads. */
static void plan(lt_call *c)
{
    if (c->train)
        c->work_bytes = (size_t)lt_ceil_div(lt_numel(c->in[X]), CHUNK) * sizeof(double);
}

static lt_real sigmoid(lt_real x)
{
    return 1 / (1 + expf(-x));
}

static void forward_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const lt_real *x = c->in[X]->data, beta = *(const lt_real *)c->in[BETA]->data;
    const int64_t end = lt_min_i64(lt_numel(c->out), (task + 1) * CHUNK);
    lt_real *y = c->out->data;

    for (int64_t i = task * CHUNK; i < end; i++)
        y[i] = x[i] * sigmoid(beta * x[i]);
}

static void forward(const lt_call *c)
{
    lt_parallel_for(lt_ceil_div(lt_numel(c->out), CHUNK), forward_task, (void *)c);
}

static void backward_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const lt_real *x = c->in[X]->data, *dy = c->dout, beta = *(const lt_real *)c->in[BETA]->data;
    const int64_t end = lt_min_i64(lt_numel(c->out), (task + 1) * CHUNK);
    lt_real *dx = c->din[X];
    double dbeta = 0;

    for (int64_t i = task * CHUNK; i < end; i++) {
        const lt_real s = sigmoid(beta * x[i]), ds = s * (1 - s);

        if (dx)                     /* NULL when x needs no gradient */
            dx[i] += dy[i] * (s + beta * x[i] * ds);
        dbeta += dy[i] * x[i] * x[i] * ds;
    }
    ((double *)c->work)[task] = dbeta;
}

static void backward(const lt_call *c)
{
    const int64_t n = lt_ceil_div(lt_numel(c->out), CHUNK);
    double dbeta = 0;

    lt_parallel_for(n, backward_task, (void *)c);
    for (int64_t i = 0; i < n; i++)
        dbeta += ((const double *)c->work)[i];
    if (c->din[BETA])
        *c->din[BETA] += (lt_real)dbeta;
}

/* s = sigmoid(beta x), y = x s */
static void onnx(lt_onnx *w, const lt_node *n)
{
    const char *x = lt_onnx_of(w, n->in[X]), *beta = lt_onnx_of(w, n->in[BETA]);
    const char *s = LT_ONNX(w, "Sigmoid", LT_ONNX(w, "Mul", beta, x));

    lt_onnx_is(w, n->outs[0], LT_ONNX(w, "Mul", x, s));
}

static const lt_op swish_op = {
    .name = "swish", .keeps = LT_KEEP_IN(X) | LT_KEEP_IN(BETA), .infer = infer, .plan = plan,
    .forward = forward, .backward = backward, .onnx = onnx,
};

static lt_tensor *swish(lt_tensor *x, lt_tensor *beta)
{
    return lt_apply(&swish_op, NULL, 0, (lt_tensor *[]){ x, beta }, 2);
}
#define swish(...) LT_HERE(swish(__VA_ARGS__))

/* ---- is the gradient right? ------------------------------------------------------------------------ */

/* The largest relative difference between the gradient of an input and central differences, signed, so
 * that a gradient with the wrong sign does not pass. */
static double worst_difference(lt_plan *p, const lt_tensor *input, const lt_tensor *loss)
{
    const double h = 1e-2;
    lt_real *x = lt_plan_data(p, input);
    double worst = 0;

    for (int64_t i = 0; i < lt_numel(input); i++) {
        const lt_real at = x[i];
        double want, got;

        x[i] = at + (lt_real)h;
        lt_run(p);
        want = *(const lt_real *)lt_plan_data(p, loss);
        x[i] = at - (lt_real)h;
        lt_run(p);
        want = (want - *(const lt_real *)lt_plan_data(p, loss)) / (2 * h);
        x[i] = at;
        lt_run(p);
        got = lt_plan_grad(p, input)[i];
        worst = fmax(worst, fabs(got - want) / fmax(fabs(want), 0.1));
    }
    return worst;
}

static bool gradient_is_right(void)
{
    static const lt_real values[6] = { -3, -1, -0.2f, 0.4f, 1, 2.5f };
    lt_graph *g = lt_graph_new();
    lt_tensor *x = lt_want_grad(lt_input(g, "x", LT_F32, 2, (int64_t[]){ 2, 3 }));
    lt_tensor *beta = lt_want_grad(lt_input(g, "beta", LT_F32, 1, (int64_t[]){ 1 }));
    lt_tensor *y = swish(x, beta);
    lt_tensor *loss = lt_sum(lt_mul(y, y));
    lt_plan *p = lt_compile(g, &(lt_compile_opts){ .loss = loss, .train = true });
    double of_x, of_beta;

    for (int i = 0; i < 6; i++)
        ((lt_real *)lt_plan_data(p, x))[i] = values[i];
    *(lt_real *)lt_plan_data(p, beta) = 1.5f;
    of_x = worst_difference(p, x, loss);
    of_beta = worst_difference(p, beta, loss);
    printf("gradient against central differences: x %.1e, beta %.1e\n", of_x, of_beta);
    lt_plan_free(p);
    lt_graph_free(g);
    return of_x < 2e-3 && of_beta < 2e-3;
}

/* ---- a network that learns with it ------------------------------------------------------------------ */

enum { POINTS = 256, HIDDEN = 32, STEPS = 600 };

typedef struct {
    lt_linear_layer in, out;
    lt_param *beta;
} network;

static network network_new(lt_params *set)
{
    const network m = {
        .in = lt_linear_layer_new(set, "in", 2, HIDDEN, true),
        .out = lt_linear_layer_new(set, "out", HIDDEN, 1, true),
        .beta = lt_params_add(set, "swish", "beta", LT_WEIGHT, LT_SHAPE(1)),
    };

    lt_init_default(set, 1);
    lt_init_constant(m.beta, 1);
    return m;
}

static lt_tensor *network_forward(const network *m, lt_tensor *x)
{
    lt_tensor *hidden = swish(lt_linear_layer_forward(&m->in, x), lt_use(x->graph, m->beta));

    return lt_linear_layer_forward(&m->out, hidden);
}

/* A saddle with ripples: what the network shall learn from points in the square. */
static void fill(lt_real *x, lt_real *want)
{
    lt_rng rng = lt_rng_make(2, 0);

    for (int i = 0; i < POINTS; i++) {
        x[2 * i] = (lt_real)lt_rng_range(&rng, -1, 1);
        x[2 * i + 1] = (lt_real)lt_rng_range(&rng, -1, 1);
        want[i] = x[2 * i] * x[2 * i + 1] + sinf(3 * x[2 * i]) / 2;
    }
}

static double train(lt_params *set, const network *m)
{
    lt_graph *g = lt_graph_new();
    lt_tensor *x = lt_input(g, "x", LT_F32, 2, (int64_t[]){ POINTS, 2 });
    lt_tensor *want = lt_input(g, "want", LT_F32, 2, (int64_t[]){ POINTS, 1 });
    lt_tensor *loss = lt_mse_loss(network_forward(m, x), want, NULL);
    lt_plan *p = lt_compile(g, &(lt_compile_opts){ .loss = loss, .train = true });
    lt_optim *adam = lt_optim_new(set, &(lt_optim_opts){ .kind = LT_ADAM });
    double last = 0;

    fill(lt_plan_data(p, x), lt_plan_data(p, want));
    for (int step = 0; step <= STEPS; step++) {
        lt_params_zero_grad(set);
        lt_run(p);
        last = *(const lt_real *)lt_plan_data(p, loss);
        if (step % 100 == 0)
            printf("step %3d  loss %.5f  beta %.3f\n", step, last, (double)m->beta->data[0]);
        lt_optim_step(adam, 0.01, lt_optim_grad_norm(adam));
    }
    lt_optim_free(adam);
    lt_plan_free(p);
    lt_graph_free(g);
    return last;
}

static void show_a_mistake(void)
{
    lt_graph *g = lt_graph_new();
    lt_tensor *x = lt_input(g, "x", LT_F32, 2, (int64_t[]){ 4, 2 });

    swish(x, x);
    if (!lt_compile(g, NULL))
        printf("a mistake is told like this: %s\n", lt_last_error());
    lt_graph_free(g);
}

int main(void)
{
    lt_params *set = lt_params_new();
    const network m = network_new(set);
    const bool good = gradient_is_right() && train(set, &m) < 0.01;

    show_a_mistake();
    lt_params_free(set);
    return good ? 0 : 1;
}
