/* SPDX-License-Identifier: Apache-2.0 */
/* one_blob: each number as a bump over bins of [0, 1].        [Mueller et al. 2019; NVlabs/tiny-cuda-nn encoding.cu]
 *   x (..., D)   ->   y (..., D bins):   bin k of x = C((k + 1) / bins - x) - C(k / bins - x)
 *   C(t) = the sum over shifts -1, 0, 1 of c(t + shift),   c(t) = 0.5 + 15/16 u (1 - 2 u^2 / 3 + u^4 / 5),
 *   u = bins t cut off at -1 and 1
 *   dx += sum_k dy_k (C'(k / bins - x) - C'((k + 1) / bins - x)),   c'(t) = 15/16 (1 - u^2)^2 bins
 */
#include "libtensor/ops/common.h"

typedef struct { int bins; } one_blob_attr;

static int bins_of(const lt_call *c)
{
    return ((const one_blob_attr *)c->attr)->bins;
}

static lt_status infer(lt_call *c)
{
    if (c->in[0]->shape.rank < 1)
        return lt_fail(c, "its input is a number, want a row at least");
    if (bins_of(c) < 2 || bins_of(c) > 1024)
        return lt_fail(c, "%d bins, want 2 to 1024", bins_of(c));
    c->out->shape = c->in[0]->shape;
    c->out->shape.dim[c->out->shape.rank - 1] *= bins_of(c);
    return LT_OK;
}

static double bump_sum(double t, int bins)
{
    double sum = 0;

    for (int shift = -1; shift <= 1; shift++) {
        const double u = fmax(-1, fmin(1, bins * (t + shift)));

        sum += 0.5 + 15.0 / 16 * u * (1 - 2 * u * u / 3 + u * u * u * u / 5);
    }
    return sum;
}

static double bump_slope(double t, int bins)
{
    double sum = 0;

    for (int shift = -1; shift <= 1; shift++) {
        const double u = fmax(-1, fmin(1, bins * (t + shift)));

        sum += 15.0 / 16 * (1 - u * u) * (1 - u * u) * bins;
    }
    return sum;
}

static void forward_number(const lt_call *c, int64_t i)
{
    const int bins = bins_of(c);
    const double x = ((const lt_real *)c->in[0]->data)[i];
    lt_real *y = (lt_real *)c->out->data + i * bins;
    double below = bump_sum(-x, bins);

    for (int k = 0; k < bins; k++) {
        const double above = bump_sum((k + 1.0) / bins - x, bins);

        y[k] = (lt_real)(above - below);
        below = above;
    }
}

static void backward_number(const lt_call *c, int64_t i)
{
    const int bins = bins_of(c);
    const double x = ((const lt_real *)c->in[0]->data)[i];
    double below = bump_slope(-x, bins), sum = 0;

    for (int k = 0; k < bins; k++) {
        const double above = bump_slope((k + 1.0) / bins - x, bins);

        sum += c->dout[i * bins + k] * (below - above);
        below = above;
    }
    op_start(c, 0, i, 1);
    c->din[0][i] += (lt_real)sum;
}

static void forward(const lt_call *c)
{
    op_by_row(c, lt_numel(c->in[0]), 16 * bins_of(c), forward_number);
}

static void backward(const lt_call *c)
{
    if (c->din[0])
        op_by_row(c, lt_numel(c->in[0]), 16 * bins_of(c), backward_number);
}

static const lt_op one_blob_op = {
    .name = "one_blob", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(0), .infer = infer, .forward = forward,
    .backward = backward,
};

lt_tensor *(lt_one_blob)(lt_tensor *x, int bins)
{
    const one_blob_attr a = { bins };

    return lt_apply(&one_blob_op, &a, sizeof(a), &x, 1);
}
