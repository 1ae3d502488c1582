/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/depthwise.h"

#include "libtensor/base/parallel.h"

#include <string.h>

/* ---- strips: forward with step 1 or 2, and the weights' gradient -------------------------------------- */

/*
 * Some rows of a padded map, dealt to step x step phases of one pitch, so that every tap is the same distance
 * from every output. What comes out between the rows is thrown away. With step 1 a row's padding on the right
 * is the next one's on the left.
 */
enum { STRIP = LT_DEPTHWISE_STRIP, SLACK = 64, EVEN_ROWS = 14, TASK = 1 << 16 };

typedef struct {
    const lt_conv2d_params *p;
    const lt_real *x, *dy, *weights;
    const lt_epilogue *e;
    lt_real *y, *mean, *dx, *part;
    int64_t out_h, out_w, chunks;
    int64_t planes;                     /* of a task of the forward pass */
    lt_depthwise strips;
    bool in_strips;                     /* the shape fits them */
} job;

static void plan_taps(lt_depthwise *s, const lt_conv2d_params *p)
{
    s->taps = 0;
    for (int kx = 0; kx < p->kw; kx++)
        for (int ky = 0; ky < p->kh; ky++) {
            const int64_t dy = (int64_t)ky * p->dil_h, dx = (int64_t)kx * p->dil_w;

            s->weight[s->taps] = ky * p->kw + kx;
            s->offset[s->taps++] = (dy % s->step * s->step + dx % s->step) * s->phase + dy / s->step * s->pitch
                                   + dx / s->step;
        }
}

/* As many rows as fit, in multiples of what kernels take at once; below 1 for none. */
static int64_t strip_height(const lt_depthwise *s)
{
    const int64_t rows = (STRIP - SLACK) / (s->step * s->step * s->pitch) - s->reach / s->step - 2;

    return rows < EVEN_ROWS ? rows : rows / EVEN_ROWS * EVEN_ROWS;
}

/* False for shapes that do not fit. */
static bool plan_strips(lt_depthwise *s, const lt_conv2d_params *p)
{
    const bool close = p->kh == p->kw && p->stride_h == 1 && p->dil_h == 1 && p->dil_w == 1;

    *s = (lt_depthwise){
        .h = p->h, .w = p->w, .out_h = lt_conv2d_out_h(p), .out_w = lt_conv2d_out_w(p), .step = p->stride_h,
        .pad_h = p->pad_h, .pad_w = p->pad_w, .window = close && (p->kh == 3 || p->kh == 5) ? p->kh : 0,
        .reach = (int64_t)p->dil_h * (p->kh - 1) + 1,
    };
    if (s->step > 2 || p->stride_w != s->step || p->kh * p->kw > LT_DEPTHWISE_TAPS)
        return false;
    s->pitch = s->step == 1 ? lt_max_i64(p->w + p->pad_w, s->out_w) : lt_ceil_div(p->w + 2 * p->pad_w, 2);
    s->high = strip_height(s);
    s->phase = (s->high + s->reach / s->step + 2) * s->pitch + SLACK / (s->step * s->step);
    plan_taps(s, p);
    return s->high > 0;
}

/* What output rows [from, from + high) of a plane see. q has STRIP + SLACK elements. */
static void deal_strip(const lt_depthwise *s, const lt_conv2d_params *p, const lt_real *plane, int64_t from,
                       int64_t high, lt_real *q)
{
    const int64_t rows = (high - 1) * s->step + s->reach;
    lt_real line[STRIP + 2 * SLACK];

    memset(line, 0, (size_t)(s->step * s->pitch + SLACK) * sizeof(lt_real));
    for (int64_t r = 0; r <= rows; r++) {
        const int64_t y = from * s->step + r - p->pad_h;
        lt_real *to = q + r % s->step * s->step * s->phase + r / s->step * s->pitch;

        if (y >= 0 && y < p->h && r < rows)
            memcpy(line + p->pad_w, plane + y * p->w, (size_t)p->w * sizeof(lt_real));
        else
            memset(line + p->pad_w, 0, (size_t)p->w * sizeof(lt_real));
        for (int64_t i = 0; i < s->step; i++)
            lt_k->every(to + i * s->phase, line + i, (int)s->step, (size_t)s->pitch);
    }
}

