/* SPDX-License-Identifier: Apache-2.0 */
/* linear: y = act(x w^T + b + addend) over the last dimension.
 *   x (..., K)   w (N, K)   b (N)   ->   y (..., N)
 *   dx += dy w       dw += dy^T x       db += sum of dy's rows
 *
 * act and addend are there only where an inference plan fused them. Then x may also be what is before another linear,
 * whose work is done here: y = act(act0(x w0^T + b0) w^T + b + addend). With a table of ranges x is read as 8-bit
 * integers.
 */
#include "libtensor/kernels/gemm.h"
#include "libtensor/kernels/int8.h"
#include "libtensor/ops/common.h"

enum { X, W, B, ADDEND, W0, B0, INPUTS };

typedef struct {
    lt_act act, act0;
    bool packed;                /* in[W], and in[W0] if there, are results of linear_pack ... */
    lt_shape weight, weight0;   /* ... and these were their shapes */
    lt_int8_range range;        /* how x is read as integers; scale 0: as it is */
} linear_attr;

static lt_shape weight_of(const lt_call *c)
{
    const linear_attr *a = c->attr;

    return a->packed ? a->weight : c->in[W]->shape;
}

static lt_status infer(lt_call *c)
{
    const lt_tensor *x = c->in[X], *w = c->in[W];

    if (lt_want_rank(c, W, "weight", 2))
        return LT_ESHAPE;
    if (x->shape.rank < 1 || lt_dim(x, -1) != lt_dim(w, 1))
        return lt_fail(c, "input has %lld features, weight wants %lld",
                       (long long)(x->shape.rank ? lt_dim(x, -1) : 0), (long long)lt_dim(w, 1));
    if (c->in[B] && lt_want_shape(c, B, "bias", LT_SHAPE(lt_dim(w, 0))))
        return LT_ESHAPE;
    c->out->shape = x->shape;
    c->out->shape.dim[x->shape.rank - 1] = lt_dim(w, 0);
    return LT_OK;
}

static int64_t rows_of(const lt_call *c)
{
    return op_outer(c->in[X], c->in[X]->shape.rank - 1);
}

/* Weights that are not packed yet are packed into the work of the pass that reads them. */
static void plan(lt_call *c)
{
    const linear_attr *a = c->attr;
    const lt_shape w = weight_of(c);
    const int64_t count = lt_max_i64(lt_gemm_packed_count(w.dim[0], w.dim[1]),
                                     lt_gemm_packed_count(w.dim[1], w.dim[0]));

    c->work_bytes = a->packed ? 0 : (size_t)count * sizeof(lt_real);
    if (a->range.scale > 0)
        c->work_bytes = lt_gemm_int8_work(rows_of(c), w.dim[1]);
}

static const lt_real *data_of(const lt_tensor *t)
{
    return t ? t->data : NULL;
}

static void forward(const lt_call *c)
{
    const linear_attr *a = c->attr;
    const lt_shape w = weight_of(c);
    const int64_t n = w.dim[0], k = w.dim[1];
    const lt_epilogue tail = {
        .col_bias = data_of(c->in[B]), .residual = data_of(c->in[ADDEND]), .ld_residual = n, .act = a->act,
    };

    if (c->in[W0]) {
        const lt_epilogue tail0 = { .col_bias = data_of(c->in[B0]), .act = a->act0 };

        lt_gemm_pair(rows_of(c), a->weight0.dim[1], c->in[X]->data, k, c->in[W0]->data, &tail0, n, c->in[W]->data,
                     &tail, c->out->data);
        return;
    }
    if (a->range.scale > 0) {
        lt_gemm_int8(rows_of(c), n, k, &a->range, c->in[X]->data, c->in[W]->data, &tail, c->out->data, c->work);
        return;
    }
    if (!a->packed)
        lt_gemm_pack(LT_TRANS, n, k, c->in[W]->data, k, c->work);
    lt_gemm_packed(LT_NO_TRANS, rows_of(c), n, k, c->in[X]->data, k, a->packed ? c->in[W]->data : c->work,
                   false, c->out->data, n, &tail);
}

/* Column j of dy, summed over rows in their order; a task owns some columns. */
enum { COLUMNS = 64 };

static void bias_grad(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const int64_t n = lt_dim(c->in[W], 0), first = task * COLUMNS;
    const size_t width = (size_t)lt_min_i64(COLUMNS, n - first);

    op_start(c, B, first, (int64_t)width);
    for (int64_t r = 0; r < rows_of(c); r++)
        lt_k->add_to(c->din[B] + first, c->dout + r * n + first, width);
}

static void backward(const lt_call *c)
{
    const int64_t m = rows_of(c), n = lt_dim(c->in[W], 0), k = lt_dim(c->in[W], 1);

    if (c->din[X]) {
        lt_gemm_pack(LT_NO_TRANS, k, n, c->in[W]->data, k, c->work);
        lt_gemm_packed(LT_NO_TRANS, m, k, n, c->dout, n, c->work, !c->fresh[X], c->din[X], k, NULL);
    }
    if (c->din[W])
        lt_gemm(LT_TRANS, LT_NO_TRANS, n, k, m, c->dout, n, c->in[X]->data, k, !c->fresh[W], c->din[W], k, NULL);
    if (c->din[B])
        lt_parallel_for(lt_ceil_div(n, COLUMNS), bias_grad, (void *)c);
}

