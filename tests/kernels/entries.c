/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Every entry of the table against the generic one, bit by bit: n from 0 to a few vectors, every
 * misalignment, awkward numbers, guard words around every array; and the promised accuracies.
 * The product's and packing's entries are held by products.c, through what they are for.
 */
#include "tests/kernels/checkasm.h"

#include "libtensor/base/rng.h"

#include <math.h>
#include <string.h>

enum { ARRAYS = 6, OUTS = 3, MOST = 160 };

/* y[0 .. 2] are read and written, x[0 .. 2] only read; each has n elements. */
typedef struct { float *y[3], *x[3]; double out[OUTS]; size_t n; } args;

typedef void (*call_fn)(const lt_kernels *k, args *s);

#define CALL(name, call) static void call_##name(const lt_kernels *k, args *s) { call; }
#define Y s->y[0]
#define A s->x[0]
#define B s->x[1]
#define C s->x[2]

CALL(add, k->add(Y, A, B, s->n))
CALL(sub, k->sub(Y, A, B, s->n))
CALL(mul, k->mul(Y, A, B, s->n))
CALL(scale, k->scale(Y, A, 1.7f, s->n))
CALL(add_to, k->add_to(Y, A, s->n))
CALL(axpy, k->axpy(Y, -0.3f, A, s->n))
CALL(mul_to, k->mul_to(Y, A, B, s->n))
CALL(axpy_in_2, k->axpy_in(Y, 0.7f, A, 2, (s->n + 1) / 2))
CALL(axpy_in_3, k->axpy_in(Y, 0.7f, A, 3, (s->n + 2) / 3))
CALL(axpy_out_2, k->axpy_out(Y, 2, 0.7f, A, (s->n + 1) / 2))
CALL(relu, k->relu(Y, A, s->n))
CALL(leaky_relu, k->leaky_relu(Y, A, 0.1f, s->n))
CALL(silu, k->silu(Y, A, s->n))
CALL(elu, k->elu(Y, A, s->n))
CALL(gelu, k->gelu(Y, A, s->n))
CALL(quick_gelu, k->quick_gelu(Y, A, s->n))
CALL(sigmoid, k->sigmoid(Y, A, s->n))
CALL(tanh, k->tanh(Y, A, s->n))
CALL(exp, k->exp(Y, A, s->n))
CALL(leaky_relu_grad, k->leaky_relu_grad(Y, A, B, 0.1f, s->n))
CALL(silu_grad, k->silu_grad(Y, A, B, s->n))
CALL(elu_grad, k->elu_grad(Y, A, B, s->n))
CALL(gelu_grad, k->gelu_grad(Y, A, B, s->n))
CALL(quick_gelu_grad, k->quick_gelu_grad(Y, A, B, s->n))
CALL(sigmoid_grad, k->sigmoid_grad(Y, A, B, s->n))
CALL(tanh_grad, k->tanh_grad(Y, A, B, s->n))
CALL(affine, k->affine(Y, A, 1.5f, -0.2f, NULL, (lt_act){ LT_ACT_NONE, 0 }, s->n))
CALL(affine_relu, k->affine(Y, A, 1.5f, -0.2f, NULL, (lt_act){ LT_ACT_RELU, 0 }, s->n))
CALL(affine_silu, k->affine(Y, A, 1.5f, -0.2f, NULL, (lt_act){ LT_ACT_SILU, 0 }, s->n))
CALL(affine_residual, k->affine(Y, A, 1.5f, -0.2f, B, (lt_act){ LT_ACT_LEAKY_RELU, 0.2f }, s->n))
#define RELU (&(lt_behind){ .y = C, .slope = 0.2f })
#define RELU_OF_X (&(lt_behind){ .slope = 0.2f, .a = -1, .b = 0.3f })
#define SILU_OF_X (&(lt_behind){ .a = -1, .b = 0.3f, .silu = true })
CALL(affine_grad, k->affine_grad(Y, A, NULL, B, 0.5f, -2, 0.1f, false, s->n))
CALL(affine_grad_add, k->affine_grad(Y, A, NULL, B, 0.5f, -2, 0.1f, true, s->n))
CALL(affine_grad_relu, k->affine_grad(Y, A, RELU, B, 0.5f, -2, 0.1f, false, s->n))
CALL(affine_grad_relu_add, k->affine_grad(Y, A, RELU, B, 0.5f, -2, 0.1f, true, s->n))
CALL(affine_grad_relu_of_x, k->affine_grad(Y, A, RELU_OF_X, B, 0.5f, -2, 0.1f, false, s->n))
CALL(affine_grad_silu, k->affine_grad(Y, A, SILU_OF_X, B, 0.5f, -2, 0.1f, false, s->n))
CALL(affine_grad_in_place, k->affine_grad(Y, Y, RELU_OF_X, B, 0.5f, -2, 0.1f, false, s->n))
CALL(sum, s->out[0] = k->sum(A, s->n))
CALL(sumsq, s->out[0] = k->sumsq(A, s->n))
CALL(dot, s->out[0] = k->dot(A, B, s->n))
CALL(dot_step, s->out[0] = k->dot_step(A, B, 2, (s->n + 1) / 2))
CALL(moments, k->moments(s->out, A, 0, 1, s->n))
CALL(moments_of_3, k->moments(s->out, A, (int64_t)s->n / 3, 3, s->n / 3))
CALL(grad_moments, k->grad_moments(s->out, NULL, A, NULL, B, 0.3, 0, 1, s->n))
CALL(grad_moments_of_2, k->grad_moments(s->out, NULL, A, NULL, B, 0.3, (int64_t)s->n / 2, 2, s->n / 2))
CALL(grad_moments_relu, k->grad_moments(s->out, NULL, A, RELU, B, 0.3, (int64_t)s->n / 2, 2, s->n / 2))
CALL(grad_moments_silu, k->grad_moments(s->out, NULL, A, SILU_OF_X, B, 0.3, 0, 1, s->n))
CALL(grad_moments_relu_of_x, k->grad_moments(s->out, NULL, A, RELU_OF_X, B, 0.3, 0, 1, s->n))
#define TO_Y (&(lt_through){ .dz = Y })
#define TO_BOTH (&(lt_through){ Y, s->y[1] })
CALL(grad_moments_through, k->grad_moments(s->out, TO_BOTH, A, SILU_OF_X, B, 0.3, (int64_t)s->n / 2, 2, s->n / 2))
CALL(grad_moments_in_place, k->grad_moments(s->out, TO_Y, Y, RELU, B, 0.3, (int64_t)s->n / 2, 2, s->n / 2))
CALL(softmax, k->softmax(Y, A, s->n))
CALL(softmax_grad, k->softmax_grad(Y, A, B, s->n))
CALL(layer_norm, k->layer_norm(Y, NULL, A, B, C, 1e-5, 1, s->n))
CALL(layer_norm_bare, k->layer_norm(Y, NULL, A, NULL, NULL, 1e-5, 1, s->n))
CALL(layer_norm_rows, k->layer_norm(Y, NULL, A, B, C, 1e-5, s->n / 7, 7))
CALL(layer_norm_grad, k->layer_norm_grad(Y, s->y[1], s->y[2], A, B, C, (float[]){ 0.1f, 2 }, s->n))
CALL(layer_norm_grad_bare, k->layer_norm_grad(Y, NULL, NULL, A, B, NULL, (float[]){ 0.1f, 2 }, s->n))

