/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/ops/sample/resample.h"

size_t resample_axis_bytes(int64_t n, int64_t width)
{
    return (size_t)n * (2 * sizeof(lt_real) + (size_t)width * sizeof(lt_real));
}

resample_axis resample_axis_at(void *memory, int64_t n, int64_t width)
{
    resample_axis a = { .n = n, .width = width, .weight = memory };

    a.first = (int32_t *)(void *)(a.weight + n * width);
    a.count = a.first + n;
    memset(memory, 0, resample_axis_bytes(n, width));
    return a;
}

void resample_weigh(resample_axis *a, int64_t i, int64_t p, double weight)
{
    if (a->count[i] == 0)
        a->first[i] = (int32_t)p;
    if (p - a->first[i] >= a->width)
        return;
    a->count[i] = (int32_t)lt_max_i64(a->count[i], p - a->first[i] + 1);
    a->weight[i * a->width + p - a->first[i]] += (lt_real)weight;
}

void resample_turn(resample_axis *t, const resample_axis *a)
{
    for (int64_t i = 0; i < a->n; i++)
        for (int64_t k = 0; k < a->count[i]; k++)
            resample_weigh(t, a->first[i] + k, i, a->weight[i * a->width + k]);
}

static int64_t lanes_of(int64_t n)
{
    return lt_ceil_div(n, LT_COLUMNS) * LT_COLUMNS;
}

/* Mixed rows, with what is read behind a base; weights, places and bases of columns */
int64_t resample_scratch(int64_t rows, int64_t w, int64_t cols, int64_t width)
{
    return rows * (w + 2 * LT_COLUMNS) + (2 * width + 1) * lanes_of(cols);
}

/* The inputs that an axis reads, [*lo, the result) */
static int64_t read_by(const resample_axis *a, int64_t n_in, int64_t *lo)
{
    int64_t hi = 0;

    *lo = n_in;
    for (int64_t i = 0; i < a->n; i++)
        if (a->count[i]) {
            *lo = lt_min_i64(*lo, a->first[i]);
            hi = lt_max_i64(hi, a->first[i] + a->count[i]);
        }
    *lo = lt_min_i64(*lo, hi);
    return hi;
}

/* Where outputs [from, end) start to read, counted from lo */
static int32_t base_of(const resample_axis *a, int64_t from, int64_t end, int64_t lo)
{
    int64_t base = INT32_MAX;

    for (int64_t j = from; j < end; j++)
        if (a->count[j])
            base = lt_min_i64(base, a->first[j] - lo);
    return base == INT32_MAX ? 0 : (int32_t)base;
}

/* An axis in lanes, whose inputs count from lo on; in memory of (2 width + 1) lanes_of(n) elements */
static lt_columns columns_of(const resample_axis *a, int64_t lo, lt_real *memory)
{
    const int64_t ld = lanes_of(a->n);
    lt_real *weight = memory;
    int32_t *at = (int32_t *)(void *)(weight + a->width * ld), *base = at + a->width * ld;
    lt_columns c = { .n = a->n, .base = base, .at = at, .weight = weight, .near = true };

    for (int64_t j = 0; j < a->n; j++)
        c.taps = lt_max_i64(c.taps, a->count[j]);
    for (int64_t i = 0; i < c.taps * ld; i++)
        at[i] = -1, weight[i] = 0;
    for (int64_t j = 0; j < a->n; j += LT_COLUMNS)
        base[j / LT_COLUMNS] = base_of(a, j, lt_min_i64(a->n, j + LT_COLUMNS), lo);
    for (int64_t j = 0; j < a->n; j++)
        for (int32_t k = 0; k < a->count[j]; k++) {
            at[k * ld + j] = (int32_t)(a->first[j] + k - lo) - base[j / LT_COLUMNS];
            weight[k * ld + j] = a->weight[j * a->width + k];
            c.near = c.near && at[k * ld + j] < 2 * LT_COLUMNS;
        }
    return c;
}

/* Output i of rows: what it mixes of n columns of x */
static void mix(const resample_axis *rows, int64_t i, const lt_real *x, int64_t w, lt_real *y, int64_t n)
{
    if (rows->count[i])
        lt_k->combine(y, x + rows->first[i] * w, w, rows->weight + i * rows->width, rows->count[i], (size_t)n, false);
    else
        memset(y, 0, (size_t)n * sizeof(*y));
}

void resample_planes(const resample_axis *rows, const resample_axis *cols, const lt_real *x, int64_t h, int64_t w,
                     lt_real *y, int64_t n, bool add, lt_real *scratch)
{
    int64_t lo;
    const int64_t wide = read_by(cols, w, &lo) - lo, ld = wide + 2 * LT_COLUMNS;
    const lt_columns c = columns_of(cols, lo, scratch + rows->n * ld);

    for (int64_t p = 0; p < n; p++, x += h * w, y += rows->n * cols->n) {
        for (int64_t i = 0; i < rows->n; i++)
            mix(rows, i, x + lo, w, scratch + i * ld, wide);
        lt_k->combine_columns(y, cols->n, scratch, ld, rows->n, &c, add);
    }
}
