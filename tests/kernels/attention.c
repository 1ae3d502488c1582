/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Attention's entries against the generic ones, bit by bit: from packing to gradients, for heads, panels and
 * strips that are full, nearly empty and cut.
 */
#include "tests/kernels/checkasm.h"

#include "libtensor/base/rng.h"

#include <math.h>
#include <string.h>

enum { QUERIES = LT_ATTEND_QUERIES, KEYS = LT_ATTEND_KEYS };

/* Queries of a head. Rows of q, k, v, y and of all gradients are ld apart; the packed ones have no gaps. */
typedef struct {
    int64_t rows, keys, d, ld;
    float *q, *k, *v, *dy;                              /* read */
    float *q_panel, *dy_panel, *k_panels, *v_panels, *v_rows;
    float *y, *stats, *mean, *dq, *dk, *dv;             /* written */
} head;

static size_t rows_of(const head *h, int64_t n)
{
    return (size_t)((n - 1) * h->ld + h->d);            /* no gap behind the last */
}

static float *numbers(size_t n, uint64_t stream, float trip)
{
    lt_rng r = lt_rng_make(11, stream);
    float *a = guarded_array(n);

    for (size_t i = 0; i < n; i++)
        a[i] = (float)lt_rng_normal(&r);
    if (n && trip != 0)
        a[lt_rng_below(&r, (uint32_t)n)] = trip;
    return a;
}

/* Of rows in panels */
static size_t query_elements(int64_t rows, int64_t d)
{
    return (size_t)(lt_ceil_div(rows, QUERIES) * QUERIES * d);
}

static head new_head(int64_t rows, int64_t keys, int64_t d, float trip)
{
    const size_t panels = (size_t)(lt_ceil_div(keys, KEYS) * KEYS * d), queries = query_elements(rows, d);
    head h = { .rows = rows, .keys = keys, .d = d, .ld = d + 3 };

    h.q = numbers(rows_of(&h, rows), 1, trip), h.dy = numbers(rows_of(&h, rows), 2, 0);
    h.k = numbers(rows_of(&h, keys), 3, 0), h.v = numbers(rows_of(&h, keys), 4, 0);
    h.q_panel = guarded_array(queries), h.dy_panel = guarded_array(queries);
    h.k_panels = guarded_array(panels), h.v_panels = guarded_array(panels);
    h.v_rows = guarded_array((size_t)(keys * d));
    h.y = numbers(rows_of(&h, rows), 5, 0), h.stats = guarded_array((size_t)(2 * rows));
    h.mean = numbers((size_t)rows, 6, 0), h.dq = numbers(rows_of(&h, rows), 7, 0);
    h.dk = numbers(rows_of(&h, keys), 8, 0), h.dv = numbers(rows_of(&h, keys), 9, 0);
    return h;
}

static void free_head(head *h)
{
    float *const all[] = { h->q, h->k, h->v, h->dy, h->q_panel, h->dy_panel, h->k_panels, h->v_panels,
                           h->v_rows, h->y, h->stats, h->mean, h->dq, h->dk, h->dv };

    for (size_t i = 0; i < LT_COUNT(all); i++)
        free_array(all[i]);
}

/* The panels of queries from row t on, and some keys at a time */
static void run_gradients(const lt_kernels *k, head *h, int64_t t, float scale)
{
    for (int64_t j = 0; j < h->keys; j += LT_ATTEND_GRAD_KEYS) {
        const lt_attend_grad g = {
            .d = h->d, .ld = h->ld, .rows = lt_min_i64(LT_ATTEND_PANELS * QUERIES, h->rows - t),
            .keys = lt_min_i64(LT_ATTEND_GRAD_KEYS, h->keys - j),
            .q_panel = h->q_panel + t * h->d, .dy_panel = h->dy_panel + t * h->d, .k_panels = h->k_panels + j * h->d,
            .v_panels = h->v_panels + j * h->d, .q = h->q + t * h->ld, .k = h->k + j * h->ld, .dy = h->dy + t * h->ld,
            .stats = h->stats + 2 * t, .mean = h->mean + t, .scale = scale, .dq = h->dq + t * h->ld,
            .dk = h->dk + j * h->ld, .dv = h->dv + j * h->ld,
        };

        k->attend_grad(&g);
    }
}

static void run(const lt_kernels *k, head *h)
{
    const float scale = 1 / sqrtf((float)h->d);

    k->attend_pack(h->q_panel, h->q, h->ld, h->rows, h->d, QUERIES, scale * 1.44269504f);
    k->attend_pack(h->dy_panel, h->dy, h->ld, h->rows, h->d, QUERIES, 1);
    k->attend_pack(h->k_panels, h->k, h->ld, h->keys, h->d, KEYS, 1);
    k->attend_pack(h->v_panels, h->v, h->ld, h->keys, h->d, KEYS, 1);
    for (int64_t j = 0; j < h->keys; j++)
        memcpy(h->v_rows + j * h->d, h->v + j * h->ld, (size_t)h->d * sizeof(float));
    k->attend(h->y, h->ld, h->stats, h->q_panel, h->k_panels, h->v_rows, h->rows, h->keys, h->d);
    for (int64_t t = 0; t < h->rows; t += LT_ATTEND_PANELS * QUERIES)
        run_gradients(k, h, t, scale);
}

