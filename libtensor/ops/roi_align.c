/* SPDX-License-Identifier: Apache-2.0 */
/* roi_align: a fixed grid of averaged bilinear samples out of each box      [He et al. 2017, section 3]
 *   x (B, C, H, W)   boxes (R, 5)   ->   y (R, C, out_h, out_w)
 *   dx += dy with the same weights; boxes get no gradient
 *
 * A bin's mean over its n_y x n_x bilinear samples is separable: along each axis an output index is a
 * weighted sum over a short run of map rows (columns). So each box needs two small tables, a plane is
 * first pooled along x for all its rows, then along y.
 */
#include "libtensor/ops/common.h"

enum { X, BOXES };
enum { CHANNELS = 16, MAX_SAMPLES = 64, MAX_RUN = 2 * MAX_SAMPLES + 2 };

typedef struct {
    int out_h, out_w;
    double scale;
} roi_attr;

/* Output i of an axis is the sum of weight[k] * map[first + k]. */
typedef struct {
    int32_t first, count;
    lt_real weight[MAX_RUN];
} run;

static lt_status infer(lt_call *c)
{
    const roi_attr *a = c->attr;
    char text[LT_SHAPE_TEXT];

    if (lt_want_rank(c, X, "map", 4) || lt_want_rank(c, BOXES, "boxes", 2))
        return LT_ESHAPE;
    if (lt_dim(c->in[BOXES], 1) != 5)
        return lt_fail(c, "boxes are %s, want (R, 5)", lt_shape_text(&c->in[BOXES]->shape, text));
    if (lt_dim(c->in[X], 2) < 1 || lt_dim(c->in[X], 3) < 1)
        return lt_fail(c, "the map is empty");
    if (a->out_h < 1 || a->out_w < 1 || !(a->scale > 0) || isinf(a->scale))
        return lt_fail(c, "output %d x %d, scale %g: want sizes of at least 1 and a scale above 0", a->out_h,
                       a->out_w, a->scale);
    c->out->shape = LT_SHAPE(lt_dim(c->in[BOXES], 0), lt_dim(c->in[X], 1), a->out_h, a->out_w);
    return LT_OK;
}

static int64_t blocks_of(const lt_call *c)
{
    return lt_ceil_div(lt_dim(c->in[X], 1), CHANNELS);
}

/* A task's scratch: the two tables, and a plane pooled along x. */
static size_t scratch_bytes(const lt_call *c)
{
    const roi_attr *a = c->attr;

    return (size_t)(a->out_h + a->out_w) * sizeof(run)
        + (size_t)(lt_dim(c->in[X], 2) * a->out_w) * sizeof(lt_real);
}

static void plan(lt_call *c)
{
    c->work_bytes = (size_t)(lt_dim(c->in[BOXES], 0) * blocks_of(c)) * scratch_bytes(c);
}

/* Samples less than a pixel outside the map count as on its border; further out they are 0. */
static void add_sample(run *r, double at, int64_t n, double weight)
{
    int32_t lo, hi;
    double frac;

    if (at < -1 || at > (double)n)
        return;
    at = at > 0 ? at : 0;
    lo = (int32_t)lt_min_i64((int64_t)at, n - 1);
    hi = (int32_t)lt_min_i64(lo + 1, n - 1);
    frac = lo == hi ? 0 : at - (double)lo;
    if (r->count == 0)
        r->first = lo;
    if (hi - r->first >= MAX_RUN)
        return;
    for (; r->count <= hi - r->first; r->count++)
        r->weight[r->count] = 0;
    r->weight[lo - r->first] += (lt_real)(weight * (1 - frac));
    r->weight[hi - r->first] += (lt_real)(weight * frac);
}

static void fill_runs(run *r, int out, double start, double end, int64_t n)
{
    const double size = end - start > 1 ? end - start : 1, bin = size / out;
    const int samples = (int)lt_min_i64(MAX_SAMPLES, (int64_t)ceil(bin < MAX_SAMPLES ? bin : MAX_SAMPLES));

    for (int i = 0; i < out; i++) {
        r[i].first = r[i].count = 0;
        for (int k = 0; k < samples; k++)
            add_sample(&r[i], start + i * bin + (k + 0.5) * bin / samples, n, 1.0 / samples);
    }
}

/* The image of box r, or -1 for a box that pools zeros. */
static int64_t image_of(const lt_call *c, const lt_real *box)
{
    for (int i = 0; i < 5; i++)
        if (!isfinite(box[i]))
            return -1;
    return box[0] >= 0 && box[0] < (lt_real)lt_dim(c->in[X], 0) ? (int64_t)box[0] : -1;
}

typedef struct {
    run *y, *x;
    lt_real *strip;                 /* (H, out_w) */
    int64_t image, H, W;
    int out_h, out_w;
} bins;

