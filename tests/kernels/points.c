/* SPDX-License-Identifier: Apache-2.0 */
/* Points, maxima of rows, hash grids and links of rows against the generic entries, bit by bit, and the former against
 * plain loops: points at equal distances, missing ones, rows with a NaN, places outside. */
#include "tests/kernels/checkasm.h"

#include <math.h>
#include <string.h>

enum { MOST = 7 * LT_POINTS, ROOM = 20 };

/* n of them on a lattice, so that many are equally far; the third is none */
static float *lattice(int n, int64_t ld)
{
    float *x = random_array((size_t)(3 * ld), 4);

    for (int64_t i = 0; i < 3 * ld; i++)
        x[i] = i % ld < n && i % ld != 2 ? roundf(3 * x[i]) / 3 : NAN;
    return x;
}

static double square(const float *x, int64_t ld, int64_t i, const float p[3])
{
    const double d[3] = { (double)x[i] - (double)p[0], (double)x[ld + i] - (double)p[1],
                          (double)x[2 * ld + i] - (double)p[2] };

    return d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
}

static void expect_index(int64_t got, int64_t want, const char *what, int n)
{
    const float g = (float)got, w = (float)want;

    expect_bits(&g, &w, 1, "%s, %d points", what, n);
}

static void check_farthest(const lt_kernels *k, const lt_kernels *generic, int n, int64_t ld)
{
    float *x = lattice(n, ld), *d = guarded_array((size_t)ld), *want = guarded_array((size_t)ld);

    for (int64_t i = 0; i < ld; i++)
        d[i] = want[i] = isnan(x[i]) ? -1 : INFINITY;
    for (int64_t at = 0, round = 0; round < 9; round++) {
        const float p[3] = { x[at], x[ld + at], x[2 * ld + at] };
        const int64_t next = generic->farthest_point(want, x, ld, p);

        expect_index(k->farthest_point(d, x, ld, p), next, "farthest_point", n);
        expect_bits(d, want, (size_t)ld, "farthest_point, distances of %d points", n);
        for (int64_t i = 0; i < ld; i++)
            expect_index(want[i] > want[next] || (want[i] == want[next] && i < next), 0, "farthest_point, plainly", n);
        at = next;
    }
    free_array(x), free_array(d), free_array(want);
}

static void check_near(const lt_kernels *k, const lt_kernels *generic, int n, int64_t ld)
{
    static const float p[3] = { 0.25f, -0.5f, 0.125f }, r2[] = { 0, 0.3f, 1, 9 };
    float *x = lattice(n, ld), least, want;
    int32_t index[ROOM + 1], plain[MOST];
    const int64_t at = k->nearest_point(&least, x, ld, p);

    expect_index(at, generic->nearest_point(&want, x, ld, p), "nearest_point", n);
    expect_bits(&least, &want, 1, "nearest_point, the distance of %d points", n);
    for (int64_t i = 0; i < n; i++)
        expect_index(square(x, ld, i, p) < (double)least - 1e-6, 0, "nearest_point, plainly", n);
    for (size_t r = 0; r < LT_COUNT(r2); r++) {
        int64_t found = 0, got;

        for (int64_t i = 0; i < n; i++)
            if (square(x, ld, i, p) <= (double)r2[r])
                plain[found++] = (int32_t)i;
        index[ROOM] = -7;
        got = k->points_within(index, ROOM, x, ld, p, r2[r]);
        expect_index(got, found < ROOM ? found : ROOM, "points_within, how many", n);
        for (int64_t i = 0; i < got; i++)
            expect_index(index[i], plain[i], "points_within", n);
        expect_index(index[ROOM], -7, "points_within, behind its room", n);
    }
    free_array(x);
}

static void check_take(const lt_kernels *k, const lt_kernels *generic, int n)
{
    float *x = random_array(MOST, 8), *y = guarded_array((size_t)n), *want = guarded_array((size_t)n);
    int32_t at[MOST];

    for (int i = 0; i < n; i++)
        at[i] = i % 5 == 3 ? -1 - i : 37 * i % MOST;
    generic->take_from(want, x, at, 0.3f, (size_t)n);
    k->take_from(y, x, at, 0.3f, (size_t)n);
    expect_bits(y, want, (size_t)n, "take_from, %d numbers", n);
    for (int i = 0; i < n; i++)
        expect_near((double)y[i], (double)(at[i] < 0 ? -0.3f : x[at[i]] - 0.3f), 0, "take_from", "plainly", (size_t)i);
    free_array(x), free_array(y), free_array(want);
}

/* n to a row: whole numbers, so that largest ones are equal; rows of -inf, and with NaN */
static void check_largest(const lt_kernels *k, const lt_kernels *generic, int n)
{
    enum { ROWS = 37 };
    float *x = random_array((size_t)(ROWS * n), 5), y[ROWS], want[ROWS], bare[ROWS];
    int32_t where[ROWS], want_where[ROWS];

    for (int i = 0; i < ROWS * n; i++)
        x[i] = i / n == 3 ? -INFINITY : i / n > 5 && i % 7 == 4 ? NAN : roundf(4 * x[i]);
    generic->largest_of_rows(want, want_where, x, n, ROWS);
    k->largest_of_rows(y, where, x, n, ROWS);
    k->largest_of_rows(bare, NULL, x, n, ROWS);
    expect_bits(y, want, ROWS, "largest_of_rows of %d", n);
    expect_bits(bare, want, ROWS, "largest_of_rows of %d, without places", n);
    for (int r = 0; r < ROWS; r++) {
        int plain = 0;

        for (int i = 1; i < n; i++)
            if (!(x[r * n + i] <= x[r * n + plain]) && !isnan(x[r * n + plain]))
                plain = i;
        expect_index(where[r], want_where[r], "largest_of_rows, the place", n);
        expect_index(where[r], plain, "largest_of_rows, plainly", n);
    }
    free_array(x);
}

