/* SPDX-License-Identifier: Apache-2.0 */
/* Products of rows on AMX's tiles against sums in double: sizes that end within tiles, tasks and blocks of terms. */
#include "tests/kernels/checkasm.h"

#include "libtensor/kernels/gemm/tiles.h"

#include <math.h>
#include <string.h>

typedef struct { int64_t m, n, k; } tiles_case;

static const tiles_case cases[] = {
    { 64, 64, 64 }, { 65, 97, 70 }, { 128, 256, 32 * 11 }, { 130, 300, 330 }, { 70, 1030, 65 }, { 300, 66, 700 },
    { 1000, 64, 129 }, { 257, 513, 161 }, { 5, 300, 145 },
};

/* What C should be, without what follows: term l of (i, j) is a[i * ai + l * al] b[j * bj + l * bl] */
typedef struct { const float *a, *b; int64_t ai, al, bj, bl; } factors;

static void expect_sums(const tiles_case *t, const factors *f, const float *before, const float *after,
                        const float *got, const char *name)
{
    for (int64_t i = 0; i < t->m * t->n; i++) {
        double sum = before ? (double)before[i] : 0, size = fabs(sum);

        for (int64_t l = 0; l < t->k; l++) {
            const double term = (double)f->a[i / t->n * f->ai + l * f->al] * (double)f->b[i % t->n * f->bj + l * f->bl];

            sum += term, size += fabs(term);
        }
        if (after) {
            sum = fmax(0, sum + (double)after[i % t->n] + (double)after[t->n + i]);
            size += fabs((double)after[i % t->n]) + fabs((double)after[t->n + i]);
        }
        expect_near(got[i], sum, 1e-6 * size, "tiles", name, (size_t)i);
    }
}

/* Rows of matrices in the middle of wider ones */
enum { APART = 5 };

static void copy_rows(float *out, int64_t ld_out, const float *x, int64_t ld, int64_t rows, int64_t columns)
{
    for (int64_t i = 0; i < rows; i++)
        memcpy(out + i * ld_out, x + i * ld, (size_t)columns * sizeof(*out));
}

/* lt_gemm_tiles with such rows: c before, and after. Between them nothing is written. */
static void multiply_apart(const tiles_case *t, const float *a, const float *packed, bool add, float *c,
                           const lt_epilogue *e)
{
    const int64_t lda = t->k + APART, ldc = t->n + APART;
    float *wide_a = random_array((size_t)(t->m * lda), 5), *wide_c = guarded_array((size_t)(t->m * ldc));

    for (int64_t i = 0; i < t->m * ldc; i++)
        wide_c[i] = 7;
    copy_rows(wide_a, lda, a, t->k, t->m, t->k);
    copy_rows(wide_c, ldc, c, t->n, t->m, t->n);
    lt_gemm_tiles(t->m, t->n, t->k, wide_a, lda, packed, add, wide_c, ldc, e);
    copy_rows(c, t->n, wide_c, ldc, t->m, t->n);
    for (int64_t i = 0; i < t->m * ldc; i++)
        if (i % ldc >= t->n)
            expect_near(wide_c[i], 7, 0, "tiles", "what lies between rows", (size_t)i);
    free_array(wide_a), free_array(wide_c);
}

static void check_product(const tiles_case *t, lt_trans tb, bool add, bool follow, bool plainly)
{
    const size_t size = (size_t)(t->m * t->n);
    float *a = random_array((size_t)(t->m * t->k), 1), *b = random_array((size_t)(t->n * t->k), 2);
    float *before = random_array(size, 3), *after = random_array((size_t)t->n + size, 4), *got = guarded_array(size);
    float *packed = guarded_array((size_t)lt_gemm_tiles_packed(t->n, t->k));
    const factors f = { a, b, t->k, 1, tb ? t->k : 1, tb ? 1 : t->n };
    const lt_epilogue e = {
        .col_bias = after, .residual = after + t->n, .ld_residual = t->n, .act = { LT_ACT_RELU, 0 },
    };
    char name[80];

    snprintf(name, sizeof(name), "%dx%dx%d trans %d add %d follow %d", (int)t->m, (int)t->n, (int)t->k, tb, add,
             follow);
    memcpy(got, before, size * sizeof(float));
    lt_gemm_tiles_pack(tb, t->n, t->k, b, tb ? t->k : t->n, packed);
    multiply_apart(t, a, packed, add, got, follow ? &e : NULL);
    same_as_before(got, size, "tiles %s", name);
    if (plainly)
        expect_sums(t, &f, add ? before : NULL, follow ? after : NULL, got, name);
    free_array(a), free_array(b), free_array(before), free_array(after), free_array(got), free_array(packed);
}

