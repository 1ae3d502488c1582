/* SPDX-License-Identifier: Apache-2.0 */
/*
 * checkasm --bench: how fast the kernels are, beside the machine's multiply-add peak read just before.
 * The median of the runs, and the fastest in brackets.
 */
#include "tests/kernels/checkasm.h"

#include "libtensor/base/clock.h"
#include "libtensor/base/order.h"
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv/conv.h"
#include "libtensor/kernels/gemm/gemm.h"

#include <string.h>

enum { MOST_RUNS = 200 };

typedef void (*run_fn)(void *ctx);
typedef struct { double median, best; } timing;     /* seconds */

static timing measure(run_fn fn, void *ctx)
{
    double run[MOST_RUNS];
    const double end = lt_clock() + 0.25;
    int n = 0;

    fn(ctx);
    do {
        const double start = lt_clock();

        fn(ctx);
        run[n++] = lt_clock() - start;
    } while (n < MOST_RUNS && (n < 3 || lt_clock() < end));
    qsort(run, (size_t)n, sizeof(run[0]), lt_ascending);
    return (timing){ run[n / 2], run[0] };
}

static void report(const char *what, double flop, run_fn fn, void *ctx)
{
    const double peak = lt_fma_peak_gflops(20);
    const timing t = measure(fn, ctx);

    printf("  %-46s %8.3f ms (%8.3f) %7.1f GFLOP/s (%6.1f), peak %.0f\n", what, 1e3 * t.median,
           1e3 * t.best, 1e-9 * flop / t.median, 1e-9 * flop / t.best, peak);
}

/* ---- products --------------------------------------------------------------------------------------- */

typedef struct { lt_trans ta, tb; int64_t m, n, k; const float *a, *b; float *c; } product;

static void run_gemm(void *ctx)
{
    const product *p = ctx;

    lt_gemm(p->ta, p->tb, p->m, p->n, p->k, p->a, p->ta ? p->m : p->k, p->b, p->tb ? p->k : p->n,
            false, p->c, p->n, NULL);
}

static void bench_gemm(lt_trans ta, lt_trans tb, int64_t m, int64_t n, int64_t k)
{
    const double flop = 2.0 * (double)m * (double)n * (double)k;
    float *a = random_array((size_t)(m * k), 1), *b = random_array((size_t)(k * n), 2);
    product p = { ta, tb, m, n, k, a, b, zero_array((size_t)(m * n)) };
    char name[80];

    snprintf(name, sizeof(name), "gemm %d x %d x %d%s%s", (int)m, (int)n, (int)k, ta ? ", A^T" : "",
             tb ? ", B^T" : "");
    report(name, flop, run_gemm, &p);
    free_array(a), free_array(b), free_array(p.c);
}

/* ---- convolutions ------------------------------------------------------------------------------------- */

typedef struct { lt_conv2d_params p; float *x, *w, *packed, *y; void *work; } conv;

static void run_forward(void *ctx)
{
    const conv *c = ctx;
    const lt_act relu = { LT_ACT_RELU, 0 };

    lt_conv2d_forward(&c->p, c->x, c->packed, &(lt_conv2d_around){ .bias = c->w, .act = relu }, c->y, c->work);
}

static void run_data(void *ctx)
{
    const conv *c = ctx;

    lt_conv2d_data_pack(&c->p, c->w, c->packed);
    lt_conv2d_backward_data(&c->p, c->y, c->packed, true, c->x, c->work);
}

static void run_weights(void *ctx)
{
    const conv *c = ctx;

    lt_conv2d_backward_weights(&c->p, c->x, c->y, true, c->w, c->work);
}

static void bench_conv(int n, int c, int size, int o, int k, int stride, int groups)
{
    conv v = { .p = { n, c, size, size, o, k, k, stride, stride, k / 2, k / 2, 1, 1, groups } };
    const int64_t out = lt_conv2d_out_h(&v.p) * lt_conv2d_out_w(&v.p);
    const double flop = 2.0 * n * o * (double)out * c / groups * k * k;
    char name[80];

    v.x = random_array((size_t)n * (size_t)c * (size_t)(size * size), 1);
    v.w = random_array((size_t)o * (size_t)(c / groups * k * k) + (size_t)o, 2);
    v.y = random_array((size_t)n * (size_t)o * (size_t)out, 3);
    v.work = lt_alloc(lt_conv2d_weights_work(&v.p) + lt_conv2d_backward_data_work(&v.p)
                      + lt_conv2d_forward_work(&v.p));
    v.packed = random_array((size_t)lt_max_i64(lt_conv2d_packed(&v.p), lt_conv2d_data_packed(&v.p)), 4);
    lt_conv2d_pack(&v.p, v.w, v.packed);
    snprintf(name, sizeof(name), "conv %dx%d/%d %4d -> %4d @%d%s, b%d forward", k, k, stride, c, o, size,
             groups > 1 ? " depthwise" : "", n);
    report(name, flop, run_forward, &v);
    if (n > 1) {
        report("    data gradient", flop, run_data, &v);
        report("    weight gradient", flop, run_weights, &v);
    }
    free_array(v.x), free_array(v.w), free_array(v.packed), free_array(v.y), lt_release(v.work);
}

