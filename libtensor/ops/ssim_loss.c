/* SPDX-License-Identifier: Apache-2.0 */
/* ssim_loss: y = 1 - the mean of S over all pixels.                       [Wang et al. 2004, equation 13]
 *   a, b (C, H, W)   ->   y, one number; G* a window's weighted sum, zeros around the map
 *   S = A1 A2 / (B1 B2), A1 = 2 m n + C1, A2 = 2 G*(ab) - 2 m n + C2, B1 = m^2 + n^2 + C1,
 *       B2 = G*(aa) - m^2 + G*(bb) - n^2 + C2, with m = G*a, n = G*b
 *   da += -dy / (C H W) (G*P + 2 a G*Q + b G*R), the slopes of S by m, by G*(aa) and by G*(ab), G* being symmetric
 *
 * A row at a time: windows along it, then, of such rows, windows across. The other maps wait in the workspace.
 */
#include "libtensor/ops/common.h"

enum { A, B };
enum { RADIUS = 5, TAPS = 2 * RADIUS + 1 };
enum { WIDE = 256 };                            /* columns at a time, which stay in the first cache */
enum { M, N, AA, BB, AB, MAPS };                /* windows along rows of a, b and their products */
enum { P = MAPS, Q, R, ALL_MAPS };              /* slopes of S, on the way back */
enum { P_ALONG, Q_ALONG, R_ALONG };             /* their windows along rows, where M, N, AA were */

static const lt_real C1 = (lt_real)1e-4, C2 = (lt_real)9e-4;

/* A Gaussian of deviation 1.5, whose sum is 1 */
static const lt_real tap[TAPS] = {
    (lt_real)0.0010283801, (lt_real)0.0075987581, (lt_real)0.0360007721, (lt_real)0.1093606895,
    (lt_real)0.2130055377, (lt_real)0.2660117248, (lt_real)0.2130055377, (lt_real)0.1093606895,
    (lt_real)0.0360007721, (lt_real)0.0075987581, (lt_real)0.0010283801,
};

static int64_t width_of(const lt_call *c) { return lt_dim(c->in[A], 2); }
static int64_t height_of(const lt_call *c) { return lt_dim(c->in[A], 1); }
static int64_t rows_of(const lt_call *c) { return lt_dim(c->in[A], 0) * height_of(c); }

static lt_status infer(lt_call *c)
{
    if (lt_want_rank(c, A, "a", 3) || lt_want_shape(c, B, "b", c->in[A]->shape))
        return LT_ESHAPE;
    c->out->shape = (lt_shape){ 0 };
    return LT_OK;
}

static void plan(lt_call *c)
{
    c->work_bytes = (size_t)rows_of(c) * sizeof(double)
                  + (size_t)(c->train ? ALL_MAPS : MAPS) * (size_t)lt_numel(c->in[A]) * sizeof(lt_real);
}

static lt_real *map_row(const lt_call *c, int map, int64_t row)
{
    lt_real *maps = (lt_real *)((double *)c->work + rows_of(c));

    return maps + (map * rows_of(c) + row) * width_of(c);
}

static const lt_real *input_row(const lt_call *c, int i, int64_t row)
{
    return (const lt_real *)c->in[i]->data + row * width_of(c);
}

/* The taps from the outside in: sums that are small for longer are rounded less. */
static const int8_t inward[TAPS] = { -5, 5, -4, 4, -3, 3, -2, 2, -1, 1, 0 };

/* out[x] = the window around x of values u v; v NULL: of u */
static void along(lt_real *out, const lt_real *u, const lt_real *v, int64_t width)
{
    for (int64_t at = 0; at < width; at += WIDE) {
        const int64_t to = lt_min_i64(width, at + WIDE);
        const int64_t lo = lt_max_i64(0, at - RADIUS), hi = lt_min_i64(width, to + RADIUS);
        lt_real product[WIDE + 2 * RADIUS];
        const lt_real *x = u + lo;

        if (v) {
            lt_k->mul(product, u + lo, v + lo, (size_t)(hi - lo));
            x = product;
        }
        memset(out + at, 0, (size_t)(to - at) * sizeof(*out));
        for (int i = 0; i < TAPS; i++) {
            const int64_t k = inward[i], first = lt_max_i64(at, -k), last = lt_min_i64(to, width - k);

            if (first < last)
                lt_k->axpy(out + first, tap[k + RADIUS], x + (first + k - lo), (size_t)(last - first));
        }
    }
}

/* The windows across rows of a map, of n columns from x on */
static void across(const lt_call *c, int map, int64_t row, int64_t x, int64_t n, lt_real *out)
{
    const int64_t y = row % height_of(c), last = height_of(c) - 1;

    memset(out, 0, (size_t)n * sizeof(*out));
    for (int i = 0; i < TAPS; i++)
        if (y + inward[i] >= 0 && y + inward[i] <= last)
            lt_k->axpy(out, tap[inward[i] + RADIUS], map_row(c, map, row + inward[i]) + x, (size_t)n);
}

