/* SPDX-License-Identifier: Apache-2.0 */
/* sh_colour: colour by direction.                                      [Kerbl et al. 2023; Ramamoorthi 2001]
 *   sh (N, 16, 3)   direction v (N, 3)   degree   ->   y (N, 3) = max(0, 1/2 + sum_k b_k(d) sh_k), d = v / |v|
 *   dsh_k += b_k g     dv += (h - d (d . h)) / |v|, h = sum_k grad b_k (sh_k . g)     g = dy where y > 0, else 0
 *
 * A block of Gaussians at a time, turned: each coefficient, and each basis function, is a row over them.
 */
#include "libtensor/geometry/harmonics.h"
#include "libtensor/ops/splat/rows.h"

enum { SH, DIRECTION, DEGREE };
enum { BASIS = 16, COLOURS = 3, COEFFICIENTS = BASIS * COLOURS, BLOCK = SPLAT_ROWS };

static lt_status infer(lt_call *c)
{
    char text[LT_SHAPE_TEXT];
    int64_t N;

    if (lt_want_rank(c, SH, "sh", 3))
        return LT_ESHAPE;
    N = lt_dim(c->in[SH], 0);
    if (lt_want_shape(c, SH, "sh", LT_SHAPE(N, BASIS, COLOURS))
        || lt_want_shape(c, DIRECTION, "direction", LT_SHAPE(N, 3)))
        return LT_ESHAPE;
    if (c->in[DEGREE]->dtype != LT_I32 || lt_numel(c->in[DEGREE]) != 1)
        return lt_fail(c, "degree is %s%s, want one integer", lt_shape_text(&c->in[DEGREE]->shape, text),
                       c->in[DEGREE]->dtype == LT_I32 ? "" : " and no LT_I32");
    c->out->shape = LT_SHAPE(N, 3);
    return LT_OK;
}

static int active(const lt_call *c)
{
    const int32_t degree = *(const int32_t *)c->in[DEGREE]->data;
    const int d = degree < 0 ? 0 : degree > 3 ? 3 : degree;

    return (d + 1) * (d + 1);
}

/* Factors of the basis functions */
#define C1 ((lt_real)0.4886025119029199)
static const lt_real C2[5] = {
    (lt_real)1.0925484305920792, (lt_real)-1.0925484305920792, (lt_real)0.31539156525252005,
    (lt_real)-1.0925484305920792, (lt_real)0.5462742152960396,
};
static const lt_real C3[7] = {
    (lt_real)-0.5900435899266435, (lt_real)2.890611442640554, (lt_real)-0.4570457994644658,
    (lt_real)0.3731763325901154, (lt_real)-0.4570457994644658, (lt_real)1.445305721320277,
    (lt_real)-0.5900435899266435,
};

/* Unit directions of a block, and 1 / |v|; both 0 where |v| is */
typedef struct {
    lt_real x[BLOCK], y[BLOCK], z[BLOCK], inverse[BLOCK];
} directions;

static void normalise(const lt_real *v, int64_t n, directions *d)
{
#pragma omp simd
    for (int64_t i = 0; i < n; i++) {
        const lt_real x = v[3 * i], y = v[3 * i + 1], z = v[3 * i + 2];
        const lt_real length = (lt_real)sqrt((double)(x * x + y * y + z * z));

        d->inverse[i] = length > 0 ? 1 / length : 0;
        d->x[i] = x * d->inverse[i];
        d->y[i] = y * d->inverse[i];
        d->z[i] = z * d->inverse[i];
    }
}