static int64_t macs(const lt_call *c)
{
    const linear_attr *a = c->attr;
    const lt_shape w = weight_of(c);

    return rows_of(c) * (w.dim[0] * w.dim[1] + (c->in[W0] ? a->weight0.dim[0] * a->weight0.dim[1] : 0));
}

static bool absorb(lt_node *node, const lt_tail *tail)
{
    linear_attr *a = node->attr;

    if (tail->scale || a->act.kind != LT_ACT_NONE || (tail->addend && node->in[ADDEND]))
        return false;
    if (tail->addend)
        node->in[ADDEND] = tail->addend;
    a->act = tail->act;
    return true;
}

static bool absorb_before(lt_node *node, const lt_node *before)
{
    linear_attr *a = node->attr;
    const linear_attr *first = before->attr;
    const lt_tensor *x = before->in[X];

    if (before->op != node->op || before->in[ADDEND] || before->in[W0] || !lt_is_constant(before->in[W])
        || !lt_is_constant(node->in[W])
        || !lt_gemm_pair_suits(op_outer(x, x->shape.rank - 1), lt_dim(before->in[W], 0), lt_dim(x, -1)))
        return false;
    node->in[X] = before->in[X];
    node->in[W0] = before->in[W];
    node->in[B0] = before->in[B];
    a->act0 = first->act;
    return true;
}

static const char *algorithm(const lt_call *c)
{
    return ((const linear_attr *)c->attr)->range.scale > 0 ? "int8" : c->in[W0] ? "after linear" : "";
}

/* linear_pack: w in the order in which forward reads it; attr is the lt_int8_range of linear */
static lt_status pack_infer(lt_call *c)
{
    const int64_t n = lt_dim(c->in[0], 0), k = lt_dim(c->in[0], 1);
    const lt_int8_range *r = c->attr;

    c->out->shape = LT_SHAPE(r->scale > 0 ? lt_gemm_int8_packed(n, k) : lt_gemm_packed_count(n, k));
    return LT_OK;
}

static void pack_plan(lt_call *c)
{
    const lt_int8_range *r = c->attr;

    c->work_bytes = r->scale > 0 ? lt_gemm_int8_pack_work(lt_dim(c->in[0], 0), lt_dim(c->in[0], 1)) : 0;
}

static void pack_forward(const lt_call *c)
{
    const int64_t n = lt_dim(c->in[0], 0), k = lt_dim(c->in[0], 1);
    const lt_int8_range *r = c->attr;

    if (r->scale > 0)
        lt_gemm_int8_pack(n, k, r, c->in[0]->data, c->out->data, c->work);
    else
        lt_gemm_pack(LT_TRANS, n, k, c->in[0]->data, k, c->out->data);
}

static const lt_op linear_pack_op = {
    .name = "linear_pack", .infer = pack_infer, .plan = pack_plan, .forward = pack_forward,
};

static lt_shape pack(lt_node *node, int i)
{
    const linear_attr *a = node->attr;
    const lt_shape shape = node->in[i]->shape;

    node->in[i] = lt_apply(&linear_pack_op, &a->range, sizeof(a->range), &node->in[i], 1);
    return shape;
}

static void prepare(lt_node *node)
{
    linear_attr *a = node->attr;

    if (!lt_is_constant(node->in[W]))
        return;
    a->weight = pack(node, W);
    if (node->in[W0])
        a->weight0 = pack(node, W0);
    a->packed = true;
}

static bool takes_int8(const lt_node *node)
{
    const lt_tensor *w = node->in[W];

    return lt_is_constant(w) && lt_gemm_int8_suits(lt_dim(w, 0), lt_dim(w, 1));
}

static void prepare_int8(lt_node *node, const lt_int8_range *range)
{
    ((linear_attr *)node->attr)->range = *range;
    prepare(node);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const char *x = lt_onnx_of(w, n->in[X]), *weight = lt_onnx_of(w, n->in[W]), *y;

    if (n->in[X]->shape.rank == 2) {
        lt_onnx_same(w, n, "Gemm");
        lt_onnx_int(w, "transB", 1);
        return;
    }
    y = LT_ONNX(w, "MatMul", x, lt_onnx_transpose(w, weight, (int[]){ 1, 0 }, 2));
    lt_onnx_is(w, n->outs[0], n->in[B] ? LT_ONNX(w, "Add", y, lt_onnx_of(w, n->in[B])) : y);
}

static const lt_op linear_op = {
    .name = "linear", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(X) | LT_KEEP_IN(W),
    .optional = LT_OPTIONAL_IN(B) | LT_OPTIONAL_IN(ADDEND) | LT_OPTIONAL_IN(W0) | LT_OPTIONAL_IN(B0), .infer = infer,
    .plan = plan, .forward = forward, .backward = backward, .macs = macs, .algorithm = algorithm, .absorb = absorb,
    .absorb_before = absorb_before, .prepare = prepare, .takes_int8 = takes_int8, .prepare_int8 = prepare_int8,
    .onnx = onnx,
};

lt_tensor *(lt_linear)(lt_tensor *x, lt_tensor *w, lt_tensor *b)
{
    const linear_attr a = { .act = { .kind = LT_ACT_NONE } };

    return lt_apply(&linear_op, &a, sizeof(a), (lt_tensor *[INPUTS]){ x, w, b }, INPUTS);
}
