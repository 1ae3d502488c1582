/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/conv/depthwise.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv/internal.h"
#include "libtensor/kernels/conv/way.h"
#include "libtensor/kernels/gemm/product.h"

#include <string.h>

/* ---- strips: steps 1 and 2 ------------------------------------------------------------------------------- */

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
    bool add;                           /* to dx */
    int64_t out_h, out_w, chunks;
    int64_t planes;                     /* of a task, forward and for the gradient of x */
    lt_depthwise strips;
    bool in_strips;                     /* the shape fits them */
    bool up;                            /* the kernel for steps of 2 serves for the gradient of x */
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
    const bool close = p->kh == p->kw && p->dil_h == 1 && p->dil_w == 1;

    *s = (lt_depthwise){
        .h = p->h, .w = p->w, .out_h = lt_conv2d_out_h(p), .out_w = lt_conv2d_out_w(p), .step = p->stride_h,
        .pad_h = p->pad_h, .pad_w = p->pad_w, .maps = 1, .window = close && (p->kh == 3 || p->kh == 5) ? p->kh : 0,
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

/* The epilogue of output planes from i on, in one image. */
static lt_epilogue plane_epilogue(const job *j, int64_t i)
{
    lt_epilogue e = *j->e;

    e.row_bias = e.row_bias ? e.row_bias + i % j->p->o : NULL;
    e.residual = e.residual ? e.residual + i * j->out_h * j->out_w : NULL;
    return e;
}

/* Output planes from i on, of one image; their number, below `end`: several where each has a map of its own */
static int64_t forward_strips(const job *j, int64_t i, int64_t end)
{
    enum { TOGETHER = 64 };
    const lt_conv2d_params *p = j->p;
    const int64_t o = i % p->o, c = o / (p->o / p->groups) * j->strips.maps, out = j->out_h * j->out_w;
    const int64_t most = p->o == p->groups ? lt_min_i64(TOGETHER, p->o - o) : 1, n = lt_min_i64(most, end - i);
    const lt_epilogue e = plane_epilogue(j, i);
    double sum[TOGETHER];

    lt_k->depthwise(j->y + i * out, j->mean ? sum : NULL, j->x + (i / p->o * p->c + c) * p->h * p->w,
                    j->weights + o * j->strips.maps * p->kh * p->kw, &j->strips, &e, n);
    for (int64_t k = 0; j->mean && k < n; k++)
        j->mean[i + k] = (lt_real)(sum[k] / (double)out);
    return n;
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

/* Where there are many, in whole vectors of them. */
static int64_t planes_of_task(const job *j)
{
    enum { LANES = 16 };
    const int64_t n = TASK / (j->out_h * j->out_w * j->p->kh * j->p->kw * (j->p->c / j->p->groups));

    return n > LANES ? n / LANES * LANES : lt_max_i64(1, n);
}

static void forward_task(void *ctx, int64_t task)
{
    const job *j = ctx;
    const int64_t end = lt_min_i64(j->p->n * j->p->o, (task + 1) * j->planes);
    int64_t i = task * j->planes;

    while (j->in_strips && i < end)
        i += forward_strips(j, i, end);
    for (; i < end; i++)
        forward_rows(j, i);
}

static void run_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *weights,
                        const lt_conv2d_around *around, lt_real *y)
{
    const lt_epilogue e = { .row_bias = around->bias, .residual = around->residual, .act = around->act };
    job j = { .p = p, .x = x, .weights = weights, .e = &e, .y = y, .mean = around->mean,
              .out_h = lt_conv2d_out_h(p), .out_w = lt_conv2d_out_w(p) };

    j.in_strips = plan_strips(&j.strips, p);
    j.strips.maps = p->c / p->groups;
    j.planes = planes_of_task(&j);
    lt_parallel_for(lt_ceil_div(p->n * p->o, j.planes), forward_task, &j);
}

bool lt_few_suits(const lt_conv2d_params *p)
{
    enum { FEW = 4 };
    lt_depthwise s;

    if (p->groups > 1 || p->c < 2 || p->o > FEW || lt_conv2d_out_h(p) < 1 || lt_conv2d_out_w(p) < 1)
        return false;
    return plan_strips(&s, p) && s.window;
}

/* ---- gradient of x --------------------------------------------------------------------------------------- */

typedef struct { const lt_real *dy, *w; lt_real *dx; } data_plane;

static void data_tap(const job *j, int64_t oy, int64_t iy, int tap, span s, void *plane)
{
    const data_plane *d = plane;
    const int stride = j->p->stride_w;

    lt_k->axpy_out(d->dx + iy * j->p->w + s.from * stride + s.offset, stride, d->w[tap],
                   d->dy + oy * j->out_w + s.from, (size_t)(s.to - s.from));
}

/* The convolution that dx is of dy, whose elements stand `stride` apart with zeros between them, and the window
 * turned over. Its maps must fit into scratch. */
static bool plan_turned(lt_depthwise *s, const lt_conv2d_params *p)
{
    const int reach_h = p->dil_h * (p->kh - 1), reach_w = p->dil_w * (p->kw - 1);
    lt_conv2d_params t = *p;

    t.pad_h = reach_h - p->pad_h;
    t.pad_w = reach_w - p->pad_w;
    t.h = p->h + reach_h - 2 * t.pad_h;
    t.w = p->w + reach_w - 2 * t.pad_w;
    t.stride_h = t.stride_w = 1;
    return p->stride_h <= 2 && p->stride_w <= 2 && t.pad_h >= 0 && t.pad_w >= 0 && t.h * t.w <= LT_SCRATCH_A
           && p->h * p->w <= LT_SCRATCH_B && plan_strips(s, &t);
}

static void space_out(const job *j, const lt_real *dy, lt_real *out)
{
    const lt_conv2d_params *p = j->p;

    memset(out, 0, (size_t)(j->strips.h * j->strips.w) * sizeof(lt_real));
    for (int64_t r = 0; r < j->out_h; r++)
        lt_k->axpy_out(out + r * p->stride_h * j->strips.w, p->stride_w, 1, dy + r * j->out_w, (size_t)j->out_w);
}

/* One map of dy under the window w, turned over */
static void under_turned(lt_real *dx, const lt_real *dy, const lt_real *w, const lt_depthwise *strips)
{
    const lt_epilogue nothing = { 0 };
    lt_real turned[LT_DEPTHWISE_TAPS];

    for (int t = 0; t < strips->taps; t++)
        turned[t] = w[strips->taps - 1 - t];
    lt_k->depthwise(dx, NULL, dy, turned, strips, &nothing, 1);
}

typedef struct { const job *j; int64_t task; } data_call;

static void data_turned(void *ctx, lt_real *spaced, lt_real *result)
{
    const data_call *d = ctx;
    const job *j = d->j;
    const lt_conv2d_params *p = j->p;
    const int64_t c = d->task % p->c, image = d->task / p->c, og = p->o / p->groups, taps = (int64_t)p->kh * p->kw;
    lt_real *dx = j->dx + d->task * p->h * p->w;

    for (int64_t o = c * og; o < (c + 1) * og; o++) {
        const lt_real *dy = j->dy + (image * p->o + o) * j->out_h * j->out_w, *w = j->weights + o * taps;

        if (p->stride_h > 1 || p->stride_w > 1) {
            space_out(j, dy, spaced);
            dy = spaced;
        }
        if (!j->add && o == c * og) {
            under_turned(dx, dy, w, &j->strips);
            continue;
        }
        under_turned(result, dy, w, &j->strips);
        lt_k->add_to(dx, result, (size_t)(p->h * p->w));
    }
}

static void data_rows(const job *j, int64_t task)
{
    const lt_conv2d_params *p = j->p;
    const int64_t c = task % p->c, image = task / p->c, og = p->o / p->groups;

    if (!j->add)
        memset(j->dx + task * p->h * p->w, 0, (size_t)(p->h * p->w) * sizeof(lt_real));
    for (int64_t o = c * og; o < (c + 1) * og; o++) {
        data_plane d = {
            j->dy + (image * p->o + o) * j->out_h * j->out_w, j->weights + o * p->kh * p->kw,
            j->dx + task * p->h * p->w,
        };

        each_tap(j, data_tap, &d);
    }
}

static bool plan_up(lt_depthwise *s, const lt_conv2d_params *p)
{
    return plan_strips(s, p) && s->step == 2 && s->window && p->pad_h == s->window / 2 && p->pad_w == s->window / 2;
}

static void data_up(const job *j, int64_t task)
{
    const lt_conv2d_params *p = j->p;
    const int64_t c = task % p->c, image = task / p->c, og = p->o / p->groups;

    for (int64_t o = c * og; o < (c + 1) * og; o++)
        lt_k->depthwise_up(j->dx + task * p->h * p->w, j->dy + (image * p->o + o) * j->out_h * j->out_w,
                           j->weights + o * p->kh * p->kw, &j->strips, j->add || o > c * og);
}

/* Some input planes; one may feed several output channels. */
static void data_task(void *ctx, int64_t task)
{
    const job *j = ctx;
    const int64_t end = lt_min_i64(j->p->n * j->p->c, (task + 1) * j->planes);

    for (int64_t i = task * j->planes; i < end; i++)
        if (j->up)
            data_up(j, i);
        else if (j->in_strips)
            lt_with_scratch(data_turned, &(data_call){ j, i });
        else
            data_rows(j, i);
}

static void run_data(const lt_conv2d_params *p, const lt_real *dy, const lt_real *weights, bool add, lt_real *dx)
{
    job j = { .p = p, .dy = dy, .weights = weights, .dx = dx, .add = add,
              .out_h = lt_conv2d_out_h(p), .out_w = lt_conv2d_out_w(p) };

    j.up = plan_up(&j.strips, p);
    j.in_strips = j.up || plan_turned(&j.strips, p);
    j.planes = planes_of_task(&j);
    lt_parallel_for(lt_ceil_div(p->n * p->c, j.planes), data_task, &j);
}

/* ---- both, with the weights as they are ------------------------------------------------------------------ */

static int64_t packed_elements(const lt_conv2d_params *p, conv_direction d)
{
    (void)d;
    return conv_weight_count(p);
}

static void pack(const lt_conv2d_params *p, conv_direction d, const lt_real *weights, lt_real *packed)
{
    memcpy(packed, weights, (size_t)packed_elements(p, d) * sizeof(lt_real));
}

static size_t no_work(const lt_conv2d_params *p, conv_direction d)
{
    (void)p, (void)d;
    return 0;
}

static void run(const lt_conv2d_params *p, conv_direction d, const lt_real *x, const lt_real *packed,
                const lt_conv2d_around *around, lt_real *y, void *work)
{
    (void)work;
    if (d == CONV_FORWARD)
        run_forward(p, x, packed, around, y);
    else
        run_data(p, x, packed, around->residual, y);
}

const conv_way conv_depthwise = { packed_elements, pack, no_work, run };

/* ---- gradient of the weights ----------------------------------------------------------------------------- */

typedef struct { const lt_real *in, *dy; lt_real *dw; } weights_plane;

static void weights_tap(const job *j, int64_t oy, int64_t iy, int tap, span s, void *plane)
{
    const weights_plane *f = plane;
    const int stride = j->p->stride_w;

    f->dw[tap] += (lt_real)lt_k->dot_step(f->dy + oy * j->out_w + s.from,
                                          f->in + iy * j->p->w + s.from * stride + s.offset, stride,
                                          (size_t)(s.to - s.from));
}

static lt_real sum_of_lanes(const double *sums, int tap)
{
    double sum = 0;

    for (int l = 0; l < LT_DEPTHWISE_LANES; l++)
        sum += sums[tap * LT_DEPTHWISE_LANES + l];
    return (lt_real)sum;
}

/* Images [from, to) of the map that output channel o reads */
static void weights_strips(const job *j, int64_t o, int64_t from, int64_t to, lt_real *dw)
{
    const lt_conv2d_params *p = j->p;
    const int64_t c = o / (p->o / p->groups), in = p->h * p->w, out = j->out_h * j->out_w;
    double sums[LT_DEPTHWISE_TAPS * LT_DEPTHWISE_LANES];

    memset(sums, 0, (size_t)j->strips.taps * LT_DEPTHWISE_LANES * sizeof(*sums));
    for (int64_t i = from; i < to; i++) {
        const lt_real *x = j->x + (i * p->c + c) * in, *dy = j->dy + (i * p->o + o) * out;

        lt_k->depthwise_weights(sums, x, dy, &j->strips, x + (i + 1 < to ? p->c * in : in),
                                dy + (i + 1 < to ? p->o * out : out));
    }
    for (int t = 0; t < j->strips.taps; t++)
        dw[j->strips.weight[t]] = sum_of_lanes(sums, t);
}

static void weights_rows(const job *j, int64_t o, int64_t from, int64_t to, lt_real *dw)
{
    const lt_conv2d_params *p = j->p;
    const int64_t c = o / (p->o / p->groups);
    weights_plane f = { .dw = dw };

    memset(dw, 0, (size_t)(p->kh * p->kw) * sizeof(lt_real));
    for (int64_t image = from; image < to; image++) {
        f.in = j->x + (image * p->c + c) * p->h * p->w;
        f.dy = j->dy + (image * p->o + o) * j->out_h * j->out_w;
        each_tap(j, weights_tap, &f);
    }
}

static void weights_task(void *ctx, int64_t task)
{
    const job *j = ctx;
    const lt_conv2d_params *p = j->p;
    const int64_t o = task % p->o, chunk = task / p->o;
    const int64_t from = chunk * p->n / j->chunks, to = (chunk + 1) * p->n / j->chunks;
    lt_real *dw = j->part + (chunk * p->o + o) * p->kh * p->kw;

    (j->in_strips ? weights_strips : weights_rows)(j, o, from, to, dw);
}

void lt_depthwise_backward_weights(const lt_conv2d_params *p, const lt_real *x, const lt_real *dy,
                                   int64_t chunks, lt_real *part)
{
    job j = { .p = p, .x = x, .dy = dy, .chunks = chunks, .part = part,
              .out_h = lt_conv2d_out_h(p), .out_w = lt_conv2d_out_w(p) };

    j.in_strips = plan_strips(&j.strips, p);
    lt_parallel_for(chunks * p->o, weights_task, &j);
}

/* ---- a map at a time --------------------------------------------------------------------------------------- */

/* Small maps go faster many at once. */
bool lt_depthwise_by_maps(lt_depthwise_maps *m, const lt_conv2d_params *p)
{
    enum { SMALL = 400 };
    const bool fits = p->h * p->w <= LT_SCRATCH_A && p->h * p->w <= LT_SCRATCH_B;

    m->p = *p;
    return p->groups == p->c && p->groups == p->o && lt_conv2d_out_h(p) * lt_conv2d_out_w(p) > SMALL && fits
           && plan_strips(&m->forward, p) && m->forward.window
           && (plan_up(&m->data, p) || (m->forward.step == 1 && plan_turned(&m->data, p)));
}

void lt_depthwise_map(const lt_depthwise_maps *m, const lt_real *x, const lt_real *w, lt_real *y)
{
    const lt_epilogue nothing = { 0 };

    lt_k->depthwise(y, NULL, x, w, &m->forward, &nothing, 1);
}

void lt_depthwise_map_data(const lt_depthwise_maps *m, const lt_real *dy, const lt_real *w, lt_real *dx)
{
    if (m->forward.step == 2)
        lt_k->depthwise_up(dx, dy, w, &m->data, false);
    else
        under_turned(dx, dy, w, &m->data);
}

void lt_depthwise_map_weights(const lt_depthwise_maps *m, double sums[LT_DEPTHWISE_SUMS], const lt_real *x,
                              const lt_real *dy, const lt_real *next_x, const lt_real *next_dy)
{
    lt_k->depthwise_weights(sums, x, dy, &m->forward, next_x, next_dy);
}

void lt_depthwise_sum_weights(const lt_depthwise_maps *m, const double sums[LT_DEPTHWISE_SUMS], lt_real *dw)
{
    for (int t = 0; t < m->forward.taps; t++)
        dw[m->forward.weight[t]] += sum_of_lanes(sums, t);
}
