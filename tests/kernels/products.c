/* SPDX-License-Identifier: Apache-2.0 */
/* Products and convolutions against plain loops: many shapes, every instruction set, 1 to 4 threads. */
#include "tests/kernels/checkasm.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv/conv.h"
#include "libtensor/kernels/conv/winograd_weights.h"
#include "libtensor/kernels/gemm/gemm.h"

#include <math.h>
#include <string.h>

/* ---- products ------------------------------------------------------------------------------------- */

typedef struct { int64_t m, n, k; } gemm_case;

static const gemm_case gemms[] = {
    { 1, 1, 1 }, { 3, 5, 7 }, { 14, 32, 16 }, { 15, 33, 17 }, { 13, 31, 257 }, { 1, 100, 300 },
    { 100, 1, 300 }, { 64, 64, 0 }, { 67, 129, 513 }, { 300, 70, 40 }, { 130, 800, 30 }, { 29, 47, 1000 },
    { 31, 45, 1024 },
};

/* One chain of multiply-adds per element, in the order of k. */
static void plain_gemm(const gemm_case *g, lt_trans ta, lt_trans tb, const float *a, const float *b,
                       bool add, float *c)
{
    for (int64_t i = 0; i < g->m; i++)
        for (int64_t j = 0; j < g->n; j++) {
            float total = add ? c[i * g->n + j] : 0;

            for (int64_t l = 0; l < g->k; l++)
                total = fmaf(a[ta ? l * g->m + i : i * g->k + l], b[tb ? j * g->k + l : l * g->n + j],
                             total);
            c[i * g->n + j] = total;
        }
}

static void check_gemm(const gemm_case *g, lt_trans ta, lt_trans tb, bool add, bool plainly)
{
    const size_t size = (size_t)(g->m * g->n);
    float *a = random_array((size_t)(g->m * g->k), 1), *b = random_array((size_t)(g->k * g->n), 2);
    float *want = random_array(size, 3), *got = guarded_array(size);
    char name[80];

    memcpy(got, want, size * sizeof(float));
    snprintf(name, sizeof(name), "gemm %dx%dx%d trans %d %d add %d", (int)g->m, (int)g->n, (int)g->k,
             ta, tb, add);
    lt_gemm(ta, tb, g->m, g->n, g->k, a, ta ? g->m : g->k, b, tb ? g->k : g->n, add, got, g->n, NULL);
    if (plainly) {
        plain_gemm(g, ta, tb, a, b, add, want);
        expect_bits(got, want, size, "%s", name);
    }
    same_as_before(got, size, "%s", name);
    free_array(a), free_array(b), free_array(want), free_array(got);
}

/* Packed weights give what the same product without gives, with all that may follow it. */
static void check_packed(const gemm_case *g, lt_trans ta, lt_trans tb)
{
    const size_t size = (size_t)(g->m * g->n);
    const int64_t lda = ta ? g->m : g->k, ldb = tb ? g->k : g->n;
    float *a = random_array((size_t)(g->m * g->k), 1), *b = random_array((size_t)(g->k * g->n), 2);
    float *bias = random_array((size_t)g->n, 4), *residual = random_array(size, 5);
    float *packed = guarded_array((size_t)lt_gemm_packed_count(g->n, g->k));
    float *want = guarded_array(size), *got = guarded_array(size);
    const lt_epilogue e = {
        .col_bias = bias, .residual = residual, .ld_residual = g->n, .act = { LT_ACT_GELU, 0 },
    };

    lt_gemm_pack(tb, g->n, g->k, b, ldb, packed);
    lt_gemm(ta, tb, g->m, g->n, g->k, a, lda, b, ldb, false, want, g->n, &e);
    lt_gemm_packed(ta, g->m, g->n, g->k, a, lda, packed, false, got, g->n, &e);
    expect_bits(got, want, size, "gemm_packed %dx%dx%d trans %d %d", (int)g->m, (int)g->n, (int)g->k, ta, tb);
    free_array(a), free_array(b), free_array(bias), free_array(residual), free_array(packed);
    free_array(want), free_array(got);
}