static void call_adam(const lt_kernels *k, args *s)
{
    const lt_adam_step p = { 1e-2f, 0.9f, 0.99f, 1e-8f, 0.01f, 0.1f, 0.19f, 0.02f, 0.5f };

    k->mul(s->y[2], s->y[2], s->y[2], s->n);        /* a running mean of squares */
    k->adam(Y, s->y[1], s->y[2], A, &p, s->n);
}

static void call_sgd(const lt_kernels *k, args *s)
{
    const lt_sgd_step plain = { 0.1f, 0.9f, 0.01f, 0.5f, false }, ahead = { 0.1f, 0.9f, 0, 1, true };

    k->sgd(Y, s->y[1], A, &plain, s->n);
    k->sgd(Y, s->y[1], B, &ahead, s->n);
}

static const lt_masking third = { 0x123456789abcdefu, 0xfedcba987654321u, 0x55555555u, 1.5f };

CALL(dropout, k->dropout(Y, A, &third, NULL, 0, s->n, false))
CALL(dropout_add, k->dropout(Y, A, &third, NULL, 4 * ((int64_t)1 << 32) - 64, s->n, true))
CALL(dropout_relu, k->dropout(Y, A, &third, RELU, 8, s->n, false))

/* Planes as high as n allows: the window that has a loop of its own, the other one, and any other. */
static void pool(const lt_kernels *k, args *s, int w, int window, int step, int pad, bool places)
{
    int32_t where[MOST];
    const int h = (int)s->n / w, out_h = (h + 2 * pad - window) / step + 1;
    const int out_w = (w + 2 * pad - window) / step + 1;

    if (h < window - pad)
        return;
    k->maxpool(Y, places ? where : NULL, A, h, w, window, step, pad, out_h, out_w);
    if (places)
        k->maxpool_grad(s->y[1], B, where, (size_t)(out_h * out_w));
}

