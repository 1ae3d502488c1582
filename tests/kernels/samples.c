/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The entries for bilinear samples against the generic ones, bit by bit: places on the map, across its border,
 * far away and nowhere; channels that fill vectors and that do not; and against plain sums.
 */
#include "tests/kernels/checkasm.h"

#include "libtensor/base/rng.h"

#include <math.h>
#include <string.h>

enum { CORNERS = 4, STRIDE = 70 };

typedef struct {
    int64_t h, w, rows, d, ld;
    float *x, *place_x, *place_y, *map, *dy;                        /* read */
    int32_t at[CORNERS * STRIDE];
    float *weight, *y, *dmap, *dot, *dx, *dyy, *value, *soft;       /* written */
} work;

static float place(lt_rng *r, int64_t n, bool awkward)
{
    static const float odd[] = { NAN, INFINITY, -INFINITY, 3e38f, -1e20f, -1, -0.0f, 1e-40f, 2 };

    if (awkward && lt_rng_below(r, 4) == 0)
        return odd[lt_rng_below(r, (uint32_t)LT_COUNT(odd))];
    return (float)lt_rng_range(r, -3, (double)n + 2);
}

static work new_work(int64_t h, int64_t w, int64_t rows, int64_t d, bool awkward)
{
    lt_rng r = lt_rng_make(31, (uint64_t)(rows * 100 + d));
    work k = { .h = h, .w = w, .rows = rows, .d = d, .ld = d + 3 };

    k.place_x = zero_array((size_t)rows), k.place_y = zero_array((size_t)rows);
    for (int64_t i = 0; i < rows; i++) {
        k.place_x[i] = place(&r, w, awkward);
        k.place_y[i] = place(&r, h, awkward);
    }
    k.map = random_array((size_t)((h * w - 1) * k.ld + d), 1), k.dy = random_array((size_t)(rows * k.ld), 2);
    k.dmap = random_array((size_t)((h * w - 1) * k.ld + d), 3), k.dot = random_array(CORNERS * STRIDE, 4);
    k.soft = random_array(CORNERS * STRIDE, 5);
    k.weight = zero_array(CORNERS * STRIDE), k.y = zero_array((size_t)(rows * k.ld));
    k.dx = zero_array((size_t)rows), k.dyy = zero_array((size_t)rows), k.value = zero_array((size_t)rows);
    return k;
}

static void free_work(work *k)
{
    float *const all[] = { k->place_x, k->place_y, k->map, k->dy, k->dmap, k->dot, k->soft, k->weight, k->y, k->dx,
                           k->dyy, k->value };

    for (size_t i = 0; i < LT_COUNT(all); i++)
        free_array(all[i]);
}

static lt_samples samples_of(const work *k)
{
    return (lt_samples){ .x = k->map, .ldx = k->ld, .d = k->d, .rows = k->rows, .taps = CORNERS,
                         .stride = STRIDE, .at = k->at, .weight = k->weight };
}

static void run(const lt_kernels *lt, work *k)
{
    const lt_samples s = samples_of(k);

    lt->corners(k->at, k->weight, STRIDE, k->place_x, k->place_y, k->h, k->w, (size_t)k->rows);
    lt->sample(k->y, k->ld, &s);
    lt->sample_dots(k->dot, k->dy, k->ld, &s);
    lt->corners_grad(k->dx, k->dyy, k->value, STRIDE, k->dot, k->place_x, k->place_y, k->h, k->w, (size_t)k->rows);
    lt->sample_spread(k->dmap, k->dy, k->ld, &s);
    lt->softmax_down(k->soft, STRIDE, CORNERS, (size_t)k->rows);
}

static double cell(const work *k, int64_t x, int64_t y, int64_t channel)
{
    if (x < 0 || y < 0 || x >= k->w || y >= k->h)
        return 0;
    return (double)k->map[(y * k->w + x) * k->ld + channel];
}

static void check_plainly(const work *k, int64_t row)
{
    const double x = (double)k->place_x[row], y = (double)k->place_y[row];
    const int64_t x0 = (int64_t)floor(x), y0 = (int64_t)floor(y);
    const double u = x - (double)x0, v = y - (double)y0;

    for (int64_t i = 0; i < k->d; i++) {
        const double top = (1 - u) * cell(k, x0, y0, i) + u * cell(k, x0 + 1, y0, i);
        const double bottom = (1 - u) * cell(k, x0, y0 + 1, i) + u * cell(k, x0 + 1, y0 + 1, i);

        expect_near((double)k->y[row * k->ld + i], (1 - v) * top + v * bottom, 1e-5, "sample", "channel", (size_t)i);
    }
}

static void check_case(const lt_kernels *lt, const lt_kernels *generic, int64_t rows, int64_t d, bool awkward)
{
    work want = new_work(5, 7, rows, d, awkward), got = new_work(5, 7, rows, d, awkward);
    const size_t n = (size_t)rows, map = (size_t)((5 * 7 - 1) * want.ld + d);

    run(generic, &want);
    run(lt, &got);
    for (int c = 0; c < CORNERS; c++)
        if (memcmp(got.at + c * STRIDE, want.at + c * STRIDE, n * sizeof(int32_t)) != 0)
            expect_near(1, 0, 0, "corners", "cells differ, corner", (size_t)c);
#define SAME(what, count) expect_bits(got.what, want.what, count, "samples " #what ", %d rows, d %d, awkward %d", \
                                      (int)rows, (int)d, awkward)
    SAME(weight, CORNERS * STRIDE), SAME(y, n * (size_t)want.ld), SAME(dot, CORNERS * STRIDE), SAME(dx, n);
    SAME(dyy, n), SAME(value, n), SAME(dmap, map), SAME(soft, CORNERS * STRIDE);
    for (int64_t i = 0; i < rows && !awkward; i++)
        check_plainly(&got, i);
    free_work(&want), free_work(&got);
}

void check_samples(const lt_kernels *k, const lt_kernels *generic)
{
    static const int64_t rows[] = { 0, 1, 7, 16, 33, 64, 67 }, d[] = { 1, 7, 8, 15, 16, 17, 24, 33, 64 };

    for (size_t a = 0; a < LT_COUNT(rows); a++)
        for (size_t b = 0; b < LT_COUNT(d); b++)
            for (int awkward = 0; awkward < 2; awkward++)
                check_case(k, generic, rows[a], d[b], awkward);
}