/* A pair gives what its two products give, for rows that end in the middle of a task, and of a tile. */
static void check_pair(int64_t m, int64_t k, int64_t hidden, int64_t n)
{
    const size_t size = (size_t)(m * n), between = (size_t)(m * hidden);
    float *a = random_array((size_t)(m * k), 1), *b1 = random_array((size_t)(k * hidden), 2);
    float *b2 = random_array((size_t)(hidden * n), 3), *bias = random_array((size_t)hidden, 4);
    float *residual = random_array(size, 5), *middle = guarded_array(between);
    float *packed1 = guarded_array((size_t)lt_gemm_packed_count(hidden, k));
    float *packed2 = guarded_array((size_t)lt_gemm_packed_count(n, hidden));
    float *want = guarded_array(size), *got = guarded_array(size);
    const lt_epilogue e1 = { .col_bias = bias, .act = { LT_ACT_GELU, 0 } };
    const lt_epilogue e2 = { .residual = residual, .ld_residual = n, .act = { LT_ACT_RELU, 0 } };

    lt_gemm_pack(LT_TRANS, hidden, k, b1, k, packed1);
    lt_gemm_pack(LT_TRANS, n, hidden, b2, hidden, packed2);
    lt_gemm_packed(LT_NO_TRANS, m, hidden, k, a, k, packed1, false, middle, hidden, &e1);
    lt_gemm_packed(LT_NO_TRANS, m, n, hidden, middle, hidden, packed2, false, want, n, &e2);
    lt_gemm_pair(m, k, a, hidden, packed1, &e1, n, packed2, &e2, got);
    expect_bits(got, want, size, "gemm_pair %dx%dx%dx%d", (int)m, (int)k, (int)hidden, (int)n);
    free_array(a), free_array(b1), free_array(b2), free_array(bias), free_array(residual), free_array(middle);
    free_array(packed1), free_array(packed2), free_array(want), free_array(got);
}

static void check_batch(int64_t a_step, int64_t b_step)
{
    const gemm_case g = { 20, 37, 19 };
    const size_t size = (size_t)(g.m * g.n);
    float *a = random_array((size_t)(g.m * g.k) * 5, 1), *b = random_array((size_t)(g.k * g.n) * 5, 2);
    float *want = random_array(size * 5, 3), *got = guarded_array(size * 5);

    for (int64_t i = 0; i < 5; i++)
        plain_gemm(&g, LT_NO_TRANS, LT_TRANS, a + i * a_step, b + i * b_step, false,
                   want + i * (int64_t)size);
    lt_gemm_batch(5, LT_NO_TRANS, LT_TRANS, g.m, g.n, g.k, a, g.k, a_step, b, g.k, b_step, false, got,
                  g.n, (int64_t)size, NULL);
    expect_bits(got, want, size * 5, "gemm_batch steps %d %d", (int)a_step, (int)b_step);
    free_array(a), free_array(b), free_array(want), free_array(got);
}

void check_gemms(bool plainly)
{
    for (size_t i = 0; i < LT_COUNT(gemms); i++)
        for (int how = 0; how < 8; how++)
            check_gemm(&gemms[i], how & 1 ? LT_TRANS : LT_NO_TRANS, how & 2 ? LT_TRANS : LT_NO_TRANS,
                       how & 4, plainly);
    for (size_t i = 0; i < LT_COUNT(gemms); i++)
        for (int how = 0; how < 4; how++)
            check_packed(&gemms[i], how & 1 ? LT_TRANS : LT_NO_TRANS, how & 2 ? LT_TRANS : LT_NO_TRANS);
    check_pair(224, 33, 47, 5);
    check_pair(301, 300, 1154, 420);
    check_pair(784, 128, 512, 128);
    check_batch(20 * 19, 19 * 37);
    check_batch(0, 19 * 37);
    check_batch(20 * 19, 0);
}

/* ---- convolutions ------------------------------------------------------------------------------------ */