static bins bins_of(const lt_call *c, int64_t r, int64_t task)
{
    const roi_attr *a = c->attr;
    const lt_real *box = (const lt_real *)c->in[BOXES]->data + 5 * r;
    bins b = {
        .y = (run *)(void *)((char *)c->work + (size_t)task * scratch_bytes(c)), .image = image_of(c, box),
        .H = lt_dim(c->in[X], 2), .W = lt_dim(c->in[X], 3), .out_h = a->out_h, .out_w = a->out_w,
    };

    b.x = b.y + a->out_h;
    b.strip = (lt_real *)(void *)(b.x + a->out_w);
    if (b.image >= 0) {
        fill_runs(b.y, a->out_h, box[2] * a->scale, box[4] * a->scale, b.H);
        fill_runs(b.x, a->out_w, box[1] * a->scale, box[3] * a->scale, b.W);
    }
    return b;
}

/* The rows of the map that the box reads: [lo, hi). */
static void rows_of(const bins *b, int64_t *lo, int64_t *hi)
{
    *lo = b->H;
    *hi = 0;
    for (int i = 0; i < b->out_h; i++) {
        if (b->y[i].count == 0)
            continue;
        *lo = lt_min_i64(*lo, b->y[i].first);
        *hi = lt_max_i64(*hi, b->y[i].first + b->y[i].count);
    }
}

static void pool_plane(const bins *b, const lt_real *x, lt_real *y)
{
    int64_t lo, hi;

    rows_of(b, &lo, &hi);
    for (int64_t r = lo; r < hi; r++)
        for (int j = 0; j < b->out_w; j++) {
            const run *t = &b->x[j];
            lt_real sum = 0;

            for (int k = 0; k < t->count; k++)
                sum += t->weight[k] * x[r * b->W + t->first + k];
            b->strip[r * b->out_w + j] = sum;
        }
    memset(y, 0, (size_t)(b->out_h * b->out_w) * sizeof(*y));
    for (int i = 0; i < b->out_h; i++)
        for (int k = 0; k < b->y[i].count; k++)
            lt_k->axpy(y + i * b->out_w, b->y[i].weight[k], b->strip + (b->y[i].first + k) * b->out_w,
                       (size_t)b->out_w);
}

static void forward_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const int64_t C = lt_dim(c->in[X], 1), r = task / blocks_of(c), first = task % blocks_of(c) * CHANNELS;
    const bins b = bins_of(c, r, task);
    const int64_t in = b.H * b.W, out = b.out_h * b.out_w;

    for (int64_t ch = first; ch < lt_min_i64(C, first + CHANNELS); ch++) {
        lt_real *y = (lt_real *)c->out->data + (r * C + ch) * out;

        if (b.image < 0)
            memset(y, 0, (size_t)out * sizeof(*y));
        else
            pool_plane(&b, (const lt_real *)c->in[X]->data + (b.image * C + ch) * in, y);
    }
}

static void forward(const lt_call *c)
{
    lt_parallel_for(lt_dim(c->in[BOXES], 0) * blocks_of(c), forward_task, (void *)c);
}

static void spread_plane(const bins *b, const lt_real *dy, lt_real *dx)
{
    int64_t lo, hi;

    rows_of(b, &lo, &hi);
    memset(b->strip, 0, (size_t)(b->H * b->out_w) * sizeof(*b->strip));
    for (int i = 0; i < b->out_h; i++)
        for (int k = 0; k < b->y[i].count; k++)
            lt_k->axpy(b->strip + (b->y[i].first + k) * b->out_w, b->y[i].weight[k], dy + i * b->out_w,
                       (size_t)b->out_w);
    for (int64_t r = lo; r < hi; r++)
        for (int j = 0; j < b->out_w; j++)
            for (int k = 0; k < b->x[j].count; k++)
                dx[r * b->W + b->x[j].first + k] += b->x[j].weight[k] * b->strip[r * b->out_w + j];
}

/* A task owns some channels of every image and takes the boxes in their order. */
static void backward_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const int64_t C = lt_dim(c->in[X], 1), first = task * CHANNELS;
    const int64_t plane = lt_dim(c->in[X], 2) * lt_dim(c->in[X], 3), n = lt_min_i64(CHANNELS, C - first);

    for (int64_t b = 0; b < lt_dim(c->in[X], 0); b++)
        op_start(c, X, (b * C + first) * plane, n * plane);
    for (int64_t r = 0; r < lt_dim(c->in[BOXES], 0); r++) {
        const bins b = bins_of(c, r, task);
        const int64_t in = b.H * b.W, out = b.out_h * b.out_w;

        for (int64_t ch = first; b.image >= 0 && ch < lt_min_i64(C, first + CHANNELS); ch++)
            spread_plane(&b, c->dout + (r * C + ch) * out, c->din[X] + (b.image * C + ch) * in);
    }
}

static void backward(const lt_call *c)
{
    if (c->din[X])
        lt_parallel_for(blocks_of(c), backward_task, (void *)c);
}

static const lt_op roi_align_op = {
    .name = "roi_align", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(BOXES), .infer = infer, .plan = plan,
    .forward = forward, .backward = backward,
};

lt_tensor *(lt_roi_align)(lt_tensor *x, lt_tensor *boxes, int out_h, int out_w, double scale)
{
    const roi_attr a = { out_h, out_w, scale };

    return lt_apply(&roi_align_op, &a, sizeof(a), (lt_tensor *[]){ x, boxes }, 2);
}