/* The weights of row i in double, and what they make of v. */
static void check_plainly(const head *h, int64_t i)
{
    double weight[1024], top = -INFINITY, sum = 0;

    for (int64_t j = 0; j < h->keys; j++) {
        double z = 0;

        for (int64_t l = 0; l < h->d; l++)
            z += (double)h->q[i * h->ld + l] * (double)h->k[j * h->ld + l];
        weight[j] = z / sqrt((double)h->d);
        top = fmax(top, weight[j]);
    }
    for (int64_t j = 0; j < h->keys; j++)
        sum += weight[j] = exp(weight[j] - top);
    for (int64_t l = 0; l < h->d; l++) {
        double y = 0;

        for (int64_t j = 0; j < h->keys; j++)
            y += weight[j] / sum * (double)h->v[j * h->ld + l];
        expect_near((double)h->y[i * h->ld + l], y, 2e-6, "attend", "channel", (size_t)l);
    }
}

static void check_head(const lt_kernels *k, const lt_kernels *generic, int64_t rows, int64_t keys, int64_t d,
                       float trip)
{
    head want = new_head(rows, keys, d, trip), got = new_head(rows, keys, d, trip);
    const size_t panels = (size_t)(lt_ceil_div(keys, KEYS) * KEYS * d);

    run(generic, &want);
    run(k, &got);
#define SAME(what, n) expect_bits(got.what, want.what, n, "attention " #what ", %d rows, %d keys, d %d, %g", \
                                  (int)rows, (int)keys, (int)d, (double)trip)
    SAME(q_panel, query_elements(rows, d)), SAME(dy_panel, query_elements(rows, d));
    SAME(k_panels, panels), SAME(v_panels, panels);
    SAME(y, rows_of(&want, rows)), SAME(stats, (size_t)(2 * rows));
    SAME(dq, rows_of(&want, rows)), SAME(dk, rows_of(&want, keys)), SAME(dv, rows_of(&want, keys));
    for (int64_t i = 0; i < rows && trip == 0; i++)
        check_plainly(&got, i);
    free_head(&want), free_head(&got);
}

/* A row's result is NaN when a score is NaN or +inf, and when all are -inf; -inf among others weighs nothing. */
static void check_infinities(const lt_kernels *k)
{
    static const float first[] = { NAN, INFINITY, -INFINITY, -INFINITY }, other[] = { 1, 1, -INFINITY, 1 };
    static const float want[] = { NAN, NAN, NAN, 1 };
    const int64_t n = 300 + 256;
    float *keys = guarded_array((size_t)n), *values = guarded_array((size_t)n);
    float *panels = guarded_array((size_t)(lt_ceil_div(n, KEYS) * KEYS)), *y = guarded_array(1);
    float *q = zero_array(QUERIES);

    q[0] = 1;
    for (size_t c = 0; c < LT_COUNT(first); c++) {
        for (int64_t j = 0; j < n; j++) {               /* a strip and a bit, then others */
            keys[j] = j < 300 ? first[c] : other[c];
            values[j] = j < 300 ? 7 : 1;
        }
        k->attend_pack(panels, keys, 1, n, 1, KEYS, 1);
        k->attend(y, 1, NULL, q, panels, values, 1, n, 1);
        expect_bits(y, &want[c], 1, "attention with scores of %g and %g", (double)first[c], (double)other[c]);
    }
    free_array(keys), free_array(values), free_array(panels), free_array(y), free_array(q);
}

void check_attention(const lt_kernels *k, const lt_kernels *generic)
{
    static const int64_t rows[] = { 1, 5, 11, 12, 13, LT_ATTEND_PANELS * QUERIES };
    static const int64_t keys[] = { 1, 31, 32, 33, 96, 97, 256, 257, 300, 520 };
    static const int64_t d[] = { 1, 6, 16, 17, 32, 40, 64 };
    static const float trip[] = { NAN, INFINITY, -INFINITY, 1e30f, 1e-40f };

    for (size_t a = 0; a < LT_COUNT(rows); a++)
        for (size_t b = 0; b < LT_COUNT(keys); b++)
            for (size_t c = 0; c < LT_COUNT(d); c++)
                check_head(k, generic, rows[a], keys[b], d[c], 0);
    for (size_t i = 0; i < LT_COUNT(trip); i++)
        check_head(k, generic, 7, 300, 20, trip[i]);
    check_infinities(k);
}