static const lt_conv2d_params convs[] = {
    /* n  c   h   w   o  kh kw  stride  pad   dil  groups */
    { 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 2, 3, 5, 7, 4, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 1, 3, 23, 17, 9, 7, 7, 2, 2, 3, 3, 1, 1, 1 },
    { 3, 17, 9, 9, 33, 1, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 2, 16, 9, 8, 20, 1, 1, 2, 2, 0, 0, 1, 1, 1 },
    { 5, 8, 4, 4, 15, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 2, 6, 11, 13, 10, 3, 3, 2, 2, 1, 1, 1, 1, 2 },
    { 1, 6, 11, 13, 9, 3, 2, 1, 2, 2, 0, 2, 1, 3 },
    { 2, 4, 12, 10, 6, 5, 3, 3, 2, 4, 1, 1, 3, 1 },
    { 9, 2, 6, 6, 3, 4, 4, 2, 2, 1, 1, 1, 1, 1 },
    { 3, 8, 10, 11, 6, 1, 1, 3, 3, 1, 0, 1, 1, 1 },       /* classes without taps */
    { 2, 7, 10, 9, 7, 3, 3, 1, 1, 1, 1, 1, 1, 7 },
    { 2, 5, 10, 9, 10, 5, 5, 2, 2, 2, 2, 1, 1, 5 },
    { 1, 4, 9, 30, 4, 3, 3, 1, 3, 2, 2, 2, 2, 4 },
    { 2, 3, 7, 7, 3, 5, 5, 1, 1, 2, 2, 1, 1, 3 },
    { 1, 2, 31, 15, 2, 5, 5, 1, 1, 2, 2, 1, 1, 2 },
    { 1, 2, 45, 17, 4, 3, 3, 1, 1, 1, 1, 1, 1, 2 },
    { 1, 2, 37, 300, 2, 3, 3, 1, 1, 1, 1, 1, 1, 2 },
    { 1, 1, 70, 33, 1, 5, 5, 1, 1, 0, 0, 1, 1, 1 },
    { 1, 2, 90, 100, 2, 3, 3, 2, 2, 1, 1, 1, 1, 2 },
    { 1, 2, 14, 9, 2, 5, 5, 1, 1, 4, 4, 2, 2, 2 },
    { 1, 2, 3, 2100, 2, 3, 3, 1, 1, 1, 1, 1, 1, 2 },
    { 1, 3, 40, 64, 20, 7, 7, 2, 2, 3, 3, 1, 1, 1 },      /* from here on: rows that end with vectors */
    { 2, 5, 9, 48, 6, 5, 5, 1, 1, 2, 2, 1, 1, 1 },
    { 1, 3, 20, 32, 5, 3, 3, 1, 1, 2, 2, 2, 2, 1 },
    { 1, 4, 6, 16, 9, 3, 3, 2, 1, 1, 1, 1, 1, 1 },
    { 1, 300, 6, 5, 3, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 1, 2, 40, 33, 70, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 9, 66, 4, 4, 131, 3, 3, 1, 1, 1, 1, 1, 1, 1 },      /* several images in a band of windows */
    { 3, 65, 17, 19, 5, 3, 3, 2, 2, 1, 1, 1, 1, 1 },
    { 2, 3, 21, 18, 34, 5, 5, 1, 1, 2, 2, 1, 1, 1 },
    { 1, 2, 5, 300, 3, 3, 3, 1, 1, 1, 1, 1, 1, 1 },       /* too wide for a band */
    { 5, 70, 7, 9, 300, 1, 1, 2, 2, 0, 0, 1, 1, 1 },
    { 6, 20, 9, 7, 260, 1, 1, 1, 1, 0, 0, 1, 1, 2 },      /* blocks of positions across images */
    { 2, 140, 9, 10, 130, 3, 3, 2, 2, 1, 1, 1, 1, 1 },    /* classes that share packed maps */
    { 2, 300, 7, 7, 48, 1, 1, 1, 1, 0, 0, 1, 1, 1 },      /* from here on: turned */
    { 1, 20, 14, 14, 17, 1, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 1, 3, 9, 13, 63, 1, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 3, 33, 1, 1, 290, 1, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 2, 20, 7, 7, 70, 3, 3, 1, 1, 1, 1, 1, 1, 1 },       /* from here on: tap by tap, forward or back */
    { 1, 600, 4, 5, 21, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 2, 17, 6, 7, 130, 5, 3, 1, 1, 4, 0, 2, 1, 1 },
    { 2, 130, 14, 14, 16, 4, 4, 2, 2, 1, 1, 1, 1, 1 },
    { 1, 21, 32, 32, 128, 6, 6, 2, 2, 0, 0, 1, 1, 1 },
    { 2, 40, 9, 16, 33, 3, 2, 3, 2, 2, 1, 2, 1, 1 },
    { 1, 16, 15, 128, 20, 2, 3, 2, 8, 0, 0, 1, 1, 1 },
    { 1, 2, 29, 41, 4, 5, 5, 2, 2, 2, 2, 1, 1, 2 },       /* from here on: depthwise, windows straight from the map */
    { 1, 2, 3, 4, 2, 5, 5, 2, 2, 4, 4, 1, 1, 2 },
    { 2, 3, 37, 50, 3, 3, 3, 2, 2, 0, 2, 1, 1, 3 },
    { 1, 2, 64, 67, 2, 3, 3, 1, 1, 3, 0, 1, 1, 2 },
    { 2, 35, 7, 7, 35, 5, 5, 1, 1, 2, 2, 1, 1, 35 },      /* small maps, in lanes */
    { 1, 32, 7, 7, 32, 3, 3, 1, 1, 1, 1, 1, 1, 32 },
    { 2, 48, 14, 14, 48, 5, 5, 2, 2, 2, 2, 1, 1, 48 },
    { 1, 17, 9, 6, 17, 3, 3, 2, 2, 0, 1, 1, 1, 17 },
    { 1, 16, 4, 4, 16, 3, 3, 1, 1, 1, 1, 1, 1, 16 },
    { 1, 32, 16, 5, 32, 5, 5, 1, 1, 4, 2, 1, 1, 32 },
    { 1, 16, 3, 3, 16, 3, 3, 1, 1, 1, 1, 1, 1, 16 },
    { 2, 1, 20, 32, 12, 3, 3, 2, 2, 1, 1, 1, 1, 1 },      /* one map, many outputs */
    { 2, 19, 28, 28, 1, 3, 3, 1, 1, 1, 1, 1, 1, 1 },      /* from here on: few outputs */
    { 1, 7, 21, 37, 3, 5, 5, 2, 2, 2, 2, 1, 1, 1 },
    { 2, 32, 16, 16, 32, 3, 3, 1, 1, 1, 1, 1, 1, 1 },     /* from here on: Winograd */
    { 3, 33, 12, 13, 47, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 1, 270, 12, 14, 35, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 1, 32, 13, 70, 32, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 4, 32, 33, 30, 32, 3, 3, 1, 1, 1, 1, 1, 1, 1 },     /* the weights' gradient in several rounds, */
    { 2, 600, 9, 9, 130, 3, 3, 1, 1, 1, 1, 1, 1, 1 },     /* or by some output channels at a time */
    { 1, 32, 9, 220, 32, 3, 3, 1, 1, 1, 1, 1, 1, 1 },     /* too wide for that gradient */
    { 2, 40, 7, 7, 33, 3, 3, 1, 1, 1, 1, 1, 1, 1 },       /* from here on: F(2x2, 3x3) */
    { 1, 32, 8, 8, 100, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 3, 300, 6, 11, 48, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 1, 33, 11, 8, 65, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 2, 3, 2, 2, 4, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 1, 2, 3, 3, 2, 5, 5, 1, 1, 0, 0, 1, 1, 1 },     /* no window fits: nothing happens */
    { 1, 2, 0, 0, 2, 3, 3, 1, 1, 0, 0, 1, 1, 1 },
    { 0, 2, 3, 3, 2, 3, 3, 1, 1, 0, 0, 1, 1, 1 },
};

