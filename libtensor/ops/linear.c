/* SPDX-License-Identifier: Apache-2.0 */
/* linear: y = act(x w^T + b + addend) over the last dimension.
 *   x (..., K)   w (N, K)   b (N)   ->   y (..., N)
 *   dx += dy w       dw += dy^T x       db += sum of dy's rows
 *
 * Where the CPU has AMX and there is enough to do, products are made on its tiles.
 *
 * act and addend are there only where an inference plan fused them. Then x may also be what is before another linear,
 * whose work is done here: y = act(act0(x w0^T + b0) w^T + b + addend). With a table of ranges x is read as 8-bit
 * integers.
 */
#include "libtensor/kernels/gemm/tiles.h"
#include "libtensor/kernels/int8/int8.h"
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

/* ---- a product of so many rows with weights, on tiles or by multiply-adds ---- */

static int64_t packed_count(int64_t rows, int64_t n, int64_t k)
{
    return lt_gemm_tiles_suits(rows, n, k) ? lt_gemm_tiles_packed(n, k) : lt_gemm_packed_count(n, k);
}

static void pack_weights(lt_trans t, int64_t rows, int64_t n, int64_t k, const lt_real *w, int64_t ld, lt_real *packed)
{
    (lt_gemm_tiles_suits(rows, n, k) ? lt_gemm_tiles_pack : lt_gemm_pack)(t, n, k, w, ld, packed);
}

static void multiply(int64_t rows, int64_t n, int64_t k, const lt_real *x, const lt_real *packed, bool add, lt_real *y,
                     const lt_epilogue *e)
{
    if (lt_gemm_tiles_suits(rows, n, k))
        lt_gemm_tiles(rows, n, k, x, k, packed, add, y, n, e);
    else
        lt_gemm_packed(LT_NO_TRANS, rows, n, k, x, k, packed, add, y, n, e);
}

/* Two in a row, their weights (hidden, K) and (N, hidden), all of it on tiles; or all by multiply-adds */
static bool tiles_pair(int64_t rows, lt_shape w0, lt_shape w)
{
    return lt_gemm_tiles_pair_suits(rows, w0.dim[1], w0.dim[0], w.dim[0]);
}

static bool plain_pair(int64_t rows, lt_shape w0, lt_shape w)
{
    return lt_gemm_pair_suits(rows, w0.dim[0], w0.dim[1]) && !lt_gemm_tiles_suits(rows, w0.dim[0], w0.dim[1])
           && !lt_gemm_tiles_suits(rows, w.dim[0], w.dim[1]);
}

/* Weights that are not packed yet are packed into the work of the pass that reads them. */
static void plan(lt_call *c)
{
    const linear_attr *a = c->attr;
    const lt_shape w = weight_of(c);
    const int64_t rows = rows_of(c), n = w.dim[0], k = w.dim[1];

    if (a->range.scale > 0) {
        c->work_bytes = lt_gemm_int8_work(rows, k);
    } else if (!a->packed) {
        c->work_bytes = (size_t)lt_max_i64(packed_count(rows, n, k), packed_count(rows, k, n)) * sizeof(lt_real);
        if (lt_gemm_tiles_suits(n, k, rows) && c->work_bytes < lt_gemm_tiles_sums_work(n, k, rows))
            c->work_bytes = lt_gemm_tiles_sums_work(n, k, rows);
    }
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

        (tiles_pair(rows_of(c), a->weight0, w) ? lt_gemm_tiles_pair : lt_gemm_pair)(
            rows_of(c), a->weight0.dim[1], c->in[X]->data, k, c->in[W0]->data, &tail0, n, c->in[W]->data, &tail,
            c->out->data);
        return;
    }
    if (a->range.scale > 0) {
        lt_gemm_int8(rows_of(c), n, k, &a->range, c->in[X]->data, c->in[W]->data, &tail, c->out->data, c->work);
        return;
    }
    if (!a->packed)
        pack_weights(LT_TRANS, rows_of(c), n, k, c->in[W]->data, k, c->work);
    multiply(rows_of(c), n, k, c->in[X]->data, a->packed ? c->in[W]->data : c->work, false, c->out->data, &tail);
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

