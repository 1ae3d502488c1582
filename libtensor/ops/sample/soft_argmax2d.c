/* SPDX-License-Identifier: Apache-2.0 */
/* soft_argmax2d: the expected place of heat maps that sum to 1.
 *   h (B, J, H, W)   ->   (u, v) (B, J, 2), u = sum h (col + 0.5) / W, v = sum h (row + 0.5) / H
 *   dh += du (col + 0.5) / W + dv (row + 0.5) / H
 */
#include "libtensor/ops/common.h"

static lt_status infer(lt_call *c)
{
    const lt_tensor *h = c->in[0];

    if (lt_want_rank(c, 0, "heat maps", 4))
        return LT_ESHAPE;
    if (lt_dim(h, 2) > INT32_MAX || lt_dim(h, 3) > INT32_MAX || lt_dim(h, 2) * lt_dim(h, 3) > INT32_MAX)
        return lt_fail(c, "maps of %lld x %lld cells, want at most %d", (long long)lt_dim(h, 2),
                       (long long)lt_dim(h, 3), INT32_MAX);
    c->out->shape = LT_SHAPE(lt_dim(c->in[0], 0), lt_dim(c->in[0], 1), 2);
    return LT_OK;
}

/* work: col + 0.5 of every cell of a map, then row + 0.5 */
static void plan(lt_call *c)
{
    c->work_bytes = (size_t)(2 * lt_dim(c->in[0], 2) * lt_dim(c->in[0], 3)) * sizeof(lt_real);
}

static int64_t cells(const lt_call *c)
{
    return lt_dim(c->in[0], 2) * lt_dim(c->in[0], 3);
}

static lt_real *cols(const lt_call *c)
{
    return c->work;
}

static lt_real *rows(const lt_call *c)
{
    return cols(c) + cells(c);
}

static void fill_places(const lt_call *c)
{
    const int64_t W = lt_dim(c->in[0], 3);

    for (int64_t i = 0; i < cells(c); i++) {
        cols(c)[i] = (lt_real)(i % W) + (lt_real)0.5;
        rows(c)[i] = (lt_real)(i / W) + (lt_real)0.5;
    }
}

static void forward_map(const lt_call *c, int64_t i)
{
    const size_t n = (size_t)cells(c);
    const lt_real *h = (const lt_real *)c->in[0]->data + i * cells(c);
    lt_real *uv = (lt_real *)c->out->data + 2 * i;

    uv[0] = (lt_real)(lt_k->dot(h, cols(c), n) / (double)lt_dim(c->in[0], 3));
    uv[1] = (lt_real)(lt_k->dot(h, rows(c), n) / (double)lt_dim(c->in[0], 2));
}

static void backward_map(const lt_call *c, int64_t i)
{
    const size_t n = (size_t)cells(c);
    lt_real *dh = c->din[0] + i * cells(c);

    op_start(c, 0, i * cells(c), cells(c));
    lt_k->axpy(dh, c->dout[2 * i] / (lt_real)lt_dim(c->in[0], 3), cols(c), n);
    lt_k->axpy(dh, c->dout[2 * i + 1] / (lt_real)lt_dim(c->in[0], 2), rows(c), n);
}

static void by_map(const lt_call *c, op_row_fn fn)
{
    fill_places(c);
    op_by_row(c, op_outer(c->in[0], 2), cells(c), fn);
}

static void forward(const lt_call *c)
{
    by_map(c, forward_map);
}

static void backward(const lt_call *c)
{
    if (c->din[0])
        by_map(c, backward_map);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const int64_t H = lt_dim(n->in[0], 2), W = lt_dim(n->in[0], 3);
    lt_real *place = lt_alloc((size_t)(2 * H * W) * sizeof(*place));
    const char *maps = lt_onnx_reshape(w, lt_onnx_of(w, n->in[0]), LT_SHAPE(-1, lt_dim(n->in[0], 1), H * W));

    if (!place) {
        lt_onnx_refuse(w, "no memory");
        return;
    }
    for (int64_t i = 0; i < H * W; i++) {
        place[2 * i] = (lt_real)(((double)(i % W) + 0.5) / (double)W);
        place[2 * i + 1] = (lt_real)(((double)(i / W) + 0.5) / (double)H);
    }
    lt_onnx_is(w, n->outs[0], LT_ONNX(w, "MatMul", maps, lt_onnx_numbers(w, LT_SHAPE(H * W, 2), place)));
    lt_release(place);
}

static const lt_op soft_argmax2d_op = {
    .name = "soft_argmax2d", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_NOTHING, .infer = infer,
    .plan = plan, .forward = forward, .backward = backward, .onnx = onnx,
};

lt_tensor *(lt_soft_argmax2d)(lt_tensor *heat)
{
    return lt_apply(&soft_argmax2d_op, NULL, 0, &heat, 1);
}