/* Where there are AMX's tiles: sizes that end within blocks and strips, maps that end within segments */
static const lt_conv2d_params convs_on_tiles[] = {
    { 4, 96, 23, 22, 96, 1, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 9, 140, 7, 7, 300, 1, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 5, 288, 14, 13, 65, 1, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 1, 70, 31, 33, 320, 1, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 180, 128, 2, 3, 130, 1, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 12, 64, 27, 26, 128, 1, 1, 2, 2, 0, 0, 1, 1, 1 },
    { 2, 66, 26, 28, 97, 3, 3, 2, 2, 1, 1, 1, 1, 1 },
    { 5, 96, 9, 11, 160, 3, 3, 2, 2, 1, 1, 1, 1, 1 },     /* tap by tap */
    { 3, 100, 2, 131, 102, 3, 3, 2, 2, 1, 1, 1, 1, 1 },   /* classes of several images together */
    { 1, 65, 13, 14, 64, 5, 5, 1, 1, 2, 2, 1, 1, 1 },
    { 2, 129, 11, 11, 70, 3, 3, 1, 1, 2, 2, 2, 2, 1 },
};

typedef struct {
    const lt_conv2d_params *p;
    size_t n_x, n_w, n_y;
    float *x, *w, *dy, *bias, *residual;
} conv_data;

/* Every multiplication of a convolution: y[iy] meets x[ix] with w[iw]. */
typedef void (*pair_fn)(void *ctx, int64_t iy, int64_t ix, int64_t iw);