static void check_hash(const lt_kernels *k, const lt_kernels *generic, const lt_hash_level *l, int n)
{
    float *x = random_array((size_t)(3 * n), 6), *weight = zero_array(8 * MOST), *want = zero_array(8 * MOST);
    float *at = zero_array(8 * MOST), *want_at = zero_array(8 * MOST);

    if (n > 2)
        x[4] = NAN, x[5] = INFINITY, x[6] = 1, x[7] = 0, x[8] = -INFINITY;
    generic->hash_corners((int32_t *)(void *)want_at, want, MOST, x, l, (size_t)n);
    k->hash_corners((int32_t *)(void *)at, weight, MOST, x, l, (size_t)n);
    expect_bits(weight, want, 8 * MOST, "hash_corners, weights of %d", n);
    expect_bits(at, want_at, 8 * MOST, "hash_corners, entries of %d", n);
    for (int i = 0; i < n; i++) {
        double sum = 0;

        for (int c = 0; c < 8; c++)
            sum += (double)want[c * MOST + i];
        expect_near(sum, 1, 1e-5, "hash_corners", "weights", (size_t)i);
    }
    free_array(x), free_array(weight), free_array(want), free_array(at), free_array(want_at);
}

/* Rows with no link, one and more, told by rows of x in no order; plainly, as far as a fused product's rounding goes */
static void check_links(const lt_kernels *k, const lt_kernels *generic, int rows, bool relu)
{
    enum { FROM = 50, MOST_LINKS = 5 * MOST };
    const size_t size = (size_t)rows * LT_BLOCK;
    float *x = random_array(FROM * LT_BLOCK, 9), *weight = random_array(MOST_LINKS, 10);
    float *scale = random_array(LT_BLOCK, 11), *y = guarded_array(size), *want = guarded_array(size);
    float *sums = zero_array(MOST_LINKS * LT_BLOCK), *want_sums = zero_array(MOST_LINKS * LT_BLOCK);
    int32_t first[MOST + 1] = { 0 };
    int64_t from[MOST_LINKS];
    lt_links l = { .first = first, .from = from, .weight = weight, .relu = relu };

    for (int r = 0; r < rows; r++)
        first[r + 1] = first[r] + r * 7 % 5;
    for (int i = 0; i < first[rows]; i++)
        from[i] = i * 37 % FROM * LT_BLOCK;
    if (relu)
        l.scale = scale, l.shift = x;
    generic->link_rows(want, x, &l, rows);
    k->link_rows(y, x, &l, rows);
    expect_bits(y, want, size, "link_rows, %d rows", rows);
    for (size_t i = 0; i < size; i++) {
        double sum = 0;

        for (int32_t j = first[i / LT_BLOCK]; j < first[i / LT_BLOCK + 1]; j++)
            sum += (double)weight[j] * (double)x[from[j] + (int64_t)i % LT_BLOCK];
        if (relu)
            sum = fmax(0, (double)scale[i % LT_BLOCK] * sum + (double)x[i % LT_BLOCK]);
        expect_near((double)y[i], sum, 1e-6, "link_rows", "plainly", i);
    }
    for (int time = 0; time < 2; time++) {
        generic->link_products(want_sums, x, want, &l, rows);
        k->link_products(sums, x, y, &l, rows);
    }
    expect_bits(sums, want_sums, MOST_LINKS * LT_BLOCK, "link_products, %d rows", rows);
    for (int64_t i = 0; i < (int64_t)size; i++)
        for (int32_t j = first[i / LT_BLOCK]; j < first[i / LT_BLOCK + 1]; j++)
            expect_near((double)sums[j * LT_BLOCK + i % LT_BLOCK],
                        2 * (double)y[i] * (double)x[from[j] + i % LT_BLOCK], 2e-6, "link_products", "plainly",
                        (size_t)i);
    free_array(x), free_array(weight), free_array(scale), free_array(y), free_array(want);
    free_array(sums), free_array(want_sums);
}

void check_points(const lt_kernels *k, const lt_kernels *generic)
{
    static const lt_hash_level dense = { .scale = 15, .side = 16, .entries = 4096 };
    static const lt_hash_level hashed = { .scale = 2047, .side = 2048, .entries = 65536, .hashed = true };

    for (int n = 4; n <= MOST; n += 9) {
        check_farthest(k, generic, n, lt_ceil_div(n, LT_POINTS) * LT_POINTS);
        check_near(k, generic, n, lt_ceil_div(n, LT_POINTS) * LT_POINTS);
    }
    for (int n = 1; n < 70; n++) {
        check_largest(k, generic, n);
        check_take(k, generic, n);
    }
    for (int rows = 0; rows < 70; rows++)
        check_links(k, generic, rows, rows % 2);
    for (int n = 0; n < 40; n++) {
        check_hash(k, generic, &dense, n);
        check_hash(k, generic, &hashed, n);
    }
}
