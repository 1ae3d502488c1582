/* SPDX-License-Identifier: Apache-2.0 */
/* roi_align: a fixed grid of averaged bilinear samples out of each box      [He et al. 2017, section 3]
 *   x (B, C, H, W)   boxes (R, 5)   ->   y (R, C, out_h, out_w)
 *   dx += dy with the same weights; boxes get no gradient
 *
 * A bin's mean over its n_y x n_x bilinear samples is separable: along each axis an output index is a
 * weighted sum over a short run of map rows (columns). So each box has two small tables of its own, by which
 * all its planes are resampled (libtensor/ops/sample/resample.h).
 */
#include "libtensor/ops/sample/resample.h"

enum { X, BOXES };
enum { CHANNELS = 16, MAX_SAMPLES = 64 };

typedef struct {
    int out_h, out_w;
    double scale;
} roi_attr;

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

/* One box: its image, or -1 when it pools zeros; what bins read of the map, and what the map gives to bins */
typedef struct {
    int64_t image;
    resample_axis rows, cols, rows_back, cols_back;
} roi;

/* Everything of one axis: the table and the way back */
static size_t axis_bytes(int64_t out, int64_t in)
{
    return resample_axis_bytes(out, in) + resample_axis_bytes(in, out);
}

static size_t tables_bytes(const lt_call *c)
{
    const roi_attr *a = c->attr;

    return axis_bytes(a->out_h, lt_dim(c->in[X], 2)) + axis_bytes(a->out_w, lt_dim(c->in[X], 3));
}

/* Elements of a task's scratch, forward or backward */
static int64_t scratch_of(const lt_call *c)
{
    const roi_attr *a = c->attr;
    const int64_t H = lt_dim(c->in[X], 2), W = lt_dim(c->in[X], 3);

    return lt_max_i64(resample_scratch(a->out_h, W, a->out_w, W),
                      resample_scratch(H, a->out_w, W, a->out_w));
}

/* work: the boxes, their tables, each task's scratch */
static void plan(lt_call *c)
{
    const size_t R = (size_t)lt_dim(c->in[BOXES], 0);

    c->work_bytes = R * (sizeof(roi) + tables_bytes(c))
        + (R + 1) * (size_t)(blocks_of(c) * scratch_of(c)) * sizeof(lt_real);
}

static roi *rois(const lt_call *c)
{
    return c->work;
}

static char *tables_at(const lt_call *c, int64_t r)
{
    return (char *)(rois(c) + lt_dim(c->in[BOXES], 0)) + (size_t)r * tables_bytes(c);
}

static lt_real *scratch_at(const lt_call *c, int64_t task)
{
    return (lt_real *)(void *)tables_at(c, lt_dim(c->in[BOXES], 0)) + task * scratch_of(c);
}

/* Samples less than a pixel outside the map count as on its border; further out they are 0. */
static void add_sample(resample_axis *t, int64_t i, double at, int64_t n, double weight)
{
    int64_t lo, hi;
    double frac;

    if (at < -1 || at > (double)n)
        return;
    at = at > 0 ? at : 0;
    lo = lt_min_i64((int64_t)at, n - 1);
    hi = lt_min_i64(lo + 1, n - 1);
    frac = lo == hi ? 0 : at - (double)lo;
    resample_weigh(t, i, lo, weight * (1 - frac));
    resample_weigh(t, i, hi, weight * frac);
}

static void fill_axis(resample_axis *t, double start, double end, int64_t n)
{
    const double size = end - start > 1 ? end - start : 1, bin = size / (double)t->n;
    const int samples = (int)lt_min_i64(MAX_SAMPLES, (int64_t)ceil(bin < MAX_SAMPLES ? bin : MAX_SAMPLES));

    for (int64_t i = 0; i < t->n; i++)
        for (int k = 0; k < samples; k++)
            add_sample(t, i, start + (double)i * bin + (k + 0.5) * bin / samples, n, 1.0 / samples);
}

/* The image of box r, or -1 for a box that pools zeros. */
static int64_t image_of(const lt_call *c, const lt_real *box)
{
    for (int i = 0; i < 5; i++)
        if (!isfinite(box[i]))
            return -1;
    return box[0] >= 0 && box[0] < (lt_real)lt_dim(c->in[X], 0) ? (int64_t)box[0] : -1;
}

/* One axis in memory, with its way back; returns what is behind them. */
static char *make_axis(char *memory, resample_axis *t, resample_axis *back, int64_t out, int64_t in, double start,
                       double end)
{
    *t = resample_axis_at(memory, out, in);
    fill_axis(t, start, end, in);
    memory += resample_axis_bytes(out, in);
    *back = resample_axis_at(memory, in, out);
    resample_turn(back, t);
    return memory + resample_axis_bytes(in, out);
}