static void each_pair(const lt_conv2d_params *p, pair_fn fn, void *ctx)
{
    const int64_t oh = lt_max_i64(0, lt_conv2d_out_h(p)), ow = lt_max_i64(0, lt_conv2d_out_w(p));
    const int64_t cg = p->c / p->groups;
    const lt_conv_algorithm how = lt_conv2d_algorithm(p);
    const bool across = how != LT_CONV_DEPTHWISE && how != LT_CONV_FEW;     /* else down the window's columns */

    for (int64_t i = 0; i < p->n * p->o * oh * ow; i++) {
        const int64_t col = i % ow, row = i / ow % oh, o = i / ow / oh % p->o, n = i / ow / oh / p->o;

        for (int64_t l = 0; l < cg * p->kh * p->kw; l++) {
            const int64_t c = l / p->kw / p->kh, t = l % (p->kw * p->kh);
            const int64_t kx = across ? t % p->kw : t / p->kh, ky = across ? t / p->kw : t % p->kh;
            const int64_t y = row * p->stride_h + ky * p->dil_h - p->pad_h;
            const int64_t x = col * p->stride_w + kx * p->dil_w - p->pad_w;
            const int64_t channel = o / (p->o / p->groups) * cg + c;

            if (y >= 0 && y < p->h && x >= 0 && x < p->w)
                fn(ctx, i, ((n * p->c + channel) * p->h + y) * p->w + x,
                   ((o * cg + c) * p->kh + ky) * p->kw + kx);
        }
    }
}

typedef struct { const conv_data *d; float *chain; double *sum, *size; int64_t tap; } plain;    /* tap: or -1 */

static void pair_forward(void *ctx, int64_t iy, int64_t ix, int64_t iw)
{
    plain *s = ctx;

    if (s->tap < 0 || iw % (s->d->p->kh * s->d->p->kw) == s->tap)
        s->chain[iy] = fmaf(s->d->w[iw], s->d->x[ix], s->chain[iy]);
}

/* One chain for each result, or one for each tap, and their sum */
static void plain_forward(const conv_data *d, float *y)
{
    float *chain = zero_array(d->n_y);
    plain s = { d, chain, NULL, NULL, 0 };

    if (lt_conv2d_algorithm(d->p) != LT_CONV_TAPWISE) {
        s.chain = y, s.tap = -1;
        each_pair(d->p, pair_forward, &s);
    } else {
        for (; s.tap < d->p->kh * d->p->kw; s.tap++) {
            memset(chain, 0, d->n_y * sizeof(float));
            each_pair(d->p, pair_forward, &s);
            for (size_t i = 0; i < d->n_y; i++)
                y[i] += chain[i];
        }
    }
    free_array(chain);
}

static void add_pair(plain *s, int64_t i, double a, double b)
{
    s->sum[i] += a * b;
    s->size[i] += fabs(a * b);
}

static void pair_data(void *ctx, int64_t iy, int64_t ix, int64_t iw)
{
    plain *s = ctx;

    add_pair(s, ix, s->d->dy[iy], s->d->w[iw]);
}

static void pair_weights(void *ctx, int64_t iy, int64_t ix, int64_t iw)
{
    plain *s = ctx;

    add_pair(s, iw, s->d->dy[iy], s->d->x[ix]);
}

static void pair_sum(void *ctx, int64_t iy, int64_t ix, int64_t iw)
{
    plain *s = ctx;

    add_pair(s, iy, s->d->w[iw], s->d->x[ix]);
}

/* What Winograd promises, as conv.h has it, of the sum of the terms' sizes. */
static const double winograd_bound = 4e-6;

static bool by_winograd(const lt_conv2d_params *p)
{
    const lt_conv_algorithm how = lt_conv2d_algorithm(p);

    return how == LT_CONV_WINOGRAD || how == LT_CONV_WINOGRAD2;
}

static double bound_of(const lt_conv2d_params *p)
{
    return by_winograd(p) ? winograd_bound : lt_conv2d_algorithm(p) == LT_CONV_TILES ? 1e-6 : 0;
}

static void check_near(const conv_data *d, const float *got, const char *name)
{
    double *sum = calloc(d->n_y, sizeof(double)), *size = calloc(d->n_y, sizeof(double));
    plain s = { d, NULL, sum, size, -1 };

    each_pair(d->p, pair_sum, &s);
    for (size_t i = 0; i < d->n_y; i++)
        expect_near(got[i], sum[i], bound_of(d->p) * size[i], "conv", name, i);
    free(sum), free(size);
}

