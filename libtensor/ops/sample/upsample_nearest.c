/* SPDX-License-Identifier: Apache-2.0 */
/* upsample_nearest: each cell becomes factor x factor equal ones.
 *   x (B, C, H, W)   ->   y (B, C, f H, f W)
 *   dx += the sum of its f x f gradients
 */
#include "libtensor/ops/common.h"

typedef struct {
    int factor;
} upsample_attr;

static lt_status infer(lt_call *c)
{
    const upsample_attr *a = c->attr;
    const lt_tensor *x = c->in[0];

    if (lt_want_rank(c, 0, "input", 4))
        return LT_ESHAPE;
    if (a->factor < 1)
        return lt_fail(c, "factor is %d, want at least 1", a->factor);
    if (lt_dim(x, 2) > INT32_MAX / a->factor || lt_dim(x, 3) > INT32_MAX / a->factor)
        return lt_fail(c, "%d times %lld x %lld cells are too many", a->factor, (long long)lt_dim(x, 2),
                       (long long)lt_dim(x, 3));
    c->out->shape = LT_SHAPE(lt_dim(x, 0), lt_dim(x, 1), a->factor * lt_dim(x, 2), a->factor * lt_dim(x, 3));
    return LT_OK;
}

/* One row of x and its f rows of y; in blocks a cell has LT_BLOCK numbers. */
static void forward_row(const lt_call *c, int64_t row)
{
    const int f = ((const upsample_attr *)c->attr)->factor;
    const int64_t w = lt_dim(c->in[0], 3), cell = lt_in_blocks(c->out) ? LT_BLOCK : 1, line = f * w * cell;
    const lt_real *x = (const lt_real *)c->in[0]->data + row * w * cell;
    lt_real *y = (lt_real *)c->out->data + row * f * line;

    for (int64_t i = 0; i < f * w; i++)
        if (cell == 1)
            y[i] = x[i / f];
        else
            memcpy(y + i * LT_BLOCK, x + i / f * LT_BLOCK, LT_BLOCK * sizeof(*y));
    for (int k = 1; k < f; k++)
        memcpy(y + k * line, y, (size_t)line * sizeof(*y));
}

static void forward(const lt_call *c)
{
    op_by_row(c, op_outer(c->in[0], 3), op_inner(c->out, 2), forward_row);
}

static void backward_row(const lt_call *c, int64_t row)
{
    const int f = ((const upsample_attr *)c->attr)->factor;
    const int64_t w = lt_dim(c->in[0], 3);
    const lt_real *dy = c->dout + row * f * f * w;
    lt_real *dx = c->din[0] + row * w;

    op_start(c, 0, row * w, w);
    for (int64_t i = 0; i < w; i++)
        for (int k = 0; k < f; k++)
            for (int l = 0; l < f; l++)
                dx[i] += dy[k * f * w + i * f + l];
}

static void backward(const lt_call *c)
{
    if (c->din[0])
        op_by_row(c, op_outer(c->in[0], 3), lt_dim(c->out, 3), backward_row);
}

static unsigned takes_blocks(const lt_node *n)
{
    return op_fills_blocks(n->in[0]) ? LT_BLOCKS_IN(0) | LT_BLOCKS_OUT : 0;
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const lt_real f = (lt_real)((const upsample_attr *)n->attr)->factor;
    const char *scales = lt_onnx_numbers(w, LT_SHAPE(4), (lt_real[]){ 1, 1, f, f });

    lt_onnx_is(w, n->outs[0], LT_ONNX(w, "Resize", lt_onnx_of(w, n->in[0]), "", scales));
    lt_onnx_text_of(w, "mode", "nearest");
    lt_onnx_text_of(w, "coordinate_transformation_mode", "asymmetric");
    lt_onnx_text_of(w, "nearest_mode", "floor");
}

static const lt_op upsample_nearest_op = {
    .name = "upsample_nearest", .flags = LT_OP_CHEAP | LT_OP_ASSIGNS, .keeps = LT_KEEP_NOTHING, .infer = infer,
    .forward = forward, .backward = backward, .takes_blocks = takes_blocks, .onnx = onnx,
};

lt_tensor *(lt_upsample_nearest)(lt_tensor *x, int factor)
{
    const upsample_attr a = { .factor = factor };

    return lt_apply(&upsample_nearest_op, &a, sizeof(a), &x, 1);
}