/* The same of a block of planes, three or more high */
static void pool_block(const lt_kernels *k, args *s, int window, int step)
{
    enum { W = 3 };
    const int h = (int)(s->n / (W * LT_BLOCK)), pad = window / 2;

    if (h >= window - pad)
        k->maxpool_block(Y, A, h, W, window, step, pad, (h + 2 * pad - window) / step + 1,
                         (W + 2 * pad - window) / step + 1);
}

/* Rows 11 apart; matrices of 11 columns and of as many rows as n allows. */
CALL(combine, k->combine(Y, A, 11, (float[]){ 0.3f, -2, 7 }, 3, s->n < 22 ? 0 : s->n - 22, false))
CALL(combine_add, k->combine(Y, A, 1, B, (int64_t)s->n / 2, (s->n + 1) / 2, true))
CALL(combine_none, k->combine(Y, A, 1, B, 0, s->n, false))
/* Outputs in as many rows as there is room for, each of some inputs a few steps on: all of them near, or not */
static void call_columns(const lt_kernels *k, args *s, bool near, bool add)
{
    enum { N = 21, LD = 32, TAPS = 3, WIDE = 200 };
    static const int32_t base[2] = { 2, 40 };
    const int64_t rows = (int64_t)s->n / WIDE;
    int32_t at[TAPS * LD];

    for (int i = 0; i < TAPS * LD; i++)
        at[i] = i % 7 == 3 ? -1 : i * 5 % (near ? 32 : 150);
    k->combine_columns(Y, N + 2, A, WIDE, rows, &(lt_columns){ N, TAPS, base, at, B, near }, add);
}

CALL(columns_near, call_columns(k, s, true, false))
CALL(columns_near_add, call_columns(k, s, true, true))
CALL(columns_far, call_columns(k, s, false, false))
CALL(columns_far_add, call_columns(k, s, false, true))
CALL(turn, k->turn(Y, (int64_t)s->n / 11, A, 11, (int64_t)s->n / 11, 11, false))
CALL(turn_add, k->turn(Y, 11, A, (int64_t)s->n / 11, 11, (int64_t)s->n / 11, true))
CALL(turn_wide, k->turn(Y, (int64_t)s->n / 37, A, 37, (int64_t)s->n / 37, 36, true))
CALL(turn_high, k->turn(Y, 37, A, (int64_t)s->n / 37, 36, (int64_t)s->n / 37, false))

