/* SPDX-License-Identifier: Apache-2.0 */
/* Products of 8-bit integers against plain loops, bit by bit: many shapes, every instruction set, 1 to 4 threads. */
#include "tests/kernels/checkasm.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/int8/int8.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- plain loops ---------------------------------------------------------------------------------------- */

/* x as an integer of r */
static int integer(float x, const lt_int8_range *r)
{
    const float least = r->has_negative ? -127 : 0, most = r->has_negative ? 127 : 255;
    const float v = x * (1.0f / r->scale);

    return (int)nearbyintf(!(v > least) ? least : v < most ? v : most);
}

/* A row of weights as integers, and what one of them is worth */
static float weight_integers(const float *w, int64_t n, int *out)
{
    float most = 0;

    for (int64_t i = 0; i < n; i++)
        most = fmaxf(most, fabsf(w[i]));
    for (int64_t i = 0; i < n; i++)
        out[i] = most > 0 ? (int)nearbyintf(w[i] * (127 / most)) : 0;
    return most / 127;
}

static float activated(float x, lt_act_kind kind)
{
    if (kind == LT_ACT_SILU)
        lt_k->silu(&x, &x, 1);
    return kind == LT_ACT_RELU && x < 0 ? 0 : x;
}

/* ---- convolutions ------------------------------------------------------------------------------------------ */

