/* SPDX-License-Identifier: Apache-2.0 */
/* l2_normalise: y = x / (|x| + eps), |x| the length over the channels at each position
 *   x (B, C, ...)   ->   y (B, C, ...)
 *   dx += dy / (|x| + eps) - x (x . dy) / (|x| (|x| + eps)^2), and nothing where |x| is 0
 */
#include "libtensor/ops/norm/l2_normalise.h"

#include "libtensor/ops/common.h"

typedef struct {
    double eps;
} l2_attr;

void op_l2_normalise(lt_real *y, int64_t ld_y, lt_real *norm, const lt_real *x, int64_t ld_x, int64_t channels,
                     int64_t n, lt_real eps)
{
    lt_real sum[OP_L2_COLUMNS] = { 0 };

    for (int64_t c = 0; c < channels; c++)
        lt_k->mul_to(sum, x + c * ld_x, x + c * ld_x, (size_t)n);
    for (int64_t i = 0; i < n; i++) {
        const lt_real length = (lt_real)sqrt((double)sum[i]);

        if (norm)
            norm[i] = length;
        sum[i] = 1 / (length + eps);
    }
    for (int64_t c = 0; c < channels; c++)
        lt_k->mul(y + c * ld_y, x + c * ld_x, sum, (size_t)n);
}

void op_l2_normalise_grad(lt_real *dx, const lt_real *dy, const lt_real *x, const lt_real *norm, int64_t ld,
                          int64_t channels, int64_t n, lt_real eps)
{
    lt_real of_dy[OP_L2_COLUMNS], of_x[OP_L2_COLUMNS] = { 0 };

    for (int64_t c = 0; c < channels; c++)
        lt_k->mul_to(of_x, x + c * ld, dy + c * ld, (size_t)n);
    for (int64_t i = 0; i < n; i++) {
        const lt_real each = norm[i] > 0 ? 1 / (norm[i] + eps) : 0;

        of_dy[i] = each;
        of_x[i] = norm[i] > 0 ? -of_x[i] * each * each / norm[i] : 0;
    }
    for (int64_t c = 0; c < channels; c++) {
        lt_k->mul_to(dx + c * ld, of_dy, dy + c * ld, (size_t)n);
        lt_k->mul_to(dx + c * ld, of_x, x + c * ld, (size_t)n);
    }
}

static lt_status infer(lt_call *c)
{
    const l2_attr *a = c->attr;

    if (c->in[0]->shape.rank < 2)
        return lt_fail(c, "its input has %d dimensions, want a batch of channels at least", c->in[0]->shape.rank);
    if (!(a->eps > 0))
        return lt_fail(c, "eps is %g, want a number above 0", a->eps);
    return op_same_shape(c);
}

/* saved: the length at each position */
static void plan(lt_call *c)
{
    if (c->train)
        c->saved_bytes[0] = (size_t)(lt_dim(c->in[0], 0) * op_inner(c->in[0], 1)) * sizeof(lt_real);
}

/* Some positions of an image */
typedef struct {
    int64_t at, norm_at, channels, positions, n;        /* at: of the first channel's first element */
} piece;

static int64_t pieces_of(const lt_call *c)
{
    return lt_ceil_div(op_inner(c->in[0], 1), OP_L2_COLUMNS);
}

static piece piece_of(const lt_call *c, int64_t task)
{
    const int64_t P = op_inner(c->in[0], 1), C = lt_dim(c->in[0], 1);
    const int64_t image = task / pieces_of(c), from = task % pieces_of(c) * OP_L2_COLUMNS;

    return (piece){ image * C * P + from, image * P + from, C, P, lt_min_i64(OP_L2_COLUMNS, P - from) };
}

static lt_real eps_of(const lt_call *c)
{
    return (lt_real)((const l2_attr *)c->attr)->eps;
}

static lt_real *norm_of(const lt_call *c, const piece *p)
{
    return c->train ? (lt_real *)c->saved[0] + p->norm_at : NULL;
}

static void forward_piece(const lt_call *c, int64_t task)
{
    const piece p = piece_of(c, task);

    op_l2_normalise((lt_real *)c->out->data + p.at, p.positions, norm_of(c, &p), (const lt_real *)c->in[0]->data + p.at,
                    p.positions, p.channels, p.n, eps_of(c));
}

static int64_t piece_cost(const lt_call *c)
{
    return 4 * lt_dim(c->in[0], 1) * lt_min_i64(OP_L2_COLUMNS, op_inner(c->in[0], 1));
}

static void forward(const lt_call *c)
{
    op_by_row(c, lt_dim(c->in[0], 0) * pieces_of(c), piece_cost(c), forward_piece);
}

static void backward_piece(const lt_call *c, int64_t task)
{
    const piece p = piece_of(c, task);

    op_l2_normalise_grad(c->din[0] + p.at, c->dout + p.at, (const lt_real *)c->in[0]->data + p.at, norm_of(c, &p),
                         p.positions, p.channels, p.n, eps_of(c));
}

static void backward(const lt_call *c)
{
    op_by_row(c, lt_dim(c->in[0], 0) * pieces_of(c), piece_cost(c), backward_piece);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const char *x = lt_onnx_of(w, n->in[0]), *length;

    length = LT_ONNX(w, "Sqrt", lt_onnx_sum(w, LT_ONNX(w, "Mul", x, x), 1, true));
    length = LT_ONNX(w, "Add", length, lt_onnx_number(w, ((const l2_attr *)n->attr)->eps));
    lt_onnx_is(w, n->outs[0], LT_ONNX(w, "Div", x, length));
}

static const lt_op l2_normalise_op = {
    .name = "l2_normalise", .keeps = LT_KEEP_IN(0), .infer = infer, .plan = plan, .forward = forward,
    .backward = backward, .onnx = onnx,
};

lt_tensor *(lt_l2_normalise)(lt_tensor *x, double eps)
{
    const l2_attr a = { .eps = eps };

    return lt_apply(&l2_normalise_op, &a, sizeof(a), &x, 1);
}