/* b_k of all directions. No direction has a constant alone: what is there of the others at (0, 0, 0) is 0. */
static void find_basis(const directions *d, int64_t n, lt_real b[BASIS][BLOCK])
{
#pragma omp simd
    for (int64_t i = 0; i < n; i++) {
        const lt_real x = d->x[i], y = d->y[i], z = d->z[i], xx = x * x, yy = y * y, zz = z * z;

        b[0][i] = (lt_real)LT_SH_C0;
        b[1][i] = -C1 * y, b[2][i] = C1 * z, b[3][i] = -C1 * x;
        b[4][i] = C2[0] * x * y, b[5][i] = C2[1] * y * z, b[6][i] = C2[2] * (2 * zz - xx - yy);
        b[7][i] = C2[3] * x * z, b[8][i] = C2[4] * (xx - yy);
        b[9][i] = C3[0] * y * (3 * xx - yy), b[10][i] = C3[1] * x * y * z, b[11][i] = C3[2] * y * (4 * zz - xx - yy);
        b[12][i] = C3[3] * z * (2 * zz - 3 * xx - 3 * yy), b[13][i] = C3[4] * x * (4 * zz - xx - yy);
        b[14][i] = C3[5] * z * (xx - yy), b[15][i] = C3[6] * x * (xx - 3 * yy);
    }
}

/* The coefficients of a block that count, a row each */
static void turn_coefficients(const lt_real *sh, int count, int64_t n, lt_real t[COEFFICIENTS][BLOCK])
{
    lt_k->turn(t[0], BLOCK, sh, COEFFICIENTS, n, COLOURS * count, false);
}

static void forward_block(const lt_call *c, int64_t from, int64_t to)
{
    const int64_t n = to - from;
    const int count = active(c);
    lt_real t[COEFFICIENTS][BLOCK], b[BASIS][BLOCK], sum[COLOURS][BLOCK];
    directions d;

    normalise((const lt_real *)c->in[DIRECTION]->data + 3 * from, n, &d);
    find_basis(&d, n, b);
    turn_coefficients((const lt_real *)c->in[SH]->data + COEFFICIENTS * from, count, n, t);
    for (int a = 0; a < COLOURS; a++) {
        for (int64_t i = 0; i < n; i++)
            sum[a][i] = (lt_real)0.5;
        for (int k = 0; k < count; k++)
            lt_k->mul_to(sum[a], b[k], t[COLOURS * k + a], (size_t)n);
        for (int64_t i = 0; i < n; i++)
            sum[a][i] = sum[a][i] < 0 ? 0 : sum[a][i];
    }
    lt_k->turn((lt_real *)c->out->data + COLOURS * from, COLOURS, sum[0], BLOCK, COLOURS, n, false);
}

/* g of each Gaussian, a row a colour */
static void pass_unclamped(const lt_real *y, const lt_real *dy, int64_t n, lt_real g[COLOURS][BLOCK])
{
    for (int64_t i = 0; i < n; i++)
        for (int a = 0; a < COLOURS; a++)
            g[a][i] = y[3 * i + a] > 0 ? dy[3 * i + a] : 0;
}

static void sh_gradient(lt_real *dsh, int count, const directions *d, int64_t n, const lt_real g[COLOURS][BLOCK])
{
    lt_real t[COEFFICIENTS][BLOCK], back[BLOCK][COEFFICIENTS], b[BASIS][BLOCK];

    find_basis(d, n, b);
    for (int k = 0; k < count; k++)
        for (int a = 0; a < COLOURS; a++)
            lt_k->mul(t[COLOURS * k + a], b[k], g[a], (size_t)n);
    lt_k->turn(back[0], COEFFICIENTS, t[0], BLOCK, COLOURS * count, n, false);
    lt_k->add_lines(dsh, COEFFICIENTS, back[0], COEFFICIENTS, n, COLOURS * count);
}

/* w_k = sh_k . g, 0 from `count` on */
static void weigh(const lt_real *sh, int count, int64_t n, const lt_real g[COLOURS][BLOCK], lt_real w[BASIS][BLOCK])
{
    lt_real t[COEFFICIENTS][BLOCK];

    memset(w, 0, sizeof(lt_real[BASIS][BLOCK]));
    turn_coefficients(sh, count, n, t);
    for (int k = 1; k < count; k++)
        for (int a = 0; a < COLOURS; a++)
            lt_k->mul_to(w[k], t[COLOURS * k + a], g[a], (size_t)n);
}