static void weight_grad(const lt_call *c, int64_t rows, int64_t n, int64_t k)
{
    const bool add = !c->fresh[W];

    if (lt_gemm_tiles_suits(n, k, rows))
        lt_gemm_tiles_sums(n, k, rows, c->dout, c->in[X]->data, add, c->din[W], c->work);
    else
        lt_gemm(LT_TRANS, LT_NO_TRANS, n, k, rows, c->dout, n, c->in[X]->data, k, add, c->din[W], k, NULL);
}

static void backward(const lt_call *c)
{
    const int64_t rows = rows_of(c), n = lt_dim(c->in[W], 0), k = lt_dim(c->in[W], 1);

    if (c->din[X]) {
        pack_weights(LT_NO_TRANS, rows, k, n, c->in[W]->data, k, c->work);
        multiply(rows, k, n, c->dout, c->work, !c->fresh[X], c->din[X], NULL);
    }
    if (c->din[W])
        weight_grad(c, rows, n, k);
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
    int64_t rows;

    if (before->op != node->op || before->in[ADDEND] || before->in[W0] || !lt_is_constant(before->in[W])
        || !lt_is_constant(node->in[W]))
        return false;
    rows = op_outer(x, x->shape.rank - 1);
    if (!tiles_pair(rows, before->in[W]->shape, node->in[W]->shape)
        && !plain_pair(rows, before->in[W]->shape, node->in[W]->shape))
        return false;
    node->in[X] = before->in[X];
    node->in[W0] = before->in[W];
    node->in[B0] = before->in[B];
    a->act0 = first->act;
    return true;
}

static const char *algorithm(const lt_call *c)
{
    const linear_attr *a = c->attr;
    const lt_shape w = weight_of(c);

    if (a->range.scale > 0)
        return "int8";
    if (c->in[W0])
        return tiles_pair(rows_of(c), a->weight0, w) ? "tiles after linear" : "after linear";
    return lt_gemm_tiles_suits(rows_of(c), w.dim[0], w.dim[1]) ? "tiles" : "";
}

/* linear_pack: w in the order in which forward reads it */
typedef struct {
    lt_int8_range range;        /* linear's */
    int64_t rows;               /* that it will meet */
} pack_attr;

static lt_status pack_infer(lt_call *c)
{
    const int64_t n = lt_dim(c->in[0], 0), k = lt_dim(c->in[0], 1);
    const pack_attr *a = c->attr;

    c->out->shape = LT_SHAPE(a->range.scale > 0 ? lt_gemm_int8_packed(n, k) : packed_count(a->rows, n, k));
    return LT_OK;
}

static void pack_plan(lt_call *c)
{
    const pack_attr *a = c->attr;

    c->work_bytes = a->range.scale > 0 ? lt_gemm_int8_pack_work(lt_dim(c->in[0], 0), lt_dim(c->in[0], 1)) : 0;
}

static void pack_forward(const lt_call *c)
{
    const int64_t n = lt_dim(c->in[0], 0), k = lt_dim(c->in[0], 1);
    const pack_attr *a = c->attr;

    if (a->range.scale > 0)
        lt_gemm_int8_pack(n, k, &a->range, c->in[0]->data, c->out->data, c->work);
    else
        pack_weights(LT_TRANS, a->rows, n, k, c->in[0]->data, k, c->out->data);
}

static const lt_op linear_pack_op = {
    .name = "linear_pack", .infer = pack_infer, .plan = pack_plan, .forward = pack_forward,
};

static lt_shape pack(lt_node *node, int i)
{
    const lt_tensor *x = node->in[X];
    const lt_shape shape = node->in[i]->shape;
    const pack_attr a = { ((const linear_attr *)node->attr)->range, op_outer(x, x->shape.rank - 1) };

    node->in[i] = lt_apply(&linear_pack_op, &a, sizeof(a), &node->in[i], 1);
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