static void check_forward(const conv_data *d, const char *name, bool plainly)
{
    const lt_conv2d_params *p = d->p;
    const int64_t out = lt_conv2d_out_h(p) * lt_conv2d_out_w(p);
    const lt_conv2d_around everything = {
        .bias = d->bias, .residual = d->residual, .act = { LT_ACT_RELU, 0 },
    };
    const size_t n_packed = (size_t)lt_conv2d_packed(p);
    float *want = zero_array(d->n_y), *got = guarded_array(d->n_y), *packed = guarded_array(n_packed);
    void *work = lt_alloc(lt_conv2d_forward_work(p));

    lt_conv2d_pack(p, d->w, packed);
    lt_conv2d_forward(p, d->x, packed, &(lt_conv2d_around){ 0 }, got, work);
    same_as_before(got, d->n_y, "conv forward %s", name);
    if (plainly && bound_of(p) > 0) {
        check_near(d, got, name);
        memcpy(want, got, d->n_y * sizeof(float));
    } else if (plainly) {
        plain_forward(d, want);
        expect_bits(got, want, d->n_y, "conv forward %s", name);
    } else {
        memcpy(want, got, d->n_y * sizeof(float));
    }
    for (size_t i = 0; i < d->n_y; i++) {
        want[i] = want[i] + d->bias[(int64_t)i / out % p->o] + d->residual[i];
        want[i] = want[i] < 0 ? 0 : want[i];
    }
    lt_conv2d_forward(p, d->x, packed, &everything, got, work);
    expect_bits(got, want, d->n_y, "conv forward with everything %s", name);
    free_array(want), free_array(got), free_array(packed), lt_release(work);
}

static bool inside(lt_rect r, int64_t y, int64_t x)
{
    return y >= r.y0 && y < r.y1 && x >= r.x0 && x < r.x1;
}

/* A rectangle of the first image: as the whole has it, and nothing else is touched. */
static void check_rect(const conv_data *d, const char *name, lt_rect r, const float *packed, const float *whole,
                       void *work)
{
    const lt_conv2d_params *p = d->p;
    const int64_t h = lt_conv2d_out_h(p), w = lt_conv2d_out_w(p), n = p->o * h * w;
    const double bound = by_winograd(p) ? 2 * winograd_bound : 0;
    float *got = guarded_array((size_t)n);

    memcpy(got, d->residual, (size_t)n * sizeof(float));
    lt_conv2d_forward_rect(p, r, d->x, packed, d->bias, got, (lt_act){ LT_ACT_RELU, 0 }, got, work);
    for (int64_t i = 0; i < n; i++) {
        const bool in = inside(r, i / w % h, i % w);

        expect_near(got[i], in ? whole[i] : d->residual[i], in ? bound * (double)(p->c * p->kh * p->kw) : 0,
                    "conv in a rectangle", name, (size_t)i);
    }
    same_as_before(got, (size_t)n, "conv %s in %d %d %d %d", name, (int)r.y0, (int)r.y1, (int)r.x0, (int)r.x1);
    free_array(got);
}

static void check_rects(const conv_data *d, const char *name)
{
    const lt_conv2d_params *p = d->p;
    const int64_t h = lt_conv2d_out_h(p), w = lt_conv2d_out_w(p);
    const lt_rect rects[] = {
        { 0, h, 0, w }, { 0, 1, 0, 1 }, { h / 3, h, w / 2, w }, { h / 4, h / 2, 0, w }, { 1, h - 1, 1, w - 1 },
        { h / 2, h / 2, 0, w },
    };
    const lt_conv2d_around everything = {
        .bias = d->bias, .residual = d->residual, .act = { LT_ACT_RELU, 0 },
    };
    float *whole = guarded_array(d->n_y), *packed = guarded_array((size_t)lt_conv2d_packed(p));
    void *work = lt_alloc(lt_conv2d_forward_work(p)), *rect_work = lt_alloc(lt_conv2d_rect_work(p));

    lt_conv2d_pack(p, d->w, packed);
    lt_conv2d_forward(p, d->x, packed, &everything, whole, work);
    for (size_t i = 0; i < LT_COUNT(rects); i++)
        check_rect(d, name, rects[i], packed, whole, rect_work);
    free_array(whole), free_array(packed), lt_release(work), lt_release(rect_work);
}