CALL(maxpool, pool(k, s, 7, 3, 2, 1, true))
CALL(maxpool_wide, pool(k, s, 37, 3, 2, 1, true))
CALL(maxpool_values, pool(k, s, 37, 3, 2, 1, false))
CALL(maxpool_2, pool(k, s, 36, 2, 2, 0, true))
CALL(maxpool_2_padded, pool(k, s, 2, 2, 2, 1, true))
CALL(maxpool_2_values, pool(k, s, 70, 2, 2, 0, false))
CALL(maxpool_3_each, pool(k, s, 21, 3, 1, 1, true))
CALL(maxpool_5, pool(k, s, 9, 5, 3, 2, true))
CALL(maxpool_block, pool_block(k, s, 5, 1))
CALL(maxpool_block_2, pool_block(k, s, 3, 2))

/* Planes as long as n allows, and what follows the words is left as it was. */
static void planes(const lt_kernels *k, args *s, int count, bool gated, bool has_negative)
{
    const lt_int8_range r = { 0.01f, has_negative };
    const size_t n = s->n / (size_t)count;

    k->bytes_of_planes(Y, A, (int64_t)n, count, gated && s->n >= 4 ? B : NULL, &r, n);
}

/* Panels as wide as Y allows for a word in each column; they are as wide as the table says, so only the columns that
 * there are can be compared. */
static void panels(const lt_kernels *k, args *s, int count, bool gated, bool has_negative)
{
    const lt_int8_range r = { 0.01f, has_negative };
    const int64_t n = (int64_t)s->n / count, words = lt_ceil_div(count, 4);
    float *out = guarded_array((size_t)(lt_ceil_div(n, k->nr) * k->nr * words));

    k->bytes_of_panels(out, A, n, count, gated && (int64_t)s->n >= count ? B : NULL, &r, n);
    for (int64_t i = 0; i < n * words; i++)
        Y[i] = out[i % n / k->nr * k->nr * words + i / n * k->nr + i % n % k->nr];
    free_array(out);
}

CALL(bytes_raise, k->bytes_raise(Y, s->n))
CALL(bytes_of_panels, panels(k, s, 4, true, true))
CALL(bytes_of_panels_7, panels(k, s, 7, false, false))
CALL(bytes_of_panels_9, panels(k, s, 9, true, true))
CALL(bytes_of_planes, planes(k, s, 4, false, true))
CALL(bytes_of_planes_gated, planes(k, s, 4, true, true))
CALL(bytes_of_planes_3, planes(k, s, 3, true, false))
CALL(bytes_of_plane, planes(k, s, 1, false, false))
CALL(bytes_of_row, k->bytes_of_row(Y, A, &((lt_int8_range){ 0.01f, false }), s->n))
CALL(bytes_of_row_signed, k->bytes_of_row(Y, A, &((lt_int8_range){ 0.01f, true }), s->n))