static void prepare_box(const lt_call *c, int64_t r)
{
    const roi_attr *a = c->attr;
    const lt_real *box = (const lt_real *)c->in[BOXES]->data + 5 * r;
    roi *b = rois(c) + r;
    char *memory = tables_at(c, r);

    b->image = image_of(c, box);
    if (b->image < 0)
        return;
    memory = make_axis(memory, &b->rows, &b->rows_back, a->out_h, lt_dim(c->in[X], 2), box[2] * a->scale,
                       box[4] * a->scale);
    make_axis(memory, &b->cols, &b->cols_back, a->out_w, lt_dim(c->in[X], 3), box[1] * a->scale,
              box[3] * a->scale);
}

static int64_t map_of(const lt_call *c)
{
    return lt_dim(c->in[X], 2) * lt_dim(c->in[X], 3);
}

static void forward_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const int64_t C = lt_dim(c->in[X], 1), r = task / blocks_of(c), first = task % blocks_of(c) * CHANNELS;
    const int64_t n = lt_min_i64(CHANNELS, C - first), out = op_inner(c->out, 1);
    lt_real *y = (lt_real *)c->out->data + (r * C + first) * out;
    const roi *b = rois(c) + r;

    if (b->image < 0)
        memset(y, 0, (size_t)(n * out) * sizeof(*y));
    else
        resample_planes(&b->rows, &b->cols, (const lt_real *)c->in[X]->data + (b->image * C + first) * map_of(c),
                        lt_dim(c->in[X], 2), lt_dim(c->in[X], 3), y, n, false, scratch_at(c, task));
}

static void forward(const lt_call *c)
{
    const int64_t R = lt_dim(c->in[BOXES], 0);

    op_by_row(c, R, 8 * map_of(c), prepare_box);
    lt_parallel_for(R * blocks_of(c), forward_task, (void *)c);
}

/* A task owns some channels of every image and takes the boxes in their order. */
static void backward_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const int64_t C = lt_dim(c->in[X], 1), first = task * CHANNELS, n = lt_min_i64(CHANNELS, C - first);
    const int64_t plane = map_of(c), out = op_inner(c->out, 1);

    for (int64_t b = 0; b < lt_dim(c->in[X], 0); b++)
        op_start(c, X, (b * C + first) * plane, n * plane);
    for (int64_t r = 0; r < lt_dim(c->in[BOXES], 0); r++) {
        const roi *b = rois(c) + r;

        if (b->image >= 0)
            resample_planes(&b->rows_back, &b->cols_back, c->dout + (r * C + first) * out, lt_dim(c->out, 2),
                            lt_dim(c->out, 3), c->din[X] + (b->image * C + first) * plane, n, true,
                            scratch_at(c, task));
    }
}

static void backward(const lt_call *c)
{
    if (!c->din[X])
        return;
    op_by_row(c, lt_dim(c->in[BOXES], 0), 8 * map_of(c), prepare_box);
    lt_parallel_for(blocks_of(c), backward_task, (void *)c);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const roi_attr *a = n->attr;
    const char *boxes = lt_onnx_of(w, n->in[BOXES]), *image, *y;

    image = LT_ONNX(w, "Cast", lt_onnx_reshape(w, lt_onnx_slice(w, boxes, 1, 0, 1), LT_SHAPE(-1)));
    lt_onnx_int(w, "to", LT_ONNX_INT64);
    y = LT_ONNX(w, "RoiAlign", lt_onnx_of(w, n->in[X]), lt_onnx_slice(w, boxes, 1, 1, 4), image);
    lt_onnx_text_of(w, "mode", "avg");
    lt_onnx_text_of(w, "coordinate_transformation_mode", "output_half_pixel");
    lt_onnx_int(w, "output_height", a->out_h);
    lt_onnx_int(w, "output_width", a->out_w);
    lt_onnx_int(w, "sampling_ratio", 0);                /* a bin's size rounded up */
    lt_onnx_float(w, "spatial_scale", a->scale);
    lt_onnx_is(w, n->outs[0], y);
}

static const lt_op roi_align_op = {
    .name = "roi_align", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(BOXES), .infer = infer, .plan = plan,
    .forward = forward, .backward = backward, .onnx = onnx,
};

lt_tensor *(lt_roi_align)(lt_tensor *x, lt_tensor *boxes, int out_h, int out_w, double scale)
{
    const roi_attr a = { out_h, out_w, scale };

    return lt_apply(&roi_align_op, &a, sizeof(a), (lt_tensor *[]){ x, boxes }, 2);
}
