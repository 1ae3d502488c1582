/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/depthwise.h"

#include "libtensor/base/parallel.h"

#include <string.h>

typedef struct {
    const lt_conv2d_params *p;
    const lt_real *x, *dy, *weights;
    const lt_epilogue *e;
    lt_real *y, *dx, *part;
    int64_t out_h, out_w, chunks;
} job;

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

    lt_parallel_for(p->n * p->o, forward_task, &j);
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
        each_tap(j, weights_tap, &f);
    }
}

void lt_depthwise_backward_weights(const lt_conv2d_params *p, const lt_real *x, const lt_real *dy,
                                   int64_t chunks, lt_real *part)
{
    job j = { .p = p, .x = x, .dy = dy, .chunks = chunks, .part = part,
              .out_h = lt_conv2d_out_h(p), .out_w = lt_conv2d_out_w(p) };

    lt_parallel_for(chunks * p->o, weights_task, &j);
}