static const lt_conv2d_params convs[] = {
    /* n  c   h   w   o  kh kw  stride  pad   dil  groups */
    { 1, 16, 1, 1, 1, 1, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 2, 17, 5, 7, 4, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
    { 2, 3, 23, 17, 9, 7, 7, 2, 2, 3, 3, 1, 1, 1 },
    { 1, 18, 23, 17, 9, 7, 7, 2, 2, 3, 3, 1, 1, 1 },
    { 3, 19, 9, 9, 33, 1, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 2, 16, 9, 8, 20, 1, 1, 2, 2, 0, 0, 1, 1, 1 },
    { 1, 22, 11, 13, 9, 3, 2, 1, 2, 2, 0, 2, 1, 1 },
    { 2, 16, 12, 10, 6, 5, 3, 3, 2, 4, 1, 1, 3, 1 },
    { 1, 31, 6, 32, 29, 3, 3, 1, 1, 1, 1, 1, 1, 1 },      /* rows that end with vectors */
    { 1, 24, 9, 64, 15, 3, 3, 2, 2, 1, 1, 1, 1, 1 },
    { 1, 300, 6, 5, 30, 3, 3, 1, 1, 1, 1, 1, 1, 1 },      /* several blocks of k */
    { 2, 1050, 5, 7, 16, 1, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 2, 13, 9, 7, 300, 1, 1, 1, 1, 0, 0, 1, 1, 1 },
    { 1, 40, 8, 8, 300, 1, 1, 1, 1, 0, 0, 1, 1, 1 },      /* maps that tiles of rows share */
    { 2, 33, 40, 33, 70, 3, 3, 1, 1, 1, 1, 1, 1, 1 },
};

typedef struct {
    const lt_conv2d_params *p;
    lt_int8_range r;
    float *x, *w, *bias, *residual, *gate;
    size_t n_y;
    lt_conv2d_around around;
} conv_data;

static int64_t conv_sum(const conv_data *d, const int *w, int64_t n, int64_t row, int64_t col)
{
    const lt_conv2d_params *p = d->p;
    int64_t sum = 0;

    for (int64_t c = 0; c < p->c; c++)
        for (int ky = 0; ky < p->kh; ky++)
            for (int kx = 0; kx < p->kw; kx++) {
                const int64_t y = row * p->stride_h + ky * p->dil_h - p->pad_h;
                const int64_t x = col * p->stride_w + kx * p->dil_w - p->pad_w;
                const float gate = d->around.gate ? d->gate[n * p->c + c] : 1;

                if (y >= 0 && y < p->h && x >= 0 && x < p->w)
                    sum += w[(c * p->kh + ky) * p->kw + kx]
                        * integer(d->x[((n * p->c + c) * p->h + y) * p->w + x] * gate, &d->r);
            }
    return sum;
}

static void plain_conv(const conv_data *d, float *y)
{
    const lt_conv2d_params *p = d->p;
    const int64_t h = lt_conv2d_out_h(p), w = lt_conv2d_out_w(p), k = p->c * p->kh * p->kw;
    int *q = calloc((size_t)k, sizeof(*q));

    for (int64_t o = 0; o < p->o; o++) {
        const float scale = weight_integers(d->w + o * k, k, q) * d->r.scale;

        for (int64_t i = 0; i < p->n * h * w; i++) {
            const int64_t at = (i / (h * w) * p->o + o) * h * w + i % (h * w);
            float v = (float)conv_sum(d, q, i / (h * w), i / w % h, i % w) * scale;

            v = d->around.bias ? v + d->bias[o] : v;
            v = d->around.residual ? v + d->residual[at] : v;
            y[at] = activated(v, d->around.act.kind);
        }
    }
    free(q);
}

static void check_conv(const conv_data *d, const char *name, bool plainly)
{
    const lt_conv2d_params *p = d->p;
    float *want = guarded_array(d->n_y), *got = guarded_array(d->n_y);
    float *packed = guarded_array((size_t)lt_conv2d_int8_packed(p));
    void *pack_work = lt_alloc(lt_conv2d_int8_pack_work(p)), *work = lt_alloc(lt_conv2d_int8_work(p));

    lt_conv2d_int8_pack(p, &d->r, d->w, packed, pack_work);
    lt_conv2d_int8_forward(p, &d->r, d->x, packed, &d->around, got, work);
    if (plainly) {
        plain_conv(d, want);
        expect_bits(got, want, d->n_y, "%s", name);
    }
    same_as_before(got, d->n_y, "%s", name);
    free_array(want), free_array(got), free_array(packed), lt_release(pack_work), lt_release(work);
}

/* A part of the first image: what is computed is as in the whole, and the rest stays. */
static void check_rect(const conv_data *d, const char *name)
{
    const lt_conv2d_params *p = d->p;
    const int64_t h = lt_conv2d_out_h(p), w = lt_conv2d_out_w(p), n = p->o * h * w;
    const lt_rect r = { h / 3, h - h / 4, w / 4, w - w / 5 };
    lt_conv2d_params one = *p;
    float *want = guarded_array((size_t)n), *got = zero_array((size_t)n);
    float *packed = guarded_array((size_t)lt_conv2d_int8_packed(p));
    void *pack_work = lt_alloc(lt_conv2d_int8_pack_work(p)), *work = lt_alloc(lt_conv2d_int8_rect_work(p));
    void *whole_work = lt_alloc(lt_conv2d_int8_work(p));

    one.n = 1;
    lt_conv2d_int8_pack(&one, &d->r, d->w, packed, pack_work);
    lt_conv2d_int8_forward(&one, &d->r, d->x, packed, &d->around, want, whole_work);
    lt_conv2d_int8_forward_rect(&one, &d->r, r, d->x, packed, d->around.bias, d->around.residual, d->around.act, got,
                                work);
    for (int64_t i = 0; i < n; i++)
        if (i / w % h < r.y0 || i / w % h >= r.y1 || i % w < r.x0 || i % w >= r.x1)
            want[i] = 0;
    expect_bits(got, want, (size_t)n, "%s, a part of it", name);
    free_array(want), free_array(got), free_array(packed);
    lt_release(pack_work), lt_release(work), lt_release(whole_work);
}

static void check_conv_ways(const lt_conv2d_params *p, size_t i, bool plainly)
{
    const int64_t h = lt_conv2d_out_h(p), w = lt_conv2d_out_w(p);
    conv_data d = { .p = p, .n_y = (size_t)(p->n * p->o * h * w) };
    char name[80];

    d.x = random_array((size_t)(p->n * p->c * p->h * p->w), 1);
    d.w = random_array((size_t)(p->o * p->c * p->kh * p->kw), 2);
    d.bias = random_array((size_t)p->o, 3), d.residual = random_array(d.n_y, 4);
    d.gate = random_array((size_t)(p->n * p->c), 5);
    for (int way = 0; way < 4; way++) {
        const bool all = way & 1;

        d.r = (lt_int8_range){ way & 2 ? 0.0071f : 0.0033f, (way & 2) != 0 };  /* some of x is cut off */
        d.around = (lt_conv2d_around){
            .bias = all ? d.bias : NULL, .residual = all ? d.residual : NULL,
            .act = { all ? i % 2 ? LT_ACT_SILU : LT_ACT_RELU : LT_ACT_NONE, 0 },
            .gate = all && lt_conv2d_takes_gate(p) ? d.gate : NULL,
        };
        snprintf(name, sizeof(name), "int8 convolution %zu, sign %d, around %d", i, way >> 1, all);
        check_conv(&d, name, plainly);
        d.around.gate = NULL;
        if (lt_conv2d_int8_takes_rect(p))
            check_rect(&d, name);
    }
    free_array(d.x), free_array(d.w), free_array(d.bias), free_array(d.residual), free_array(d.gate);
}

/* ---- products ------------------------------------------------------------------------------------------------- */

typedef struct { int64_t m, n, k; } gemm_case;

static const gemm_case gemms[] = {
    { 1, 1, 16 }, { 3, 5, 17 }, { 14, 32, 64 }, { 15, 33, 67 }, { 13, 31, 1030 }, { 1, 100, 300 }, { 100, 1, 300 },
    { 67, 129, 2051 }, { 300, 70, 40 }, { 29, 47, 4096 }, { 31, 400, 22 },
};

static void plain_gemm(const gemm_case *g, const lt_int8_range *r, const float *a, const float *w, const lt_epilogue *e,
                       float *c)
{
    int *q = calloc((size_t)g->k, sizeof(*q));

    for (int64_t j = 0; j < g->n; j++) {
        const float scale = weight_integers(w + j * g->k, g->k, q) * r->scale;

        for (int64_t i = 0; i < g->m; i++) {
            int64_t sum = 0;
            float v;

            for (int64_t l = 0; l < g->k; l++)
                sum += q[l] * integer(a[i * g->k + l], r);
            v = (float)sum * scale;
            v = e->col_bias ? v + e->col_bias[j] : v;
            v = e->residual ? v + e->residual[i * g->n + j] : v;
            c[i * g->n + j] = activated(v, e->act.kind);
        }
    }
    free(q);
}

static void check_gemm(const gemm_case *g, bool has_negative, bool all, bool plainly)
{
    const lt_int8_range r = { has_negative ? 0.0071f : 0.0033f, has_negative };
    const size_t size = (size_t)(g->m * g->n);
    float *a = random_array((size_t)(g->m * g->k), 1), *w = random_array((size_t)(g->k * g->n), 2);
    float *bias = random_array((size_t)g->n, 3), *residual = random_array(size, 4);
    float *want = guarded_array(size), *got = guarded_array(size);
    float *packed = guarded_array((size_t)lt_gemm_int8_packed(g->n, g->k));
    void *pack_work = lt_alloc(lt_gemm_int8_pack_work(g->n, g->k)), *work = lt_alloc(lt_gemm_int8_work(g->m, g->k));
    const lt_epilogue e = {
        .col_bias = all ? bias : NULL, .residual = all ? residual : NULL, .ld_residual = g->n,
        .act = { all ? LT_ACT_SILU : LT_ACT_NONE, 0 },
    };
    char name[80];

    snprintf(name, sizeof(name), "int8 product %dx%dx%d, sign %d, around %d", (int)g->m, (int)g->n, (int)g->k,
             has_negative, all);
    lt_gemm_int8_pack(g->n, g->k, &r, w, packed, pack_work);
    lt_gemm_int8(g->m, g->n, g->k, &r, a, packed, &e, got, work);
    if (plainly) {
        plain_gemm(g, &r, a, w, &e, want);
        expect_bits(got, want, size, "%s", name);
    }
    same_as_before(got, size, "%s", name);
    free_array(a), free_array(w), free_array(bias), free_array(residual), free_array(want), free_array(got);
    free_array(packed), lt_release(pack_work), lt_release(work);
}

void check_int8(bool plainly)
{
    for (size_t i = 0; i < LT_COUNT(convs); i++)
        check_conv_ways(&convs[i], i, plainly);
    for (size_t i = 0; i < LT_COUNT(gemms); i++)
        for (int way = 0; way < 4; way++)
            check_gemm(&gemms[i], way & 1, way & 2, plainly);
}
