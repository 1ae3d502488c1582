/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/depthwise.h"

#include "libtensor/base/parallel.h"

#include <string.h>

/* ---- strips: forward with stride 1 or 2, and the weights' gradient ---------------------------------- */

/*
 * Some rows of a padded map, dealt to stride x stride phases of one pitch. In them every tap is the same
 * distance from every output, so all rows of a strip are one run of vectors; what comes out between the
 * rows is thrown away.
 */
enum { STRIP = 12 * 1024, MOST_TAPS = 121, SLACK = 64 };

typedef struct {
    int64_t step, pitch, phase;         /* elements between rows, between phases */
    int64_t high;                       /* output rows of a strip */
    int taps;
    int64_t offset[MOST_TAPS];
} strip_plan;

typedef struct {
    const lt_conv2d_params *p;
    const lt_real *x, *dy, *weights;
    const lt_epilogue *e;
    lt_real *y, *dx, *part;
    int64_t out_h, out_w, chunks;
    strip_plan strips;
    bool in_strips;                     /* the shape fits them */
} job;

/* False for shapes that do not fit. */
static bool plan_strips(strip_plan *s, const lt_conv2d_params *p)
{
    const int64_t step = p->stride_h, reach = (int64_t)p->dil_h * (p->kh - 1) / step + 1;

    if (step > 2 || p->stride_w != step || p->kh * p->kw > MOST_TAPS)
        return false;
    s->step = step;
    s->pitch = lt_ceil_div(p->w + 2 * p->pad_w, step);
    s->high = (STRIP - SLACK) / (step * step * s->pitch) - reach;
    s->phase = (s->high + reach) * s->pitch + SLACK / (step * step);
    s->taps = 0;
    for (int ky = 0; ky < p->kh; ky++)
        for (int kx = 0; kx < p->kw; kx++) {
            const int64_t dy = (int64_t)ky * p->dil_h, dx = (int64_t)kx * p->dil_w;

            s->offset[s->taps++] = (dy % step * step + dx % step) * s->phase + dy / step * s->pitch + dx / step;
        }
    return s->high > 0;
}

/* What output rows [from, from + high) of a plane see. q has STRIP + SLACK elements. */
static void deal_strip(const strip_plan *s, const lt_conv2d_params *p, const lt_real *plane, int64_t from,
                       int64_t high, lt_real *q)
{
    const int64_t rows = (high - 1) * s->step + (int64_t)p->dil_h * (p->kh - 1) + 1;
    lt_real line[STRIP + 2 * SLACK];

    memset(line, 0, (size_t)(s->step * s->pitch + SLACK) * sizeof(lt_real));
    for (int64_t r = 0; r < rows; r++) {
        const int64_t y = from * s->step + r - p->pad_h;
        lt_real *to = q + r % s->step * s->step * s->phase + r / s->step * s->pitch;

        if (y >= 0 && y < p->h)
            memcpy(line + p->pad_w, plane + y * p->w, (size_t)p->w * sizeof(lt_real));
        else
            memset(line + p->pad_w, 0, (size_t)p->w * sizeof(lt_real));
        for (int64_t i = 0; i < s->step; i++)
            lt_k->every(to + i * s->phase, line + i, (int)s->step, (size_t)s->pitch);
    }
}

static void forward_strips(void *ctx, int64_t task)
{
    const job *j = ctx;
    const lt_conv2d_params *p = j->p;
    const int64_t o = task % p->o, image = task / p->o, c = o / (p->o / p->groups);
    lt_real q[STRIP + SLACK], out[STRIP + SLACK], *y = j->y + task * j->out_h * j->out_w;
    const strip_plan *s = &j->strips;
    lt_epilogue e = *j->e;

    for (int64_t from = 0; from < j->out_h; from += s->high) {
        const int64_t high = lt_min_i64(s->high, j->out_h - from);

        deal_strip(s, p, j->x + (image * p->c + c) * p->h * p->w, from, high, q);
        lt_k->taps(out, q, s->offset, j->weights + o * s->taps, s->taps, (high - 1) * s->pitch + j->out_w);
        for (int64_t r = 0; r < high; r++)
            memcpy(y + (from + r) * j->out_w, out + r * s->pitch, (size_t)j->out_w * sizeof(lt_real));
    }
    e.row_bias = e.row_bias ? e.row_bias + o : NULL;
    e.residual = e.residual ? e.residual + task * j->out_h * j->out_w : NULL;
    lt_k->epilogue(y, j->out_h * j->out_w, 1, j->out_h * j->out_w, &e);
}