/* The gates of turned convolutions with few channels are multiplied into the weights, of each image. */
static void forward_gated_weights(const conv_data *d, const float *gate, const lt_conv2d_around *around, float *y)
{
    lt_conv2d_params p = *d->p;
    float *w = guarded_array(d->n_w), *packed = guarded_array((size_t)lt_conv2d_packed(&p));

    p.n = 1;
    for (int64_t i = 0; i < d->p->n; i++) {
        for (size_t j = 0; j < d->n_w; j++)
            w[j] = d->w[j] * gate[i * p.c + (int64_t)j % p.c];
        lt_conv2d_pack(&p, w, packed);
        lt_conv2d_forward(&p, d->x + i * p.c * p.h * p.w, packed, around, y + i * p.o * p.h * p.w, NULL);
    }
    free_array(w), free_array(packed);
}

/* Elsewhere into the maps. */
static void forward_gated_maps(const conv_data *d, const float *gate, const lt_conv2d_around *around, float *y)
{
    const lt_conv2d_params *p = d->p;
    float *x = guarded_array(d->n_x), *packed = guarded_array((size_t)lt_conv2d_packed(p));
    void *work = lt_alloc(lt_conv2d_forward_work(p));

    for (size_t i = 0; i < d->n_x; i++)
        x[i] = gate ? d->x[i] * gate[i / (size_t)(p->h * p->w)] : d->x[i];
    lt_conv2d_pack(p, d->w, packed);
    lt_conv2d_forward(p, x, packed, around, y, work);
    free_array(x), free_array(packed), lt_release(work);
}

/* Maps times their gates, and the means of what comes out. */
static void check_gate_and_mean(const conv_data *d, const char *name)
{
    const lt_conv2d_params *p = d->p;
    const size_t planes = (size_t)(p->n * p->o), out = d->n_y / (size_t)lt_max_i64(1, p->n * p->o);
    const bool gated = lt_conv2d_takes_gate(p), means = lt_conv2d_makes_mean(p);
    float *gate = random_array((size_t)(p->n * p->c), 10), *mean = guarded_array(planes);
    float *want = guarded_array(d->n_y), *got = guarded_array(d->n_y);
    float *packed = guarded_array((size_t)lt_conv2d_packed(p));
    const lt_conv2d_around without = { .bias = d->bias, .act = { LT_ACT_SILU, 0 } };
    const lt_conv2d_around around = {
        .bias = d->bias, .act = { LT_ACT_SILU, 0 }, .gate = gated ? gate : NULL, .mean = means ? mean : NULL,
    };
    void *work = lt_alloc(lt_conv2d_forward_work(p));

    if (lt_conv2d_algorithm(p) == LT_CONV_TURNED && p->o < p->h * p->w)
        forward_gated_weights(d, gate, &without, want);
    else
        forward_gated_maps(d, gated ? gate : NULL, &without, want);
    lt_conv2d_pack(p, d->w, packed);
    lt_conv2d_forward(p, d->x, packed, &around, got, work);
    expect_bits(got, want, d->n_y, "conv forward, gate and mean %s", name);
    same_as_before(got, d->n_y, "conv forward, gate and mean %s", name);
    for (size_t i = 0; means && i < planes; i++) {
        double sum = 0, size = 0;

        for (size_t j = 0; j < out; j++)
            sum += got[i * out + j], size += fabs((double)got[i * out + j]);
        expect_near(mean[i], sum / (double)out, 2e-7 * size / (double)out, "mean of a map", name, i);
    }
    if (means)
        same_as_before(mean, planes, "means of maps %s", name);
    free_array(gate), free_array(mean), free_array(want), free_array(got), free_array(packed);
    lt_release(work);
}

/* The gradient of x, or of the weights, added to what got holds or in its place */
static void run_gradient(const conv_data *d, bool data, bool add, float *got)
{
    float *packed = guarded_array(data ? (size_t)lt_conv2d_data_packed(d->p) : 0);
    void *work = lt_alloc(data ? lt_conv2d_backward_data_work(d->p) : lt_conv2d_weights_work(d->p));

    if (data) {
        lt_conv2d_data_pack(d->p, d->w, packed);
        lt_conv2d_backward_data(d->p, d->dy, packed, add, got, work);
    } else {
        lt_conv2d_backward_weights(d->p, d->x, d->dy, add, got, work);
    }
    free_array(packed), lt_release(work);
}