/* dv += (h - d (d . h)) / |v|, where h = sum over k of w_k grad b_k */
static void direction_gradient(lt_real *dv, const directions *d, int64_t n, const lt_real w[BASIS][BLOCK])
{
#pragma omp simd
    for (int64_t i = 0; i < n; i++) {
        const lt_real x = d->x[i], y = d->y[i], z = d->z[i], xx = x * x, yy = y * y, zz = z * z;
        const lt_real w4 = C2[0] * w[4][i], w5 = C2[1] * w[5][i], w6 = C2[2] * w[6][i], w7 = C2[3] * w[7][i];
        const lt_real w8 = C2[4] * w[8][i], w9 = C3[0] * w[9][i], w10 = C3[1] * w[10][i], w11 = C3[2] * w[11][i];
        const lt_real w12 = C3[3] * w[12][i], w13 = C3[4] * w[13][i], w14 = C3[5] * w[14][i];
        const lt_real w15 = C3[6] * w[15][i];
        const lt_real hx = -C1 * w[3][i] + w4 * y - 2 * w6 * x + w7 * z + 2 * w8 * x + 6 * w9 * x * y + w10 * y * z
                         - 2 * w11 * x * y - 6 * w12 * x * z + w13 * (4 * zz - 3 * xx - yy) + 2 * w14 * x * z
                         + 3 * w15 * (xx - yy);
        const lt_real hy = -C1 * w[1][i] + w4 * x + w5 * z - 2 * w6 * y - 2 * w8 * y + 3 * w9 * (xx - yy) + w10 * x * z
                         + w11 * (4 * zz - xx - 3 * yy) - 6 * w12 * y * z - 2 * w13 * x * y - 2 * w14 * y * z
                         - 6 * w15 * x * y;
        const lt_real hz = C1 * w[2][i] + w5 * y + 4 * w6 * z + w7 * x + w10 * x * y + 8 * w11 * y * z
                         + w12 * (6 * zz - 3 * xx - 3 * yy) + 8 * w13 * x * z + w14 * (xx - yy);
        const lt_real along = x * hx + y * hy + z * hz;

        dv[3 * i] += (hx - x * along) * d->inverse[i];
        dv[3 * i + 1] += (hy - y * along) * d->inverse[i];
        dv[3 * i + 2] += (hz - z * along) * d->inverse[i];
    }
}

static void backward_block(const lt_call *c, int64_t from, int64_t to)
{
    const lt_real *sh = (const lt_real *)c->in[SH]->data + COEFFICIENTS * from;
    const int64_t n = to - from;
    lt_real g[COLOURS][BLOCK], w[BASIS][BLOCK];
    directions d;

    normalise((const lt_real *)c->in[DIRECTION]->data + 3 * from, n, &d);
    pass_unclamped((const lt_real *)c->out->data + 3 * from, c->dout + 3 * from, n, g);
    if (c->din[SH])
        sh_gradient(c->din[SH] + COEFFICIENTS * from, active(c), &d, n, (const lt_real (*)[BLOCK])g);
    if (!c->din[DIRECTION])
        return;
    weigh(sh, active(c), n, (const lt_real (*)[BLOCK])g, w);
    direction_gradient(c->din[DIRECTION] + 3 * from, &d, n, (const lt_real (*)[BLOCK])w);
}

static void forward(const lt_call *c)
{
    splat_by_block(c, lt_dim(c->in[SH], 0), forward_block);
}

static void backward(const lt_call *c)
{
    splat_by_block(c, lt_dim(c->in[SH], 0), backward_block);
}

static const lt_op sh_colour_op = {
    .name = "sh_colour", .any_type = LT_ANY_TYPE_IN(DEGREE), .infer = infer, .forward = forward, .backward = backward,
};

lt_tensor *(lt_sh_colour)(lt_tensor *sh, lt_tensor *direction, lt_tensor *degree)
{
    return lt_apply(&sh_colour_op, NULL, 0, (lt_tensor *[]){ sh, direction, degree }, 3);
}
