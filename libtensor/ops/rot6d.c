/* SPDX-License-Identifier: Apache-2.0 */
/* rot6d: two 3-vectors become a rotation matrix.                          [Zhou et al. 2019, section 4.2]
 *   (a1, a2) (..., 6)   ->   R (..., 3, 3) with columns
 *   b1 = a1 / |a1|      u = a2 - (b1 . a2) b1      b2 = u / |u|      b3 = b1 x b2
 *
 * Lengths below 1e-12 count as 1e-12.
 */
#include "libtensor/ops/common.h"

static lt_status infer(lt_call *c)
{
    const lt_shape *x = &c->in[0]->shape;
    char text[LT_SHAPE_TEXT];

    if (x->rank < 1 || x->rank >= LT_MAX_RANK || lt_dim(c->in[0], -1) != 6)
        return lt_fail(c, "its input is %s, want (..., 6)", lt_shape_text(x, text));
    c->out->shape = *x;
    c->out->shape.rank = x->rank + 1;
    c->out->shape.dim[x->rank - 1] = c->out->shape.dim[x->rank] = 3;
    return LT_OK;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double y[3], const double a[3], const double b[3])
{
    y[0] = a[1] * b[2] - a[2] * b[1];
    y[1] = a[2] * b[0] - a[0] * b[2];
    y[2] = a[0] * b[1] - a[1] * b[0];
}

static double length(const double a[3])
{
    return fmax(sqrt(dot(a, a)), 1e-12);
}

typedef struct {
    double a2[3], b1[3], b2[3], b3[3], n1, n2, d;
} frame;

static frame frame_of(const lt_real *x)
{
    frame f;
    double u[3];

    for (int i = 0; i < 3; i++) {
        f.b1[i] = x[i];
        f.a2[i] = x[3 + i];
    }
    f.n1 = length(f.b1);
    for (int i = 0; i < 3; i++)
        f.b1[i] /= f.n1;
    f.d = dot(f.b1, f.a2);
    for (int i = 0; i < 3; i++)
        u[i] = f.a2[i] - f.d * f.b1[i];
    f.n2 = length(u);
    for (int i = 0; i < 3; i++)
        f.b2[i] = u[i] / f.n2;
    cross(f.b3, f.b1, f.b2);
    return f;
}

static void forward_one(const lt_call *c, int64_t k)
{
    const frame f = frame_of((const lt_real *)c->in[0]->data + 6 * k);
    lt_real *R = (lt_real *)c->out->data + 9 * k;

    for (int i = 0; i < 3; i++) {
        R[3 * i] = (lt_real)f.b1[i];
        R[3 * i + 1] = (lt_real)f.b2[i];
        R[3 * i + 2] = (lt_real)f.b3[i];
    }
}

/* y = (g - b (b . g)) / n: through the division of a vector by its length */
static void unit_gradient(double y[3], const double g[3], const double b[3], double n)
{
    const double along = dot(b, g);

    for (int i = 0; i < 3; i++)
        y[i] = (g[i] - b[i] * along) / n;
}

static void backward_one(const lt_call *c, int64_t k)
{
    const frame f = frame_of((const lt_real *)c->in[0]->data + 6 * k);
    const lt_real *dR = c->dout + 9 * k;
    lt_real *dx = c->din[0] + 6 * k;
    double g1[3], g2[3], g3[3], part[3], du[3], da1[3], along;

    for (int i = 0; i < 3; i++) {
        g1[i] = dR[3 * i];
        g2[i] = dR[3 * i + 1];
        g3[i] = dR[3 * i + 2];
    }
    cross(part, f.b2, g3);                              /* b3 = b1 x b2 */
    for (int i = 0; i < 3; i++)
        g1[i] += part[i];
    cross(part, g3, f.b1);
    for (int i = 0; i < 3; i++)
        g2[i] += part[i];
    unit_gradient(du, g2, f.b2, f.n2);
    along = dot(f.b1, du);
    for (int i = 0; i < 3; i++)                         /* u = a2 - (b1 . a2) b1 */
        g1[i] -= f.a2[i] * along + f.d * du[i];
    unit_gradient(da1, g1, f.b1, f.n1);
    for (int i = 0; i < 3; i++) {
        dx[i] += (lt_real)da1[i];
        dx[3 + i] += (lt_real)(du[i] - f.b1[i] * along);
    }
}

static void forward(const lt_call *c)
{
    op_by_row(c, lt_numel(c->in[0]) / 6, 100, forward_one);
}

static void backward(const lt_call *c)
{
    if (c->din[0])
        op_by_row(c, lt_numel(c->in[0]) / 6, 200, backward_one);
}

/* v / max(|v|, 1e-12) */
static const char *unit(lt_onnx *w, const char *v, int axis)
{
    const char *n = LT_ONNX(w, "Sqrt", lt_onnx_sum(w, LT_ONNX(w, "Mul", v, v), axis, true));

    return LT_ONNX(w, "Div", v, LT_ONNX(w, "Max", n, lt_onnx_number(w, 1e-12)));
}

static const char *cross_of(lt_onnx *w, const char *a, const char *b, int axis)
{
    static const int next[] = { 1, 2, 0 }, after[] = { 2, 0, 1 };
    const char *p = LT_ONNX(w, "Mul", lt_onnx_gather(w, a, axis, next, 3), lt_onnx_gather(w, b, axis, after, 3));
    const char *q = LT_ONNX(w, "Mul", lt_onnx_gather(w, a, axis, after, 3), lt_onnx_gather(w, b, axis, next, 3));

    return LT_ONNX(w, "Sub", p, q);
}

/* (..., 3) -> (..., 3, 1) */
static const char *upright(lt_onnx *w, const lt_tensor *x, const char *v)
{
    lt_shape shape = { .rank = x->shape.rank + 1 };

    for (int i = 0; i < x->shape.rank - 1; i++)
        shape.dim[i] = lt_onnx_dim(w, x, i);
    shape.dim[shape.rank - 2] = 3;
    shape.dim[shape.rank - 1] = 1;
    return lt_onnx_reshape(w, v, shape);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const lt_tensor *x = n->in[0];
    const int last = x->shape.rank - 1;
    const char *in = lt_onnx_of(w, x), *a2 = lt_onnx_slice(w, in, last, 3, 3), *b1, *b2, *along, *u;
    const char *column[3];

    b1 = unit(w, lt_onnx_slice(w, in, last, 0, 3), last);
    along = lt_onnx_sum(w, LT_ONNX(w, "Mul", b1, a2), last, true);
    u = LT_ONNX(w, "Sub", a2, LT_ONNX(w, "Mul", along, b1));
    b2 = unit(w, u, last);
    column[0] = upright(w, x, b1);
    column[1] = upright(w, x, b2);
    column[2] = upright(w, x, cross_of(w, b1, b2, last));
    lt_onnx_is(w, n->outs[0], lt_onnx_put(w, "Concat", column, 3));
    lt_onnx_int(w, "axis", -1);
}

static const lt_op rot6d_op = {
    .name = "rot6d", .keeps = LT_KEEP_IN(0), .infer = infer, .forward = forward, .backward = backward,
    .onnx = onnx,
};

lt_tensor *(lt_rot6d)(lt_tensor *x)
{
    return lt_apply(&rot6d_op, NULL, 0, &x, 1);
}