static void row_along(const lt_call *c, int64_t row)
{
    const lt_real *a = input_row(c, A, row), *b = input_row(c, B, row);
    const int64_t width = width_of(c);

    along(map_row(c, M, row), a, NULL, width);
    along(map_row(c, N, row), b, NULL, width);
    along(map_row(c, AA, row), a, a, width);
    along(map_row(c, BB, row), b, b, width);
    along(map_row(c, AB, row), a, b, width);
}

/* Windows of n columns from x on, and S of each of them */
typedef lt_real windows[MAPS][WIDE];

static void see(const lt_call *c, int64_t row, int64_t x, int64_t n, windows w)
{
    for (int i = 0; i < MAPS; i++)
        across(c, i, row, x, n, w[i]);
}

typedef struct {
    lt_real m, n, a1, a2, b1, b2, inverse, s;
} terms;

static terms terms_at(windows w, int64_t i)
{
    terms t = { .m = w[M][i], .n = w[N][i] };

    t.a1 = 2 * t.m * t.n + C1;
    t.a2 = 2 * w[AB][i] - 2 * t.m * t.n + C2;
    t.b1 = t.m * t.m + t.n * t.n + C1;
    t.b2 = w[AA][i] - t.m * t.m + w[BB][i] - t.n * t.n + C2;
    t.inverse = 1 / (t.b1 * t.b2);
    t.s = t.a1 * t.a2 * t.inverse;
    return t;
}

static void row_sum(const lt_call *c, int64_t row)
{
    double sum = 0;

    for (int64_t x = 0; x < width_of(c); x += WIDE) {
        const int64_t n = lt_min_i64(WIDE, width_of(c) - x);
        windows w;

        see(c, row, x, n, w);
        for (int64_t i = 0; i < n; i++)
            sum += (double)terms_at(w, i).s;
    }
    ((double *)c->work)[row] = sum;
}

static void row_slopes(const lt_call *c, int64_t row)
{
    for (int64_t x = 0; x < width_of(c); x += WIDE) {
        const int64_t n = lt_min_i64(WIDE, width_of(c) - x);
        lt_real *p = map_row(c, P, row) + x, *q = map_row(c, Q, row) + x, *r = map_row(c, R, row) + x;
        windows w;

        see(c, row, x, n, w);
        for (int64_t i = 0; i < n; i++) {
            const terms t = terms_at(w, i);
            const lt_real by_aa = -t.s * t.inverse * t.b1, by_ab = 2 * t.a1 * t.inverse;

            p[i] = 2 * t.n * t.a2 * t.inverse - 2 * t.m * t.s * t.inverse * t.b2 - t.n * by_ab - 2 * t.m * by_aa;
            q[i] = by_aa;
            r[i] = by_ab;
        }
    }
}

static void slopes_along(const lt_call *c, int64_t row)
{
    for (int i = P_ALONG; i <= R_ALONG; i++)
        along(map_row(c, i, row), map_row(c, P + i, row), NULL, width_of(c));
}

static void row_gradient(const lt_call *c, int64_t row)
{
    const lt_real f = -*c->dout / (lt_real)lt_numel(c->in[A]);
    const int64_t width = width_of(c);

    for (int64_t x = 0; x < width; x += WIDE) {
        const lt_real *a = input_row(c, A, row) + x, *b = input_row(c, B, row) + x;
        const int64_t n = lt_min_i64(WIDE, width - x);
        lt_real *da = c->din[A] + row * width + x, by_m[WIDE], by_aa[WIDE], by_ab[WIDE];

        across(c, P_ALONG, row, x, n, by_m);
        across(c, Q_ALONG, row, x, n, by_aa);
        across(c, R_ALONG, row, x, n, by_ab);
        for (int64_t i = 0; i < n; i++)
            da[i] += f * (by_m[i] + 2 * a[i] * by_aa[i] + b[i] * by_ab[i]);
    }
}

static void each_row(const lt_call *c, op_row_fn fn)
{
    op_by_row(c, rows_of(c), MAPS * TAPS * width_of(c), fn);
}

static void forward(const lt_call *c)
{
    double sum = 0;

    each_row(c, row_along);
    each_row(c, row_sum);
    for (int64_t i = 0; i < rows_of(c); i++)
        sum += ((const double *)c->work)[i];
    *(lt_real *)c->out->data = (lt_real)(lt_numel(c->in[A]) ? 1 - sum / (double)lt_numel(c->in[A]) : 0);
}

static void backward(const lt_call *c)
{
    if (!c->din[A])
        return;
    each_row(c, row_along);
    each_row(c, row_slopes);
    each_row(c, slopes_along);
    each_row(c, row_gradient);
}

static const lt_op ssim_loss_op = {
    .name = "ssim_loss", .keeps = LT_KEEP_IN(A) | LT_KEEP_IN(B), .infer = infer, .plan = plan, .forward = forward,
    .backward = backward,
};

lt_tensor *(lt_ssim_loss)(lt_tensor *a, lt_tensor *b)
{
    return lt_apply(&ssim_loss_op, NULL, 0, (lt_tensor *[]){ a, b }, 2);
}