#define ENTRY(name) { #name, call_##name }
static const struct { const char *name; call_fn call; } entries[] = {
    ENTRY(add), ENTRY(sub), ENTRY(mul), ENTRY(scale), ENTRY(add_to), ENTRY(axpy), ENTRY(mul_to), ENTRY(axpy_in_2),
    ENTRY(axpy_in_3), ENTRY(axpy_out_2), ENTRY(relu), ENTRY(leaky_relu), ENTRY(silu), ENTRY(elu), ENTRY(gelu),
    ENTRY(quick_gelu), ENTRY(sigmoid), ENTRY(tanh), ENTRY(exp), ENTRY(leaky_relu_grad), ENTRY(silu_grad),
    ENTRY(elu_grad), ENTRY(gelu_grad), ENTRY(quick_gelu_grad), ENTRY(sigmoid_grad), ENTRY(tanh_grad), ENTRY(affine),
    ENTRY(affine_relu),
    ENTRY(affine_silu), ENTRY(affine_residual), ENTRY(affine_grad_relu), ENTRY(grad_moments_relu),
    ENTRY(affine_grad_add), ENTRY(affine_grad_relu_add), ENTRY(affine_grad_relu_of_x), ENTRY(affine_grad_in_place),
    ENTRY(affine_grad_silu), ENTRY(grad_moments_silu), ENTRY(grad_moments_through), ENTRY(grad_moments_in_place),
    ENTRY(grad_moments_relu_of_x), ENTRY(affine_grad), ENTRY(sum), ENTRY(sumsq), ENTRY(dot), ENTRY(dot_step),
    ENTRY(moments), ENTRY(grad_moments), ENTRY(moments_of_3), ENTRY(grad_moments_of_2),
    ENTRY(softmax), ENTRY(softmax_grad), ENTRY(layer_norm), ENTRY(layer_norm_bare), ENTRY(layer_norm_rows),
    ENTRY(layer_norm_grad), ENTRY(layer_norm_grad_bare), ENTRY(adam), ENTRY(sgd), ENTRY(dropout), ENTRY(dropout_add),
    ENTRY(dropout_relu),
    ENTRY(combine), ENTRY(combine_add), ENTRY(combine_none), ENTRY(columns_near), ENTRY(columns_near_add),
    ENTRY(columns_far), ENTRY(columns_far_add), ENTRY(turn), ENTRY(turn_add), ENTRY(turn_wide),
    ENTRY(turn_high), ENTRY(maxpool), ENTRY(maxpool_wide), ENTRY(maxpool_values), ENTRY(maxpool_2),
    ENTRY(bytes_raise), ENTRY(bytes_of_panels), ENTRY(bytes_of_panels_7), ENTRY(bytes_of_panels_9),
    ENTRY(bytes_of_planes), ENTRY(bytes_of_planes_gated), ENTRY(bytes_of_planes_3), ENTRY(bytes_of_plane),
    ENTRY(bytes_of_row), ENTRY(bytes_of_row_signed), ENTRY(maxpool_2_padded), ENTRY(maxpool_2_values),
    ENTRY(maxpool_3_each), ENTRY(maxpool_5), ENTRY(maxpool_block), ENTRY(maxpool_block_2),
};

/* ---- running one entry twice -------------------------------------------------------------------------- */

/* Numbers of all sizes; with `awkward`, one in four is one that trips things. */
static float number(lt_rng *r, bool awkward)
{
    static const float trip[] = { NAN, INFINITY, -INFINITY, 0.0f, -0.0f, 1e-40f, -1e-45f, 3e38f, -3e38f,
                                  88.8f, -104.0f, 0.6f, 0.93f, 4.0f, 1.17549435e-38f };

    if (awkward && lt_rng_below(r, 4) == 0)
        return trip[lt_rng_below(r, LT_COUNT(trip))];
    return (float)(lt_rng_normal(r) * exp(lt_rng_range(r, -6, 3)));
}

/* The same contents for the same n, whatever the offset. */
static void fill(args *s, float *base[ARRAYS], size_t n, size_t offset, bool awkward)
{
    lt_rng r = lt_rng_make(7, n * 2 + awkward);

    memset(s->out, 0, sizeof(s->out));
    s->n = n;
    for (int i = 0; i < ARRAYS; i++) {
        float *at;

        base[i] = guarded_array(n + offset);
        at = base[i] + offset;
        for (size_t j = 0; j < n; j++)
            at[j] = number(&r, awkward);
        *(i < 3 ? &s->y[i] : &s->x[i - 3]) = at;
    }
}

static bool same_double(double a, double b)
{
    return memcmp(&a, &b, sizeof(a)) == 0 || (a != a && b != b);
}

