/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/ops/resample.h"

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

int64_t resample_scratch(int64_t h, int64_t w, int64_t out_w)
{
    return h * (w + 2 * out_w);
}

typedef struct {
    int64_t lo, hi;
} span;

/* The inputs that an axis reads; a few more where that makes whole vectors */
static span read_by(const resample_axis *a, int64_t n_in)
{
    enum { WHOLE = 16 };
    span s = { n_in, 0 };
    int64_t length;

    for (int64_t i = 0; i < a->n; i++) {
        if (a->count[i] == 0)
            continue;
        s.lo = lt_min_i64(s.lo, a->first[i]);
        s.hi = lt_max_i64(s.hi, a->first[i] + a->count[i]);
    }
    if (s.lo >= s.hi)
        return (span){ 0, 0 };
    length = lt_min_i64(n_in, lt_ceil_div(s.hi - s.lo, WHOLE) * WHOLE);
    s.lo = lt_min_i64(s.lo, n_in - length);
    return (span){ s.lo, s.lo + length };
}

/* The outputs that read anything */
static span written_by(const resample_axis *a)
{
    span s = { 0, a->n };

    while (s.lo < s.hi && a->count[s.lo] == 0)
        s.lo++;
    while (s.lo < s.hi && a->count[s.hi - 1] == 0)
        s.hi--;
    return s;
}

/* Output i of an axis, for n elements side by side: x holds the rows from input lo on. */
static void mix(const resample_axis *a, int64_t i, const lt_real *x, int64_t lo, int64_t n, lt_real *y, bool add)
{
    if (a->count[i])
        lt_k->combine(y, x + (a->first[i] - lo) * n, n, a->weight + i * a->width, a->count[i], (size_t)n, add);
    else if (!add)
        memset(y, 0, (size_t)n * sizeof(*y));
}

/* Columns first: they are rows of the turned map, so that both ways are sums of rows. */
void resample_plane(const resample_axis *rows, const resample_axis *cols, const lt_real *x, int64_t h, int64_t w,
                    lt_real *y, bool add, lt_real *scratch)
{
    const span in_rows = read_by(rows, h), in_cols = read_by(cols, w), out = written_by(cols);
    const int64_t n_in = in_rows.hi - in_rows.lo, n_out = out.hi - out.lo;
    lt_real *turned = scratch, *mixed = turned + n_in * w, *back = mixed + n_in * n_out;

    if (!add && n_out < cols->n)
        memset(y, 0, (size_t)(rows->n * cols->n) * sizeof(*y));
    lt_k->turn(turned, n_in, x + in_rows.lo * w + in_cols.lo, w, n_in, in_cols.hi - in_cols.lo, false);
    for (int64_t j = 0; j < n_out; j++)
        mix(cols, out.lo + j, turned, in_cols.lo, n_in, mixed + j * n_in, false);
    lt_k->turn(back, n_out, mixed, n_in, n_out, n_in, false);
    for (int64_t i = 0; i < rows->n; i++)
        mix(rows, i, back, in_rows.lo, n_out, y + i * cols->n + out.lo, add);
}