/* dy at the strip's pitch, with zeros between the rows; n elements. */
static void spread_rows(const job *j, const lt_real *dy, int64_t high, lt_real *out)
{
    const int64_t pitch = j->strips.pitch;

    memset(out, 0, (size_t)(high * pitch) * sizeof(lt_real));
    for (int64_t r = 0; r < high; r++)
        memcpy(out + r * pitch, dy + r * j->out_w, (size_t)j->out_w * sizeof(lt_real));
}

static void weights_strips(const job *j, const lt_real *in, const lt_real *dy, lt_real *dw)
{
    const strip_plan *s = &j->strips;
    lt_real q[STRIP + SLACK], rows[STRIP + SLACK];

    for (int64_t from = 0; from < j->out_h; from += s->high) {
        const int64_t high = lt_min_i64(s->high, j->out_h - from), n = (high - 1) * s->pitch + j->out_w;

        deal_strip(s, j->p, in, from, high, q);
        spread_rows(j, dy + from * j->out_w, high, rows);
        for (int t = 0; t < s->taps; t++)
            dw[t] += (lt_real)lt_k->dot(rows, q + s->offset[t], (size_t)n);
    }
}

/* ---- row by row: any stride --------------------------------------------------------------------------- */

/* Output columns [from, to) whose input column, column * stride + offset, is in the map */
typedef struct { int64_t from, to, offset; } span;

static span columns(const job *j, int kx)
{
    const int stride = j->p->stride_w;
    const int64_t offset = (int64_t)kx * j->p->dil_w - j->p->pad_w;
    const int64_t from = offset < 0 ? lt_ceil_div(-offset, stride) : 0;
    const int64_t to = offset < j->p->w ? (j->p->w - 1 - offset) / stride + 1 : 0;
    const span s = { from, lt_min_i64(to, j->out_w), offset };

    return s;
}

typedef void (*tap_fn)(const job *j, int64_t oy, int64_t iy, int tap, span s, void *plane);

/* Call fn for every row of the output and every tap that meets the map there, in order. */
static void each_tap(const job *j, tap_fn fn, void *plane)
{
    const lt_conv2d_params *p = j->p;

    for (int64_t oy = 0; oy < j->out_h; oy++)
        for (int ky = 0; ky < p->kh; ky++) {
            const int64_t iy = oy * p->stride_h + (int64_t)ky * p->dil_h - p->pad_h;

            if (iy < 0 || iy >= p->h)
                continue;
            for (int kx = 0; kx < p->kw; kx++) {
                const span s = columns(j, kx);

                if (s.from < s.to)
                    fn(j, oy, iy, ky * p->kw + kx, s, plane);
            }
        }
}

typedef struct { const lt_real *in, *w; lt_real *out; } forward_plane;

static void forward_tap(const job *j, int64_t oy, int64_t iy, int tap, span s, void *plane)
{
    const forward_plane *f = plane;
    const int stride = j->p->stride_w;

    lt_k->axpy_in(f->out + oy * j->out_w + s.from, f->w[tap],
                  f->in + iy * j->p->w + s.from * stride + s.offset, stride, (size_t)(s.to - s.from));
}

static void forward_task(void *ctx, int64_t task)
{
    const job *j = ctx;
    const lt_conv2d_params *p = j->p;
    const int64_t o = task % p->o, image = task / p->o, out = j->out_h * j->out_w;
    const int64_t c = o / (p->o / p->groups);
    lt_epilogue e = *j->e;
    forward_plane f = {
        j->x + (image * p->c + c) * p->h * p->w, j->weights + o * p->kh * p->kw, j->y + task * out,
    };

    memset(f.out, 0, (size_t)out * sizeof(lt_real));
    each_tap(j, forward_tap, &f);
    e.row_bias = e.row_bias ? e.row_bias + o : NULL;
    e.residual = e.residual ? e.residual + task * out : NULL;
    lt_k->epilogue(f.out, out, 1, out, &e);
}