static void check_one(const lt_kernels *k, const lt_kernels *generic, size_t e, size_t n, size_t offset,
                      bool awkward)
{
    float *want_base[ARRAYS], *got_base[ARRAYS];
    args want, got;

    fill(&want, want_base, n, 0, awkward);
    fill(&got, got_base, n, offset, awkward);
    entries[e].call(generic, &want);
    entries[e].call(k, &got);
    for (int i = 0; i < 3; i++) {
        expect_bits(got.y[i], want.y[i], n, "%s n %zu offset %zu awkward %d, output %d",
                    entries[e].name, n, offset, awkward, i);
        expect_bits(got.x[i], want.x[i], n, "%s n %zu, input %d", entries[e].name, n, i);
    }
    for (int i = 0; i < OUTS; i++)
        if (!same_double(want.out[i], got.out[i]))
            expect_near(got.out[i], want.out[i], -1, entries[e].name, "result", n);
    for (int i = 0; i < ARRAYS; i++)
        free_array(want_base[i]), free_array(got_base[i]);
}

/* y = f(x) with y on x itself gives what it gives elsewhere. */
static void check_in_place(const lt_kernels *k)
{
    for (size_t e = 0; e < LT_COUNT(entries); e++) {
        const char *const in_place[] = { "add", "sub", "mul", "scale", "relu", "leaky_relu", "silu",
                                         "elu", "gelu", "quick_gelu", "sigmoid", "tanh", "exp", "affine",
                                         "affine_silu", "softmax", "layer_norm" };
        float *base[ARRAYS];
        float *copy;
        bool listed = false;
        args s;

        for (size_t i = 0; i < LT_COUNT(in_place); i++)
            listed |= strcmp(entries[e].name, in_place[i]) == 0;
        if (!listed)
            continue;
        fill(&s, base, 77, 0, true);
        copy = guarded_array(s.n);
        memcpy(copy, s.x[0], s.n * sizeof(float));
        entries[e].call(k, &s);
        s.x[0] = copy;
        float *apart = s.y[0];
        s.y[0] = copy;
        entries[e].call(k, &s);
        expect_bits(copy, apart, s.n, "%s in place", entries[e].name);
        for (int i = 0; i < ARRAYS; i++)
            free_array(base[i]);
        free_array(copy);
    }
}

void check_entries(const lt_kernels *k, const lt_kernels *generic)
{
    for (size_t e = 0; e < LT_COUNT(entries); e++) {
        for (size_t n = 0; n <= 70; n++)
            for (int awkward = 0; awkward < 2; awkward++)
                check_one(k, generic, e, n, 0, awkward);
        for (size_t offset = 1; offset < 16; offset++)
            check_one(k, generic, e, 53, offset, true);
        check_one(k, generic, e, MOST - 3, 1, false);
    }
    check_in_place(k);
}

/* ---- accuracy --------------------------------------------------------------------------------------------- */

static double exact_exp(double x) { return exp(x); }
static double exact_sigmoid(double x) { return 1 / (1 + exp(-x)); }
static double exact_silu(double x) { return x / (1 + exp(-x)); }
static double exact_quick_gelu(double x) { return x / (1 + exp(-1.702 * x)); }
static double exact_tanh(double x) { return tanh(x); }
static double exact_gelu(double x) { return 0.5 * x * erfc(-x * sqrt(0.5)); }

/* The error in units of the last place of the exact value (of 1e-37 below that, when floor is set). */
static double ulps(float got, double want, bool floor)
{
    const double size = fmax(fabs(want), floor ? 1e-37 : 0);
    int e;

    if (fabs(want) > 3.4028235e38)
        return isinf(got) ? 0 : HUGE_VAL;
    frexp(size, &e);
    return fabs((double)got - want) / ldexp(1, (e < -125 ? -125 : e) - 24);
}

static double worst(void (*fn)(float *, const float *, size_t), double (*exact)(double), double lo,
                    double hi, bool floor)
{
    enum { N = 1000 };
    float x[N], y[N];
    double most = 0;

    for (int part = 0; part < 60; part++) {
        for (int i = 0; i < N; i++)
            x[i] = (float)(lo + (hi - lo) * (part + (double)i / N) / 60);
        fn(y, x, N);
        for (int i = 0; i < N; i++)
            most = fmax(most, ulps(y[i], exact((double)x[i]), floor));
    }
    return most;
}