/* Added and afresh, against the sum in double: within 1e-6 of the sum of its terms' sizes, or what Winograd promises */
static void check_gradient(const conv_data *d, const char *what, const char *name, size_t n, pair_fn fn, bool plainly)
{
    double *sum = calloc(n + 1, sizeof(double)), *size = calloc(n + 1, sizeof(double));
    float *start = random_array(n, 9), *got = guarded_array(n);
    plain s = { d, NULL, sum, size, -1 };
    const bool data = fn == pair_data;
    const double bound = (data ? by_winograd(d->p) : lt_winograd_weights_suits(d->p)) ? winograd_bound : 1e-6;

    if (plainly)
        each_pair(d->p, fn, &s);
    for (int add = 0; add < 2; add++) {
        for (size_t i = 0; i < n; i++)
            got[i] = add ? start[i] : NAN;
        run_gradient(d, data, add, got);
        for (size_t i = 0; i < n && plainly; i++) {
            const double from = add ? (double)start[i] : 0;

            expect_near(got[i], from + sum[i], bound * (size[i] + fabs(from)), what, name, i);
        }
        same_as_before(got, n, "%s%s %s", what, add ? "" : ", afresh,", name);
    }
    free(sum), free(size), free_array(start), free_array(got);
}

static void check_bias(const conv_data *d, const char *name)
{
    const lt_conv2d_params *p = d->p;
    const size_t o = (size_t)p->o, out = d->n_y / (size_t)lt_max_i64(1, p->n * p->o);
    float *got = guarded_array(o);
    double *sum = calloc(o, sizeof(double));

    memcpy(got, d->bias, o * sizeof(float));
    for (size_t i = 0; i < d->n_y; i++)
        sum[i / out % o] += d->dy[i];
    lt_conv2d_backward_bias(p, d->dy, got);
    for (size_t i = 0; i < o; i++)
        expect_near(got[i], d->bias[i] + sum[i], 1e-6 * (fabs(sum[i]) + 1), "conv bias", name, i);
    free(sum), free_array(got);
}

static void check_conv(const lt_conv2d_params *p, bool plainly)
{
    const int64_t oh = lt_max_i64(0, lt_conv2d_out_h(p)), ow = lt_max_i64(0, lt_conv2d_out_w(p));
    conv_data d = {
        .p = p, .n_x = (size_t)(p->n * p->c * p->h * p->w), .n_y = (size_t)(p->n * p->o * oh * ow),
        .n_w = (size_t)(p->o * (p->c / p->groups) * p->kh * p->kw),
    };
    char name[160];

    snprintf(name, sizeof(name), "%dx%dx%dx%d -> %d, %dx%d stride %d %d pad %d %d dil %d %d groups %d",
             (int)p->n, (int)p->c, (int)p->h, (int)p->w, (int)p->o, p->kh, p->kw, p->stride_h,
             p->stride_w, p->pad_h, p->pad_w, p->dil_h, p->dil_w, p->groups);
    d.x = random_array(d.n_x, 4), d.w = random_array(d.n_w, 5), d.dy = random_array(d.n_y, 6);
    d.bias = random_array((size_t)p->o, 7), d.residual = random_array(d.n_y, 8);
    check_forward(&d, name, plainly);
    if (d.n_y && lt_conv2d_takes_rect(p))
        check_rects(&d, name);
    if (d.n_y && (lt_conv2d_takes_gate(p) || lt_conv2d_makes_mean(p)))
        check_gate_and_mean(&d, name);
    check_gradient(&d, "conv data gradient", name, d.n_x, pair_data, plainly);
    check_gradient(&d, "conv weight gradient", name, d.n_w, pair_weights, plainly);
    check_bias(&d, name);
    free_array(d.x), free_array(d.w), free_array(d.dy), free_array(d.bias), free_array(d.residual);
}

void check_convs_on_tiles(bool plainly)
{
    for (size_t i = 0; i < LT_COUNT(convs_on_tiles); i++) {
        expect_near(lt_conv2d_algorithm(&convs_on_tiles[i]), LT_CONV_TILES, 0, "algorithm", "conv on tiles", i);
        check_conv(&convs_on_tiles[i], plainly);
    }
}

void check_convs(bool plainly)
{
    for (size_t i = 0; i < LT_COUNT(convs); i++)
        check_conv(&convs[i], plainly);
}