void lt_depthwise_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *weights,
                          const lt_epilogue *e, lt_real *y)
{
    job j = { .p = p, .x = x, .weights = weights, .e = e, .y = y,
              .out_h = lt_conv2d_out_h(p), .out_w = lt_conv2d_out_w(p) };

    j.in_strips = plan_strips(&j.strips, p);
    lt_parallel_for(p->n * p->o, j.in_strips ? forward_strips : forward_task, &j);
}

typedef struct { const lt_real *dy, *w; lt_real *dx; } data_plane;

static void data_tap(const job *j, int64_t oy, int64_t iy, int tap, span s, void *plane)
{
    const data_plane *d = plane;
    const int stride = j->p->stride_w;

    lt_k->axpy_out(d->dx + iy * j->p->w + s.from * stride + s.offset, stride, d->w[tap],
                   d->dy + oy * j->out_w + s.from, (size_t)(s.to - s.from));
}

/* One input plane; it may feed several output channels. */
static void data_task(void *ctx, int64_t task)
{
    const job *j = ctx;
    const lt_conv2d_params *p = j->p;
    const int64_t c = task % p->c, image = task / p->c, og = p->o / p->groups;

    for (int64_t o = c * og; o < (c + 1) * og; o++) {
        data_plane d = {
            j->dy + (image * p->o + o) * j->out_h * j->out_w, j->weights + o * p->kh * p->kw,
            j->dx + task * p->h * p->w,
        };

        each_tap(j, data_tap, &d);
    }
}

void lt_depthwise_backward_data(const lt_conv2d_params *p, const lt_real *dy, const lt_real *weights,
                                lt_real *dx)
{
    job j = { .p = p, .dy = dy, .weights = weights, .dx = dx,
              .out_h = lt_conv2d_out_h(p), .out_w = lt_conv2d_out_w(p) };

    lt_parallel_for(p->n * p->c, data_task, &j);
}

typedef struct { const lt_real *in, *dy; lt_real *dw; } weights_plane;

static void weights_tap(const job *j, int64_t oy, int64_t iy, int tap, span s, void *plane)
{
    const weights_plane *f = plane;
    const int stride = j->p->stride_w;

    f->dw[tap] += (lt_real)lt_k->dot_step(f->dy + oy * j->out_w + s.from,
                                          f->in + iy * j->p->w + s.from * stride + s.offset, stride,
                                          (size_t)(s.to - s.from));
}

static void weights_task(void *ctx, int64_t task)
{
    const job *j = ctx;
    const lt_conv2d_params *p = j->p;
    const int64_t o = task % p->o, chunk = task / p->o, c = o / (p->o / p->groups);
    const int64_t from = chunk * p->n / j->chunks, to = (chunk + 1) * p->n / j->chunks;
    const int64_t taps = (int64_t)p->kh * p->kw;
    weights_plane f = { .dw = j->part + (chunk * p->o + o) * taps };

    memset(f.dw, 0, (size_t)taps * sizeof(lt_real));
    for (int64_t image = from; image < to; image++) {
        f.in = j->x + (image * p->c + c) * p->h * p->w;
        f.dy = j->dy + (image * p->o + o) * j->out_h * j->out_w;
        if (j->in_strips)
            weights_strips(j, f.in, f.dy, f.dw);
        else
            each_tap(j, weights_tap, &f);
    }
}

void lt_depthwise_backward_weights(const lt_conv2d_params *p, const lt_real *x, const lt_real *dy,
                                   int64_t chunks, lt_real *part)
{
    job j = { .p = p, .x = x, .dy = dy, .chunks = chunks, .part = part,
              .out_h = lt_conv2d_out_h(p), .out_w = lt_conv2d_out_w(p) };

    j.in_strips = plan_strips(&j.strips, p);
    lt_parallel_for(chunks * p->o, weights_task, &j);
}
