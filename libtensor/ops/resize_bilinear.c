/* SPDX-License-Identifier: Apache-2.0 */
/* resize_bilinear: y_i = x at (i + 0.5) H / h - 0.5, between its two neighbours      [align_corners false]
 *   x (B, C, H, W)   ->   y (B, C, h, w)
 *   dx += dy with the same four weights
 */
#include "libtensor/ops/common.h"

typedef struct {
    int64_t h, w;
} resize_attr;

/* The neighbours of one output row or column, and the second one's weight. */
typedef struct {
    int32_t lo, hi;
    lt_real frac;
} tap;

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

static void plan(lt_call *c)
{
    const resize_attr *a = c->attr;

    c->work_bytes = (size_t)(a->h + a->w) * sizeof(tap);
}

static void fill_taps(tap *t, int64_t out, int64_t in)
{
    for (int64_t i = 0; i < out; i++) {
        const double src = ((double)i + 0.5) * (double)in / (double)out - 0.5;
        const double at = src > 0 ? src : 0;

        t[i].lo = (int32_t)lt_min_i64((int64_t)at, in - 1);
        t[i].hi = (int32_t)lt_min_i64(t[i].lo + 1, in - 1);
        t[i].frac = (lt_real)(at - (double)t[i].lo);
    }
}

static void fill(const lt_call *c)
{
    const resize_attr *a = c->attr;

    fill_taps(c->work, a->h, lt_dim(c->in[0], 2));
    fill_taps((tap *)c->work + a->h, a->w, lt_dim(c->in[0], 3));
}

static void forward_plane(const lt_call *c, int64_t i)
{
    const resize_attr *a = c->attr;
    const int64_t H = lt_dim(c->in[0], 2), W = lt_dim(c->in[0], 3);
    const tap *ty = c->work, *tx = ty + a->h;
    const lt_real *x = (const lt_real *)c->in[0]->data + i * H * W;
    lt_real *y = (lt_real *)c->out->data + i * a->h * a->w;

    for (int64_t r = 0; r < a->h; r++) {
        const lt_real *top = x + ty[r].lo * W, *bottom = x + ty[r].hi * W, fy = ty[r].frac;

        for (int64_t k = 0; k < a->w; k++) {
            const int32_t lo = tx[k].lo, hi = tx[k].hi;
            const lt_real fx = tx[k].frac, t = top[lo] + fx * (top[hi] - top[lo]);
            const lt_real b = bottom[lo] + fx * (bottom[hi] - bottom[lo]);

            y[r * a->w + k] = t + fy * (b - t);
        }
    }
}

static void forward(const lt_call *c)
{
    const resize_attr *a = c->attr;

    fill(c);
    op_by_row(c, op_outer(c->out, 2), 4 * a->h * a->w, forward_plane);
}

static void backward_plane(const lt_call *c, int64_t i)
{
    const resize_attr *a = c->attr;
    const int64_t H = lt_dim(c->in[0], 2), W = lt_dim(c->in[0], 3);
    const tap *ty = c->work, *tx = ty + a->h;
    const lt_real *dy = c->dout + i * a->h * a->w;
    lt_real *dx = c->din[0] + i * H * W;

    op_start(c, 0, i * H * W, H * W);
    for (int64_t r = 0; r < a->h; r++)
        for (int64_t k = 0; k < a->w; k++) {
            const lt_real g = dy[r * a->w + k], b = g * ty[r].frac, t = g - b;
            lt_real *top = dx + ty[r].lo * W, *bottom = dx + ty[r].hi * W;

            top[tx[k].lo] += t - t * tx[k].frac;
            top[tx[k].hi] += t * tx[k].frac;
            bottom[tx[k].lo] += b - b * tx[k].frac;
            bottom[tx[k].hi] += b * tx[k].frac;
        }
}

static void backward(const lt_call *c)
{
    const resize_attr *a = c->attr;

    if (!c->din[0])
        return;
    fill(c);
    op_by_row(c, op_outer(c->out, 2), 4 * a->h * a->w, backward_plane);
}

static const lt_op resize_bilinear_op = {
    .name = "resize_bilinear", .flags = LT_OP_CHEAP | LT_OP_ASSIGNS, .keeps = LT_KEEP_NOTHING, .infer = infer, .plan = plan,
    .forward = forward, .backward = backward,
};

lt_tensor *(lt_resize_bilinear)(lt_tensor *x, int64_t h, int64_t w)
{
    const resize_attr a = { .h = h, .w = w };

    return lt_apply(&resize_bilinear_op, &a, sizeof(a), &x, 1);
}