static void check_bound(const char *name, double error, double bound)
{
    expect_near(error, 0, bound, name, "units in the last place", 0);
}

static void check_gelu(const lt_kernels *k)
{
    const float far[] = { -5.65f, -100, 5.65f, 100 }, limits[] = { 0, 0, 5.65f, 100 };
    float at_far[4];

    k->gelu(at_far, far, 4);
    for (size_t i = 0; i < 4; i++)
        expect_near((double)at_far[i], (double)limits[i], 0, "gelu", "far from 0", i);
    for (int i = -6000; i <= 6000; i++) {
        const float x = (float)i * 1e-3f;
        float y;

        k->gelu(&y, &x, 1);
        expect_near((double)y, exact_gelu((double)x), 2e-7 * fmax(fabs((double)x), 1e-3), "gelu", "x",
                    (size_t)(i + 6000));
    }
}

/* Its draws are those of lt_rng_u32. */
static void check_dropout(const lt_kernels *k)
{
    enum { N = 1000 };
    const int64_t at = ((int64_t)1 << 34) - 64;         /* where the block's number outgrows 32 bits */
    lt_rng r = lt_rng_make(third.seed, third.stream);
    float x[N], y[N];

    for (int i = 0; i < N; i++)
        x[i] = 1;
    k->dropout(y, x, &third, NULL, at, N, false);
    r.index = (uint64_t)at;
    for (int i = 0; i < N; i++)
        expect_near(y[i], lt_rng_u32(&r) < third.below ? 0 : 1.5, 0, "dropout", "draw", (size_t)i);
}

/* Rows about a mean of 1000 with a deviation near 1, in double as well: far from what their first and other elements
 * say in two of five, all alike in one. */
static void check_layer_norm(const lt_kernels *k)
{
    enum { ROWS = 5, N = 259 };
    float *x = random_array(ROWS * N, 1), *y = guarded_array(ROWS * N);

    for (int i = 0; i < ROWS * N; i++)
        x[i] = 1000 + (i / N == 4 ? 0 : 1.7f * x[i]);
    for (int q = 0; q < 4; q++)
        x[N + N / 4 * q] = 1060, x[3 * N + N / 4 * q] = -2e6f;
    k->layer_norm(y, NULL, x, NULL, NULL, 1e-5, ROWS, N);
    for (int r = 0; r < ROWS; r++) {
        double mean = 0, variance = 0;

        for (int i = 0; i < N; i++)
            mean += (double)x[r * N + i] / N;
        for (int i = 0; i < N; i++)
            variance += pow((double)x[r * N + i] - mean, 2) / N;
        for (int i = 0; i < N; i++) {
            const double want = ((double)x[r * N + i] - mean) / sqrt(variance + 1e-5);

            expect_near(y[r * N + i], want, 1e-6 * (1 + fabs(want)), "layer_norm", "far means", (size_t)(r * N + i));
        }
    }
    free_array(x), free_array(y);
}

void check_accuracy(const lt_kernels *k)
{
    const double e = fmax(worst(k->exp, exact_exp, -104, 89, false),
                          worst(k->exp, exact_exp, -1, 1, false));
    const double t = fmax(worst(k->tanh, exact_tanh, -10, 10, false),
                          worst(k->tanh, exact_tanh, -0.7, 0.7, false));
    const double s = worst(k->sigmoid, exact_sigmoid, -85, 30, true);
    const double u = worst(k->silu, exact_silu, -85, 30, true);
    const double q = worst(k->quick_gelu, exact_quick_gelu, -50, 30, true);

    printf("  largest errors in units of the last place: exp %.2f, tanh %.2f, sigmoid %.2f, silu %.2f, "
           "quick_gelu %.2f\n", e, t, s, u, q);
    check_bound("exp", e, 2);
    check_bound("tanh", t, 3);
    check_bound("sigmoid", s, 3);
    check_bound("silu", u, 3);
    check_bound("quick_gelu", q, 3);
    check_gelu(k);
    check_dropout(k);
    check_layer_norm(k);
}
