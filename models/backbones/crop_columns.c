/* SPDX-License-Identifier: Apache-2.0 */
#include "models/backbones/crop_columns.h"

#include "libtensor/base/parallel.h"

#include <assert.h>
#include <string.h>

static const alexnet_map *map_in(const crop_columns *c, int crop) { return &c->crops->crop[crop].in[c->l]; }
static const alexnet_map *map_out(const crop_columns *c, int crop) { return &c->crops->crop[crop].out[c->l]; }

int64_t crop_columns_count(const crop_columns *c)
{
    const alexnet_map *last = map_out(c, c->n - 1);

    return last->at + last->h * last->w;
}

bool crop_columns_next(crop_columns *c)
{
    c->from += c->columns;
    c->columns = 0;
    c->crop = c->last_crop, c->row = c->last_row;
    for (; c->last_crop < c->n; c->last_crop++, c->last_row = 0) {
        const alexnet_map *y = map_out(c, c->last_crop);

        assert(y->w <= c->ld);
        for (; c->last_row < y->h; c->last_row++, c->columns += y->w)
            if (c->columns + y->w > c->ld)
                return true;
    }
    return c->columns > 0;
}

/* One row of a crop's result under one row of the window: column `at` of the matrix, row iy of the map x */
typedef struct {
    const alexnet_layer *a;
    int64_t at, w, iy, ix;          /* ix: what the first position sees under the window's first column, maybe < 0 */
    const alexnet_map *x;
} window_row;

typedef void (*row_fn)(const window_row *r, lt_real *columns, int64_t ld, lt_real *plane);

/* For each row that c has now, under row ky of the window */
static void each_row(const crop_columns *c, int ky, lt_real *columns, lt_real *plane, row_fn fn)
{
    const alexnet_layer *a = &alexnet_layers[c->l];
    window_row r = { .a = a, .at = 0, .ix = -a->pad };

    for (int i = c->crop; i <= c->last_crop && i < c->n; i++) {
        const int64_t first = i == c->crop ? c->row : 0, last = i == c->last_crop ? c->last_row : map_out(c, i)->h;

        r.x = map_in(c, i);
        r.w = map_out(c, i)->w;
        for (int64_t y = first; y < last; y++, r.at += r.w) {
            r.iy = y * a->stride - a->pad + ky;
            fn(&r, columns, c->ld, plane);
        }
    }
}

/* The positions p whose ix + p * stride + kx is inside the map: [from, to) */
static void inside(const window_row *r, int kx, int64_t *from, int64_t *to)
{
    const int64_t ix = r->ix + kx, stride = r->a->stride, left = r->x->w - ix;

    if (stride == 1) {                              /* most of them; without dividing */
        *from = lt_max_i64(0, -ix);
        *to = lt_max_i64(0, lt_min_i64(r->w, left));
    } else {
        *from = ix < 0 ? lt_ceil_div(-ix, stride) : 0;
        *to = left > 0 ? lt_min_i64(r->w, (left - 1) / stride + 1) : 0;
    }
    *from = lt_min_i64(*from, r->w);
    *to = lt_max_i64(*from, *to);
}

static void gather_row(const window_row *r, lt_real *columns, int64_t ld, lt_real *plane)
{
    const bool outside = r->iy < 0 || r->iy >= r->x->h;
    const lt_real *x = plane + r->x->at + r->iy * r->x->w;

    for (int kx = 0; kx < r->a->k; kx++) {
        lt_real *to = columns + kx * ld + r->at;
        int64_t first, last;

        inside(r, kx, &first, &last);
        if (outside)
            first = last = r->w;
        memset(to, 0, (size_t)first * sizeof(*to));
        memset(to + last, 0, (size_t)(r->w - last) * sizeof(*to));
        if (r->a->stride == 1)
            memcpy(to + first, x + r->ix + kx + first, (size_t)(last - first) * sizeof(*to));
        else
            for (int64_t p = first; p < last; p++)
                to[p] = x[r->ix + kx + p * r->a->stride];
    }
}

static void scatter_row(const window_row *r, lt_real *columns, int64_t ld, lt_real *plane)
{
    lt_real *x = plane + r->x->at + r->iy * r->x->w;

    if (r->iy < 0 || r->iy >= r->x->h)
        return;
    for (int kx = 0; kx < r->a->k; kx++) {
        const lt_real *from = columns + kx * ld + r->at;
        int64_t first, last;

        inside(r, kx, &first, &last);
        if (r->a->stride == 1)
            lt_k->add_to(x + r->ix + kx + first, from + first, (size_t)(last - first));
        else
            for (int64_t p = first; p < last; p++)
                x[r->ix + kx + p * r->a->stride] += from[p];
    }
}

typedef struct {
    const crop_columns *c;
    lt_real *columns, *maps;
} job;

/* Rows of the matrix for one row of the window of one channel */
static void gather_task(void *ctx, int64_t task)
{
    const job *j = ctx;
    const int k = alexnet_layers[j->c->l].k;

    each_row(j->c, (int)(task % k), j->columns + task * k * j->c->ld, j->maps + task / k * j->c->crops->in[j->c->l],
             gather_row);
}

void crop_columns_gather(const crop_columns *c, const lt_real *x, lt_real *out)
{
    job j = { c, out, (lt_real *)x };

    lt_parallel_for((int64_t)c->channels * alexnet_layers[c->l].k, gather_task, &j);
}

/* One channel's maps have one owner. */
static void scatter_task(void *ctx, int64_t channel)
{
    const job *j = ctx;
    const int k = alexnet_layers[j->c->l].k;

    for (int ky = 0; ky < k; ky++)
        each_row(j->c, ky, j->columns + (channel * k + ky) * k * j->c->ld, j->maps + channel * j->c->crops->in[j->c->l],
                 scatter_row);
}

void crop_columns_scatter(const crop_columns *c, const lt_real *columns, lt_real *dx)
{
    job j = { c, (lt_real *)columns, dx };

    lt_parallel_for(c->channels, scatter_task, &j);
}

void crop_columns_clear(const crop_columns *c, lt_real *dx)
{
    const alexnet_map *last = map_in(c, c->n - 1);

    for (int channel = 0; channel < c->channels; channel++)
        memset(dx + channel * c->crops->in[c->l], 0, (size_t)(last->at + last->h * last->w) * sizeof(*dx));
}