/* The epilogue of output plane i. */
static lt_epilogue plane_epilogue(const job *j, int64_t i)
{
    lt_epilogue e = *j->e;

    e.row_bias = e.row_bias ? e.row_bias + i % j->p->o : NULL;
    e.residual = e.residual ? e.residual + i * j->out_h * j->out_w : NULL;
    return e;
}

static void forward_strips(const job *j, int64_t i)
{
    const lt_conv2d_params *p = j->p;
    const int64_t o = i % p->o, c = o / (p->o / p->groups), out = j->out_h * j->out_w;
    const lt_epilogue e = plane_epilogue(j, i);
    double sum;

    lt_k->depthwise(j->y + i * out, j->mean ? &sum : NULL, j->x + (i / p->o * p->c + c) * p->h * p->w,
                    j->weights + o * p->kh * p->kw, &j->strips, &e);
    if (j->mean)
        j->mean[i] = (lt_real)(sum / (double)out);
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
    const lt_depthwise *s = &j->strips;
    lt_real q[STRIP + SLACK], rows[STRIP + SLACK];

    for (int64_t from = 0; from < j->out_h; from += s->high) {
        const int64_t high = lt_min_i64(s->high, j->out_h - from), n = (high - 1) * s->pitch + j->out_w;

        deal_strip(s, j->p, in, from, high, q);
        spread_rows(j, dy + from * j->out_w, high, rows);
        for (int t = 0; t < s->taps; t++)
            dw[s->weight[t]] += (lt_real)lt_k->dot(rows, q + s->offset[t], (size_t)n);
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
        for (int kx = 0; kx < p->kw; kx++) {
            const span s = columns(j, kx);

            for (int ky = 0; ky < p->kh && s.from < s.to; ky++) {
                const int64_t iy = oy * p->stride_h + (int64_t)ky * p->dil_h - p->pad_h;

                if (iy >= 0 && iy < p->h)
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

static void forward_rows(const job *j, int64_t i)
{
    const lt_conv2d_params *p = j->p;
    const int64_t o = i % p->o, out = j->out_h * j->out_w, c = o / (p->o / p->groups);
    const lt_epilogue e = plane_epilogue(j, i);
    forward_plane f = {
        j->x + (i / p->o * p->c + c) * p->h * p->w, j->weights + o * p->kh * p->kw, j->y + i * out,
    };

    memset(f.out, 0, (size_t)out * sizeof(lt_real));
    each_tap(j, forward_tap, &f);
    lt_k->epilogue(f.out, out, 1, out, &e);
    if (j->mean)
        j->mean[i] = (lt_real)(lt_k->sum(f.out, (size_t)out) / (double)out);
}

static void forward_task(void *ctx, int64_t task)
{
    const job *j = ctx;
    const int64_t end = lt_min_i64(j->p->n * j->p->o, (task + 1) * j->planes);

    for (int64_t i = task * j->planes; i < end; i++)
        (j->in_strips ? forward_strips : forward_rows)(j, i);
}

void lt_depthwise_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *weights,
                          const lt_epilogue *e, lt_real *y, lt_real *mean)
{
    job j = { .p = p, .x = x, .weights = weights, .e = e, .y = y, .mean = mean,
              .out_h = lt_conv2d_out_h(p), .out_w = lt_conv2d_out_w(p) };

    j.in_strips = plan_strips(&j.strips, p);
    j.planes = lt_max_i64(1, TASK / (j.out_h * j.out_w * p->kh * p->kw));
    lt_parallel_for(lt_ceil_div(p->n * p->o, j.planes), forward_task, &j);
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
