/* SPDX-License-Identifier: Apache-2.0 */
/* window_means: what each tap of a 3 x 3 convolution with padding 1 sees of a map, in the mean.
 *   x (B, C, h, w), resized to H x W as resize_bilinear does   ->   y (B, C, 3, 3)
 *   y[ky][kx] = the mean over rows [max(0, ky - 1), H - max(0, 1 - ky)) and columns likewise
 *
 * The mean of conv(x, w) is then sum of w[ky][kx] y[ky][kx] times the share of positions where that tap lies
 * inside, without the convolution. The means are linear in x, so those of a sum of maps, or of a 1 x 1
 * convolution with a bias, are the sum and the convolution of means.
 *   dx[i][j] += the sum over ky, kx of dy[ky][kx] times what x[i][j] weighs in y[ky][kx]
 */
#include "libtensor/ops/common.h"

enum { TAPS = 3 };

typedef struct {
    int64_t H, W;
} window_attr;

static lt_status infer(lt_call *c)
{
    const window_attr *a = c->attr;

    if (lt_want_rank(c, 0, "input", 4))
        return LT_ESHAPE;
    if (a->H < 2 || a->W < 2 || lt_dim(c->in[0], 2) < 1 || lt_dim(c->in[0], 3) < 1)
        return lt_fail(c, "from %lld x %lld to %lld x %lld: want a map, and 2 x 2 at least",
                       (long long)lt_dim(c->in[0], 2), (long long)lt_dim(c->in[0], 3), (long long)a->H,
                       (long long)a->W);
    c->out->shape = LT_SHAPE(lt_dim(c->in[0], 0), lt_dim(c->in[0], 1), TAPS, TAPS);
    return LT_OK;
}

/* work: the weights of rows [3][h] and of columns [3][w], then three rows of each plane */
static void plan(lt_call *c)
{
    const lt_tensor *x = c->in[0];
    const int64_t planes = lt_dim(x, 0) * lt_dim(x, 1);

    c->work_bytes = (size_t)(TAPS * (lt_dim(x, 2) + lt_dim(x, 3) * (planes + 1))) * sizeof(lt_real);
}

/* weight[k][i]: the share of input i of n in the mean of the resized axis over what tap k sees. */
static void weigh_axis(lt_real *weight, int64_t n, int64_t resized)
{
    memset(weight, 0, (size_t)(TAPS * n) * sizeof(*weight));
    for (int64_t i = 0; i < resized; i++) {
        const double at = fmax(0, ((double)i + 0.5) * (double)n / (double)resized - 0.5);
        const int64_t lo = lt_min_i64((int64_t)at, n - 1), hi = lt_min_i64(lo + 1, n - 1);
        const double frac = lo == hi ? 0 : at - (double)lo;

        for (int k = 0; k < TAPS; k++) {
            const int64_t seen = k == 1 ? resized : resized - 1;

            if ((k == 0 && i == resized - 1) || (k == 2 && i == 0))
                continue;
            weight[k * n + lo] += (lt_real)((1 - frac) / (double)seen);
            weight[k * n + hi] += (lt_real)(frac / (double)seen);
        }
    }
}

static void forward_plane(const lt_call *c, int64_t i)
{
    const int64_t h = lt_dim(c->in[0], 2), w = lt_dim(c->in[0], 3);
    const lt_real *rows = c->work, *cols = rows + TAPS * h;
    lt_real *mixed = (lt_real *)c->work + TAPS * (h + w * (i + 1));
    lt_real *y = (lt_real *)c->out->data + i * TAPS * TAPS;

    for (int k = 0; k < TAPS; k++)
        lt_k->combine(mixed + k * w, (const lt_real *)c->in[0]->data + i * h * w, w, rows + k * h, h, (size_t)w,
                      false);
    for (int k = 0; k < TAPS * TAPS; k++)
        y[k] = (lt_real)lt_k->dot(mixed + k / TAPS * w, cols + k % TAPS * w, (size_t)w);
}

/* The same way back: each tap's row of weights, and those added to each row of the map */
static void backward_plane(const lt_call *c, int64_t i)
{
    const int64_t h = lt_dim(c->in[0], 2), w = lt_dim(c->in[0], 3);
    const lt_real *rows = c->work, *cols = rows + TAPS * h, *dy = c->dout + i * TAPS * TAPS;
    lt_real *mixed = (lt_real *)c->work + TAPS * (h + w * (i + 1)), *dx = c->din[0] + i * h * w;

    for (int k = 0; k < TAPS; k++)
        lt_k->combine(mixed + k * w, cols, w, dy + k * TAPS, TAPS, (size_t)w, false);
    for (int64_t y = 0; y < h; y++)
        lt_k->combine(dx + y * w, mixed, w, (lt_real[]){ rows[y], rows[h + y], rows[2 * h + y] }, TAPS, (size_t)w,
                      !c->fresh[0]);
}

static void by_plane(const lt_call *c, op_row_fn fn)
{
    const window_attr *a = c->attr;
    const int64_t h = lt_dim(c->in[0], 2), w = lt_dim(c->in[0], 3);

    weigh_axis(c->work, h, a->H);
    weigh_axis((lt_real *)c->work + TAPS * h, w, a->W);
    op_by_row(c, lt_dim(c->in[0], 0) * lt_dim(c->in[0], 1), TAPS * h * w, fn);
}

static void forward(const lt_call *c) { by_plane(c, forward_plane); }
static void backward(const lt_call *c) { by_plane(c, backward_plane); }

static const lt_op window_means_op = {
    .name = "window_means", .flags = LT_OP_ASSIGNS, .infer = infer, .plan = plan, .forward = forward,
    .backward = backward,
};

lt_tensor *(lt_window_means)(lt_tensor *x, int64_t H, int64_t W)
{
    const window_attr a = { H, W };

    return lt_apply(&window_means_op, &a, sizeof(a), &x, 1);
}
