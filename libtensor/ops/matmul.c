/* SPDX-License-Identifier: Apache-2.0 */
/* matmul: y = a b, for each of B products or for one.
 *   a (B, M, K)   b (B, K, N)   ->   y (B, M, N)
 *   da += dy b^T       db += a^T dy
 */
#include "libtensor/kernels/gemm/gemm.h"
#include "libtensor/ops/common.h"

typedef struct {
    int64_t count, m, n, k;
} sizes;

static sizes sizes_of(const lt_call *c)
{
    const lt_tensor *a = c->in[0], *b = c->in[1];
    const sizes s = {
        .count = a->shape.rank == 3 ? lt_dim(a, 0) : 1, .m = lt_dim(a, -2), .n = lt_dim(b, -1),
        .k = lt_dim(a, -1),
    };

    return s;
}

static lt_status infer(lt_call *c)
{
    const lt_tensor *a = c->in[0], *b = c->in[1];
    char ta[LT_SHAPE_TEXT], tb[LT_SHAPE_TEXT];

    if ((a->shape.rank != 2 && a->shape.rank != 3) || a->shape.rank != b->shape.rank
        || lt_dim(a, -1) != lt_dim(b, -2) || (a->shape.rank == 3 && lt_dim(a, 0) != lt_dim(b, 0)))
        return lt_fail(c, "%s times %s is no product of matrices", lt_shape_text(&a->shape, ta),
                       lt_shape_text(&b->shape, tb));
    c->out->shape = a->shape;
    c->out->shape.dim[a->shape.rank - 1] = lt_dim(b, -1);
    return LT_OK;
}

static void forward(const lt_call *c)
{
    const sizes s = sizes_of(c);

    lt_gemm_batch(s.count, LT_NO_TRANS, LT_NO_TRANS, s.m, s.n, s.k, c->in[0]->data, s.k, s.m * s.k,
                  c->in[1]->data, s.n, s.k * s.n, false, c->out->data, s.n, s.m * s.n, NULL);
}

static void backward(const lt_call *c)
{
    const sizes s = sizes_of(c);

    if (c->din[0])
        lt_gemm_batch(s.count, LT_NO_TRANS, LT_TRANS, s.m, s.k, s.n, c->dout, s.n, s.m * s.n,
                      c->in[1]->data, s.n, s.k * s.n, true, c->din[0], s.k, s.m * s.k, NULL);
    if (c->din[1])
        lt_gemm_batch(s.count, LT_TRANS, LT_NO_TRANS, s.k, s.n, s.m, c->in[0]->data, s.k, s.m * s.k,
                      c->dout, s.n, s.m * s.n, true, c->din[1], s.n, s.k * s.n, NULL);
}

static int64_t macs(const lt_call *c)
{
    return lt_numel(c->out) * lt_dim(c->in[0], -1);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    lt_onnx_same(w, n, "MatMul");
}

static const lt_op matmul_op = {
    .name = "matmul", .keeps = LT_KEEP_IN(0) | LT_KEEP_IN(1), .infer = infer,
    .forward = forward, .backward = backward, .macs = macs, .onnx = onnx,
};

lt_tensor *(lt_matmul)(lt_tensor *a, lt_tensor *b)
{
    return lt_apply(&matmul_op, NULL, 0, (lt_tensor *[]){ a, b }, 2);
}