/* ---- the rest ------------------------------------------------------------------------------------------- */

enum { N = 1 << 15 };
typedef struct { float *y, *a, *b; } arrays;

#define RUN(name, call)                                                                             \
    static void run_##name(void *ctx)                                                               \
    {                                                                                               \
        const arrays *s = ctx;                                                                      \
        for (int i = 0; i < 10; i++)                                                                \
            call;                                                                                   \
    }
RUN(add, lt_k->add(s->y, s->a, s->b, N))
RUN(relu_in_place, lt_k->relu(s->y, s->y, N))
RUN(exp, lt_k->exp(s->y, s->a, N))
RUN(sigmoid, lt_k->sigmoid(s->y, s->a, N))
RUN(tanh, lt_k->tanh(s->y, s->a, N))
RUN(gelu, lt_k->gelu(s->y, s->a, N))
RUN(gelu_grad, lt_k->gelu_grad(s->y, s->a, s->b, N))
RUN(silu_grad, lt_k->silu_grad(s->y, s->a, s->b, N))
RUN(sum, s->y[0] = (float)lt_k->sum(s->a, N))
RUN(dot, s->y[0] = (float)lt_k->dot(s->a, s->b, N))
RUN(softmax, lt_k->softmax(s->y, s->a, N))
RUN(layer_norm, lt_k->layer_norm(s->y, NULL, s->a, s->b, s->b, 1e-5, N / 256, 256))
RUN(layer_norm_grad, for (int r = 0; r < N / 256; r++)
    lt_k->layer_norm_grad(s->y + 256 * r, NULL, NULL, s->a + 256 * r, s->b + 256 * r, s->b,
                          (const float[]){ 0, 1 }, 256))

static void run_maxpool(void *ctx)
{
    static int32_t where[64 * 64];
    const arrays *s = ctx;

    for (int i = 0; i < 20; i++)
        lt_k->maxpool(s->y, where, s->a, 128, 128, 3, 2, 1, 64, 64);
}

static void run_adam(void *ctx)
{
    const arrays *s = ctx;
    const lt_adam_step p = { 1e-3f, 0.9f, 0.999f, 1e-8f, 0, 0.01f, 0.1f, 0.001f, 1 };

    for (int i = 0; i < 10; i++)
        lt_k->adam(s->y, s->y + N, s->y + 2 * N, s->b, &p, N);
}

static void bench_runs(void)
{
    const struct { const char *name; run_fn fn; } runs[] = {
        { "add", run_add }, { "relu in place", run_relu_in_place }, { "exp", run_exp },
        { "sigmoid", run_sigmoid }, { "tanh", run_tanh }, { "gelu", run_gelu },
        { "gelu_grad", run_gelu_grad }, { "silu_grad", run_silu_grad }, { "sum", run_sum },
        { "dot", run_dot }, { "softmax", run_softmax }, { "layer_norm", run_layer_norm },
        { "layer_norm_grad", run_layer_norm_grad }, { "adam", run_adam },
        { "maxpool 3x3/2 (per element read)", run_maxpool },
    };
    arrays s = { random_array(3 * N, 1), random_array(N, 2), random_array(N, 3) };

    memset(s.y + N, 0, 2 * N * sizeof(float));
    for (size_t i = 0; i < LT_COUNT(runs); i++)
        printf("  %-46s %8.3f ns per element\n", runs[i].name,
               1e9 * measure(runs[i].fn, &s).median / (10 * N));
    free_array(s.y), free_array(s.a), free_array(s.b);
}

static void bench_threads(int threads)
{
    lt_set_threads(threads);
    printf("%s, %d threads\n", lt_isa_name(lt_k->isa), threads);
    bench_gemm(LT_NO_TRANS, LT_NO_TRANS, 1024, 1024, 1024);
    bench_gemm(LT_NO_TRANS, LT_TRANS, 1024, 1024, 1024);
    bench_gemm(LT_TRANS, LT_NO_TRANS, 1024, 1024, 1024);
    bench_gemm(LT_NO_TRANS, LT_TRANS, 784, 512, 128);
    bench_gemm(LT_NO_TRANS, LT_TRANS, 8192, 256, 256);
    for (int batch = 1; batch <= 8; batch += 7) {
        bench_conv(batch, 3, 256, 64, 7, 2, 1);
        bench_conv(batch, 64, 64, 64, 3, 1, 1);
        bench_conv(batch, 128, 32, 128, 3, 1, 1);
        bench_conv(batch, 128, 64, 128, 3, 2, 1);
        bench_conv(batch, 256, 16, 256, 3, 1, 1);
        bench_conv(batch, 512, 8, 512, 3, 1, 1);
        bench_conv(batch, 256, 64, 256, 3, 1, 1);
        bench_conv(batch, 256, 32, 256, 3, 1, 1);
        bench_conv(batch, 256, 64, 64, 1, 1, 1);
        bench_conv(batch, 1024, 16, 256, 1, 1, 1);
        bench_conv(batch, 2048, 8, 512, 1, 1, 1);
        bench_conv(batch, 144, 56, 144, 3, 1, 144);
    }
}

void bench(void)
{
    lt_set_threads(1);
    bench_runs();
    bench_threads(1);
    bench_threads(2);
}
