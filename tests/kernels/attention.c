/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Attention's entries against the generic ones, bit by bit, with LT_ISA_AMX within the bound that kernels.h states:
 * from packing to gradients, for heads, panels and strips that are full, nearly empty and cut.
 */
#include "tests/kernels/checkasm.h"

#include "libtensor/base/rng.h"

#include <math.h>
#include <string.h>

enum { PARTS = LT_ATTEND_DY + 1, MOST_KEYS = 2100 };

/* Queries of a head. Rows of q, k, v, y and of all gradients are ld apart. */
typedef struct {
    int64_t rows, keys, d, ld;
    float *q, *k, *v, *dy;                              /* read */
    float *packed[PARTS], *grad_packed[PARTS];
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

/* How many rows a part has, and which */
static int64_t count_of(const head *h, int part)
{
    return part == LT_ATTEND_Q || part == LT_ATTEND_DY ? h->rows : h->keys;
}

static const float *rows_to_pack(const head *h, int part)
{
    return part == LT_ATTEND_Q ? h->q : part == LT_ATTEND_K ? h->k : part == LT_ATTEND_V ? h->v : h->dy;
}

static head new_head(const lt_attention_kernels *a, int64_t rows, int64_t keys, int64_t d, float trip)
{
    head h = { .rows = rows, .keys = keys, .d = d, .ld = d + 3 };

    h.q = numbers(rows_of(&h, rows), 1, trip), h.dy = numbers(rows_of(&h, rows), 2, 0);
    h.k = numbers(rows_of(&h, keys), 3, 0), h.v = numbers(rows_of(&h, keys), 4, 0);
    for (lt_attend_part part = LT_ATTEND_Q; part <= LT_ATTEND_DY; part++) {
        h.packed[part] = guarded_array((size_t)a->packing.packed(part, count_of(&h, part), d));
        h.grad_packed[part] = guarded_array((size_t)a->grad_packing.packed(part, count_of(&h, part), d));
    }
    h.y = numbers(rows_of(&h, rows), 5, 0), h.stats = guarded_array((size_t)(2 * rows));
    h.mean = numbers((size_t)rows, 6, 0), h.dq = numbers(rows_of(&h, rows), 7, 0);
    h.dk = numbers(rows_of(&h, keys), 8, 0), h.dv = numbers(rows_of(&h, keys), 9, 0);
    return h;
}

static void free_head(head *h)
{
    float *const all[] = { h->q, h->k, h->v, h->dy, h->y, h->stats, h->mean, h->dq, h->dk, h->dv };

    for (size_t i = 0; i < LT_COUNT(all); i++)
        free_array(all[i]);
    for (int part = 0; part < PARTS; part++)
        free_array(h->packed[part]), free_array(h->grad_packed[part]);
}

/* Some queries from row t on, and all keys, some at a time */
static void run_gradients(const lt_attention_kernels *a, head *h, int64_t t, float scale)
{
    const lt_attend_packing *p = &a->grad_packing;

    for (int64_t j = 0; j < h->keys; j += p->keys) {
        const lt_attend_grad g = {
            .d = h->d, .ld = h->ld, .rows = lt_min_i64(p->queries, h->rows - t),
            .keys = lt_min_i64(p->keys, h->keys - j),
            .packed_q = h->grad_packed[LT_ATTEND_Q] + p->packed(LT_ATTEND_Q, t, h->d),
            .packed_dy = h->grad_packed[LT_ATTEND_DY] + p->packed(LT_ATTEND_DY, t, h->d),
            .packed_k = h->grad_packed[LT_ATTEND_K] + p->packed(LT_ATTEND_K, j, h->d),
            .packed_v = h->grad_packed[LT_ATTEND_V] + p->packed(LT_ATTEND_V, j, h->d),
            .q = h->q + t * h->ld, .k = h->k + j * h->ld, .dy = h->dy + t * h->ld,
            .stats = h->stats + 2 * t, .mean = h->mean + t, .scale = scale, .dq = h->dq + t * h->ld,
            .dk = h->dk + j * h->ld, .dv = h->dv + j * h->ld,
        };

        a->attend_grad(&g);
    }
}

static void run(const lt_attention_kernels *a, head *h)
{
    const lt_attend_packing *p = &a->packing;
    const float scale = 1 / sqrtf((float)h->d);

    for (lt_attend_part part = LT_ATTEND_Q; part <= LT_ATTEND_DY; part++) {
        const float s = part == LT_ATTEND_Q ? scale * 1.44269504f : 1, *x = rows_to_pack(h, part);

        p->pack(part, h->packed[part], x, h->ld, count_of(h, part), h->d, s);
        a->grad_packing.pack(part, h->grad_packed[part], x, h->ld, count_of(h, part), h->d, s);
    }
    for (int64_t t = 0; t < h->rows; t += p->queries)
        a->attend(h->y + t * h->ld, h->ld, h->stats + 2 * t, h->packed[LT_ATTEND_Q] + p->packed(LT_ATTEND_Q, t, h->d),
                  h->packed[LT_ATTEND_K], h->packed[LT_ATTEND_V], lt_min_i64(p->queries, h->rows - t), h->keys, h->d);
    for (int64_t t = 0; t < h->rows; t += a->grad_packing.queries)
        run_gradients(a, h, t, scale);
}

/* The weights of row i in double, and what they make of v. */
static void check_plainly(const head *h, int64_t i)
{
    double weight[MOST_KEYS], top = -INFINITY, sum = 0;

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

/* Rows of d with gaps that nobody may touch: the same bits, or where there is a bound within it. */
static void expect_rows(const float *got, const float *want, int64_t rows, int64_t d, int64_t ld,
                        double bound, const char *what, const char *name)
{
    const int64_t n = (rows - 1) * ld + d;

    if (bound == 0) {
        expect_bits(got, want, (size_t)n, "attention, %s, %s", what, name);
        return;
    }
    for (int64_t i = 0; i < n; i++)
        if (i % ld >= d || !isfinite(want[i]) || !isfinite(got[i]))
            expect_bits(&got[i], &want[i], 1, "attention, %s, %s, element %lld", what, name, (long long)i);
        else
            expect_near((double)got[i], (double)want[i], bound * fmax(1, fabs((double)want[i])), what, name, (size_t)i);
}

/* scale: of the bounds, 0 or 1 */
static void check_head(const lt_attention_kernels *a, const lt_attention_kernels *generic, double scale, int64_t rows,
                       int64_t keys, int64_t d, float trip)
{
    head want = new_head(generic, rows, keys, d, trip), got = new_head(a, rows, keys, d, trip);
    char name[96];

    snprintf(name, sizeof(name), "%d rows, %d keys, d %d, %g", (int)rows, (int)keys, (int)d, (double)trip);
    run(generic, &want);
    run(a, &got);
    expect_rows(got.y, want.y, rows, d, want.ld, scale * 2e-6, "y", name);
    expect_rows(got.stats, want.stats, rows, 2, 2, scale * 4e-6, "stats", name);
    expect_rows(got.dq, want.dq, rows, d, want.ld, scale * 1e-5, "dq", name);
    expect_rows(got.dk, want.dk, keys, d, want.ld, scale * 1e-5, "dk", name);
    expect_rows(got.dv, want.dv, keys, d, want.ld, scale * 1e-5, "dv", name);
    for (int64_t i = 0; i < rows && trip == 0; i++)
        check_plainly(&got, i);
    free_head(&want), free_head(&got);
}

/* A row's result is NaN when a score is NaN or +inf, and when all are -inf; -inf among others weighs nothing. */
static void check_infinities(const lt_attention_kernels *a)
{
    static const float first[] = { NAN, INFINITY, -INFINITY, -INFINITY }, other[] = { 1, 1, -INFINITY, 1 };
    static const float want[] = { NAN, NAN, NAN, 1 };
    const int64_t n = 300 + 256;
    float *keys = guarded_array((size_t)n), *values = guarded_array((size_t)n), *y = guarded_array(1);
    float *packed_k = guarded_array((size_t)a->packing.packed(LT_ATTEND_K, n, 1));
    float *packed_v = guarded_array((size_t)a->packing.packed(LT_ATTEND_V, n, 1));
    float *packed_q = guarded_array((size_t)a->packing.packed(LT_ATTEND_Q, 1, 1));

    a->packing.pack(LT_ATTEND_Q, packed_q, &(float){ 1 }, 1, 1, 1, 1);
    for (size_t c = 0; c < LT_COUNT(first); c++) {
        for (int64_t j = 0; j < n; j++) {               /* a strip and a bit, then others */
            keys[j] = j < 300 ? first[c] : other[c];
            values[j] = j < 300 ? 7 : 1;
        }
        a->packing.pack(LT_ATTEND_K, packed_k, keys, 1, n, 1, 1);
        a->packing.pack(LT_ATTEND_V, packed_v, values, 1, n, 1, 1);
        a->attend(y, 1, NULL, packed_q, packed_k, packed_v, 1, n, 1);
        expect_bits(y, &want[c], 1, "attention with scores of %g and %g", (double)first[c], (double)other[c]);
    }
    free_array(keys), free_array(values), free_array(y);
    free_array(packed_q), free_array(packed_k), free_array(packed_v);
}

static void check_kernels(const lt_attention_kernels *k, const lt_attention_kernels *generic, double scale)
{
    static const int64_t rows[] = { 1, 5, 11, 12, 13, 33, 48, 96, 110 };
    static const int64_t keys[] = { 1, 31, 32, 33, 96, 97, 256, 257, 300, 520 };
    static const int64_t d[] = { 1, 6, 16, 17, 32, 40, 64 };
    static const float trip[] = { NAN, INFINITY, -INFINITY, 1e30f, 1e-40f };

    for (size_t a = 0; a < LT_COUNT(rows); a++)
        for (size_t b = 0; b < LT_COUNT(keys); b++)
            for (size_t c = 0; c < LT_COUNT(d); c++)
                check_head(k, generic, scale, rows[a], keys[b], d[c], 0);
    check_head(k, generic, scale, 40, 1100, 20, 0);
    check_head(k, generic, scale, 3, MOST_KEYS, 300, 0);
    for (size_t i = 0; i < LT_COUNT(trip); i++)
        check_head(k, generic, scale, 7, 300, 20, trip[i]);
    check_infinities(k);
}

/* Kernels of narrow and of wide heads, each with heads of all widths; AMX's of wide ones alone may differ in bits. */
void check_attention(const lt_kernels *k, const lt_kernels *generic)
{
    check_kernels(&k->attention[0], &generic->attention[0], 0);
    check_kernels(&k->attention[1], &generic->attention[1], k->isa == LT_ISA_AMX);
}
