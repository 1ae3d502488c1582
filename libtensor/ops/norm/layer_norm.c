/* SPDX-License-Identifier: Apache-2.0 */
/* layer_norm: y = (x - mean) / sqrt(var + eps) * weight + bias over the last dimension  [Ba et al. 2016]
 *   x (..., C)   weight, bias (C)   ->   y (..., C); biased variance
 *   with n = (x - mean) rstd and g = dy weight:  dx += rstd (g - mean(g) - n mean(g n))
 *   dweight += sum dy n       dbias += sum dy       over rows: in fixed chunks, added in their order
 */
#include "libtensor/ops/common.h"

enum { X, WEIGHT, BIAS };
enum { MAX_CHUNKS = 32 };

typedef struct {
    double eps;
} layer_norm_attr;

static lt_status infer(lt_call *c)
{
    const layer_norm_attr *a = c->attr;
    lt_shape row;

    if (c->in[X]->shape.rank < 1)
        return lt_fail(c, "its input is a single number, want a row at least");
    row = LT_SHAPE(lt_dim(c->in[X], -1));
    if (lt_want_shape(c, WEIGHT, "weight", row) || lt_want_shape(c, BIAS, "bias", row))
        return LT_ESHAPE;
    if (!(a->eps > 0))
        return lt_fail(c, "eps is %g, want a number above 0", a->eps);
    return op_same_shape(c);
}

static int64_t rows_of(const lt_call *c)
{
    return op_outer(c->in[X], c->in[X]->shape.rank - 1);
}

static int64_t chunks_of(const lt_call *c)
{
    return lt_min_i64(MAX_CHUNKS, rows_of(c));
}

/* saved: mean and rstd of each row; work: each chunk's share of dweight and dbias */
static void plan(lt_call *c)
{
    if (!c->train)
        return;
    c->saved_bytes[0] = (size_t)(2 * rows_of(c)) * sizeof(lt_real);
    c->work_bytes = (size_t)(chunks_of(c) * 2 * lt_dim(c->in[X], -1)) * sizeof(lt_real);
}

enum { ROWS = 16 };             /* of a task's part */

static void forward_rows(const lt_call *c, int64_t part)
{
    const layer_norm_attr *a = c->attr;
    const int64_t n = lt_dim(c->out, -1), row = part * ROWS;

    lt_k->layer_norm((lt_real *)c->out->data + row * n, c->train ? (lt_real *)c->saved[0] + 2 * row : NULL,
                     (const lt_real *)c->in[X]->data + row * n, c->in[WEIGHT]->data, c->in[BIAS]->data,
                     a->eps, (size_t)lt_min_i64(ROWS, rows_of(c) - row), (size_t)n);
}

static void forward(const lt_call *c)
{
    op_by_row(c, lt_ceil_div(rows_of(c), ROWS), ROWS * 4 * lt_dim(c->out, -1), forward_rows);
}

static void backward_chunk(void *ctx, int64_t chunk)
{
    const lt_call *c = ctx;
    const int64_t n = lt_dim(c->out, -1), per = lt_ceil_div(rows_of(c), chunks_of(c));
    lt_real *dw = (lt_real *)c->work + chunk * 2 * n, *db = dw + n;

    memset(dw, 0, (size_t)(2 * n) * sizeof(*dw));
    for (int64_t row = chunk * per; row < lt_min_i64(rows_of(c), (chunk + 1) * per); row++) {
        op_start(c, X, row * n, n);
        lt_k->layer_norm_grad(c->din[X] ? c->din[X] + row * n : NULL, dw, db, c->dout + row * n,
                              (const lt_real *)c->in[X]->data + row * n, c->in[WEIGHT]->data,
                              (const lt_real *)c->saved[0] + 2 * row, (size_t)n);
    }
}

static void backward(const lt_call *c)
{
    const int64_t n = lt_dim(c->out, -1);

    op_start(c, WEIGHT, 0, n);
    op_start(c, BIAS, 0, n);
    if (rows_of(c) == 0)
        return;
    lt_parallel_for(chunks_of(c), backward_chunk, (void *)c);
    for (int64_t i = 0; i < chunks_of(c); i++) {
        const lt_real *dw = (const lt_real *)c->work + i * 2 * n;

        if (c->din[WEIGHT])
            lt_k->add_to(c->din[WEIGHT], dw, (size_t)n);
        if (c->din[BIAS])
            lt_k->add_to(c->din[BIAS], dw + n, (size_t)n);
    }
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    lt_onnx_same(w, n, "LayerNormalization");
    lt_onnx_int(w, "axis", -1);
    lt_onnx_float(w, "epsilon", ((const layer_norm_attr *)n->attr)->eps);
}

static const lt_op layer_norm_op = {
    .name = "layer_norm", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(X) | LT_KEEP_IN(WEIGHT),
    .infer = infer, .plan = plan, .forward = forward, .backward = backward, .onnx = onnx,
};

lt_tensor *(lt_layer_norm)(lt_tensor *x, lt_tensor *weight, lt_tensor *bias, double eps)
{
    const layer_norm_attr a = { .eps = eps };

    return lt_apply(&layer_norm_op, &a, sizeof(a), (lt_tensor *[]){ x, weight, bias }, 3);
}
