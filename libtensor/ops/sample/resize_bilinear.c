/* SPDX-License-Identifier: Apache-2.0 */
/* resize_bilinear: y_i = x at (i + 0.5) H / h - 0.5, between its two neighbours      [align_corners false]
 *   x (B, C, H, W)   ->   y (B, C, h, w)
 *   dx += dy with the same four weights
 */
#include "libtensor/ops/sample/resample.h"

enum { PLANES = 16 };               /* of a task */

typedef struct {
    int64_t h, w;
} resize_attr;

static lt_status infer(lt_call *c)
{
    const resize_attr *a = c->attr;

    if (lt_want_rank(c, 0, "input", 4))
        return LT_ESHAPE;
    if (a->h < 1 || a->w < 1 || lt_dim(c->in[0], 2) < 1 || lt_dim(c->in[0], 3) < 1)
        return lt_fail(c, "from %lld x %lld to %lld x %lld: a map may not be empty",
                       (long long)lt_dim(c->in[0], 2), (long long)lt_dim(c->in[0], 3), (long long)a->h,
                       (long long)a->w);
    c->out->shape = LT_SHAPE(lt_dim(c->in[0], 0), lt_dim(c->in[0], 1), a->h, a->w);
    return LT_OK;
}

/* The two axes, or the ways back, and who scales what to what */
typedef struct {
    const lt_call *c;
    resample_axis rows, cols;
} job;

/* An input is the neighbour of outputs within two of its cells, a half more at the border. */
static int64_t width_back(int64_t out, int64_t in)
{
    return lt_min_i64(out, 3 * lt_ceil_div(out, in) + 2);
}

static size_t axis_bytes(int64_t out, int64_t in)
{
    return resample_axis_bytes(out, 2) + resample_axis_bytes(in, width_back(out, in));
}

static int64_t tasks_of(const lt_call *c)
{
    return lt_ceil_div(op_outer(c->out, 2), PLANES);
}

/* work: each task's scratch, then the axes */
static int64_t scratch_of(const lt_call *c)
{
    const int64_t h = lt_dim(c->out, 2), w = lt_dim(c->out, 3), H = lt_dim(c->in[0], 2), W = lt_dim(c->in[0], 3);

    return lt_max_i64(resample_scratch(h, W, w, 2), resample_scratch(H, w, W, width_back(w, W)));
}

static void plan(lt_call *c)
{
    const resize_attr *a = c->attr;

    c->work_bytes = (size_t)(tasks_of(c) * scratch_of(c)) * sizeof(lt_real)
        + axis_bytes(a->h, lt_dim(c->in[0], 2)) + axis_bytes(a->w, lt_dim(c->in[0], 3));
}

static lt_real *scratch_at(const lt_call *c, int64_t task)
{
    return (lt_real *)c->work + task * scratch_of(c);
}

/* Fills memory with an axis, or the way back; returns what is behind it. */
static char *make_axis(char *memory, resample_axis *axis, int64_t out, int64_t in, bool back)
{
    resample_axis t = resample_axis_at(memory, out, 2);

    for (int64_t i = 0; i < out; i++) {
        const double src = ((double)i + 0.5) * (double)in / (double)out - 0.5, at = src > 0 ? src : 0;
        const int64_t lo = lt_min_i64((int64_t)at, in - 1), hi = lt_min_i64(lo + 1, in - 1);
        const double frac = lo == hi ? 0 : at - (double)lo;

        resample_weigh(&t, i, lo, 1 - frac);
        resample_weigh(&t, i, hi, frac);
    }
    memory += resample_axis_bytes(out, 2);
    *axis = t;
    if (!back)
        return memory;
    *axis = resample_axis_at(memory, in, width_back(out, in));
    resample_turn(axis, &t);
    return memory + resample_axis_bytes(in, axis->width);
}

static job make_job(const lt_call *c, bool back)
{
    const resize_attr *a = c->attr;
    job j = { .c = c };

    make_axis(make_axis((char *)scratch_at(c, tasks_of(c)), &j.rows, a->h, lt_dim(c->in[0], 2), back), &j.cols,
              a->w, lt_dim(c->in[0], 3), back);
    return j;
}

static void forward_task(void *ctx, int64_t task)
{
    const job *j = ctx;
    const lt_call *c = j->c;
    const int64_t first = task * PLANES, n = lt_min_i64(PLANES, op_outer(c->out, 2) - first);

    resample_planes(&j->rows, &j->cols, (const lt_real *)c->in[0]->data + first * op_inner(c->in[0], 1),
                    lt_dim(c->in[0], 2), lt_dim(c->in[0], 3), (lt_real *)c->out->data + first * op_inner(c->out, 1), n,
                    false, scratch_at(c, task));
}

static void forward(const lt_call *c)
{
    job j = make_job(c, false);

    lt_parallel_for(tasks_of(c), forward_task, &j);
}

static void backward_task(void *ctx, int64_t task)
{
    const job *j = ctx;
    const lt_call *c = j->c;
    const int64_t first = task * PLANES, n = lt_min_i64(PLANES, op_outer(c->out, 2) - first);

    resample_planes(&j->rows, &j->cols, c->dout + first * op_inner(c->out, 1), lt_dim(c->out, 2), lt_dim(c->out, 3),
                    c->din[0] + first * op_inner(c->in[0], 1), n, !c->fresh[0], scratch_at(c, task));
}

static void backward(const lt_call *c)
{
    job j;

    if (!c->din[0])
        return;
    j = make_job(c, true);
    lt_parallel_for(tasks_of(c), backward_task, &j);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const resize_attr *a = n->attr;
    const char *x = lt_onnx_of(w, n->in[0]), *size, *planes;

    if (lt_onnx_dim(w, n->in[0], 0) < 0) {
        planes = LT_ONNX(w, "Shape", x);
        lt_onnx_int(w, "end", 2);
        size = LT_ONNX(w, "Concat", planes, lt_onnx_indices(w, (int64_t[]){ a->h, a->w }, 2));
        lt_onnx_int(w, "axis", 0);
    } else {
        size = lt_onnx_indices(w, n->outs[0]->shape.dim, 4);
    }
    lt_onnx_is(w, n->outs[0], LT_ONNX(w, "Resize", x, "", "", size));
    lt_onnx_text_of(w, "mode", "linear");
    lt_onnx_text_of(w, "coordinate_transformation_mode", "half_pixel");
}

static const lt_op resize_bilinear_op = {
    .name = "resize_bilinear", .flags = LT_OP_CHEAP | LT_OP_ASSIGNS, .keeps = LT_KEEP_NOTHING, .infer = infer,
    .plan = plan, .forward = forward, .backward = backward, .onnx = onnx,
};

lt_tensor *(lt_resize_bilinear)(lt_tensor *x, int64_t h, int64_t w)
{
    const resize_attr a = { .h = h, .w = w };

    return lt_apply(&resize_bilinear_op, &a, sizeof(a), &x, 1);
}