static void check_sums(const tiles_case *t, bool add, bool plainly)
{
    const size_t size = (size_t)(t->m * t->n);
    float *a = random_array((size_t)(t->m * t->k), 1), *b = random_array((size_t)(t->n * t->k), 2);
    float *before = random_array(size, 3), *got = guarded_array(size);
    const factors f = { a, b, 1, t->m, 1, t->n };
    void *work = lt_alloc(lt_gemm_tiles_sums_work(t->m, t->n, t->k));
    char name[80];

    snprintf(name, sizeof(name), "sums %dx%dx%d add %d", (int)t->m, (int)t->n, (int)t->k, add);
    memcpy(got, before, size * sizeof(float));
    lt_gemm_tiles_sums(t->m, t->n, t->k, a, b, add, got, work);
    same_as_before(got, size, "tiles %s", name);
    if (plainly)
        expect_sums(t, &f, add ? before : NULL, NULL, got, name);
    free_array(a), free_array(b), free_array(before), free_array(got), lt_release(work);
}

/* A pair gives what its two products give: bands, columns and terms that end within tiles, and a middle in parts. */
static void check_pair(int64_t m, int64_t k, int64_t hidden, int64_t n)
{
    const size_t size = (size_t)(m * n);
    float *a = random_array((size_t)(m * k), 1), *w1 = random_array((size_t)(hidden * k), 2);
    float *w2 = random_array((size_t)(n * hidden), 3), *beside = random_array((size_t)(hidden + n) + size, 4);
    float *packed1 = guarded_array((size_t)lt_gemm_tiles_packed(hidden, k)), *got = guarded_array(size);
    float *packed2 = guarded_array((size_t)lt_gemm_tiles_packed(n, hidden)), *want = guarded_array(size);
    float *middle = guarded_array((size_t)(m * hidden));
    const lt_epilogue e1 = { .col_bias = beside, .act = { LT_ACT_GELU, 0 } };
    const lt_epilogue e2 = { .col_bias = beside + hidden, .residual = beside + hidden + n, .ld_residual = n };

    expect_near(lt_gemm_tiles_pair_suits(m, k, hidden, n), true, 0, "tiles", "a pair that suits", 0);
    lt_gemm_tiles_pack(LT_TRANS, hidden, k, w1, k, packed1);
    lt_gemm_tiles_pack(LT_TRANS, n, hidden, w2, hidden, packed2);
    lt_gemm_tiles(m, hidden, k, a, k, packed1, false, middle, hidden, &e1);
    lt_gemm_tiles(m, n, hidden, middle, hidden, packed2, false, want, n, &e2);
    lt_gemm_tiles_pair(m, k, a, hidden, packed1, &e1, n, packed2, &e2, got);
    expect_bits(got, want, size, "tiles, pair %dx%dx%dx%d", (int)m, (int)k, (int)hidden, (int)n);
    free_array(a), free_array(w1), free_array(w2), free_array(beside), free_array(middle);
    free_array(packed1), free_array(packed2), free_array(got), free_array(want);
}

/* What is not a number stays in its row, and an infinity becomes one. */
static void check_not_finite(void)
{
    const tiles_case t = { 64, 64, 64 };
    float *a = random_array((size_t)(t.m * t.k), 1), *b = random_array((size_t)(t.n * t.k), 2);
    float *packed = guarded_array((size_t)lt_gemm_tiles_packed(t.n, t.k)), *got = guarded_array((size_t)(t.m * t.n));

    a[3 * t.k + 5] = NAN;
    a[7 * t.k + 9] = INFINITY;
    lt_gemm_tiles_pack(LT_TRANS, t.n, t.k, b, t.k, packed);
    lt_gemm_tiles(t.m, t.n, t.k, a, t.k, packed, false, got, t.n, NULL);
    for (int64_t i = 0; i < t.m * t.n; i++)
        expect_near(isnan(got[i]), i / t.n == 3 || i / t.n == 7, 0, "tiles", "a NaN and an infinity", (size_t)i);
    free_array(a), free_array(b), free_array(packed), free_array(got);
}

void check_tiles(bool plainly)
{
    check_not_finite();
    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        for (int how = 0; how < 8; how++)
            check_product(&cases[i], how & 1 ? LT_TRANS : LT_NO_TRANS, how & 2, how & 4, plainly);
        check_sums(&cases[i], false, plainly);
        check_sums(&cases[i], true, plainly);
    }
    check_pair(1024, 256, 1024, 256);
    check_pair(300, 130, 160, 401);
    check_pair(65, 65, 96, 64);
}
