/* SPDX-License-Identifier: Apache-2.0 */
/* permute: dimension i of y is dimension order[i] of x.
 *   dx += dy with the inverse order
 */
#include "libtensor/ops/common.h"

typedef struct {
    int order[LT_MAX_RANK];
} permute_attr;

static lt_status infer(lt_call *c)
{
    const permute_attr *a = c->attr;
    const lt_shape *x = &c->in[0]->shape;
    unsigned seen = 0;

    for (int i = 0; i < x->rank; i++) {
        if (a->order[i] < 0 || a->order[i] >= x->rank || (seen & (1u << a->order[i])))
            return lt_fail(c, "order[%d] = %d is no permutation of %d dimensions", i, a->order[i], x->rank);
        seen |= 1u << a->order[i];
        c->out->shape.dim[i] = x->dim[a->order[i]];
    }
    c->out->shape.rank = x->rank;
    return LT_OK;
}

enum { ROWS = 64 };                 /* of a plane, in a task */

/*
 * A permutation as planes: the last dimension of y is `rows` of x, the last of x `cols`, and element (i, j) of a
 * plane stands at i * ld_x + j in x, at j * ld_y + i in y. The other dimensions number the planes. Where the
 * last dimension stays the last, a plane is one row and is copied.
 */
typedef struct {
    bool copied;
    int64_t rows, cols, ld_x, ld_y, planes;
    int n_others;
    int64_t dim[LT_MAX_RANK], x_step[LT_MAX_RANK], y_step[LT_MAX_RANK];     /* the last one first */
} job;

static void strides_of(const lt_shape *s, int64_t *stride)
{
    for (int i = s->rank - 1; i >= 0; i--)
        stride[i] = i == s->rank - 1 ? 1 : stride[i + 1] * s->dim[i + 1];
}

static job make_job(const lt_call *c)
{
    const int *order = ((const permute_attr *)c->attr)->order;
    const lt_shape *x = &c->in[0]->shape, *y = &c->out->shape;
    const int last = y->rank - 1;
    int64_t x_stride[LT_MAX_RANK], y_stride[LT_MAX_RANK];
    job j = { .rows = 1, .cols = 1, .planes = 1, .copied = y->rank == 0 || order[last] == last };

    strides_of(x, x_stride);
    strides_of(y, y_stride);
    for (int i = last; i >= 0; i--) {
        if (order[i] == last) {
            j.cols = y->dim[i];
            j.ld_y = y_stride[i];
        } else if (i == last) {
            j.rows = y->dim[i];
            j.ld_x = x_stride[order[i]];
        } else {
            j.dim[j.n_others] = y->dim[i];
            j.x_step[j.n_others] = x_stride[order[i]];
            j.y_step[j.n_others++] = y_stride[i];
            j.planes *= y->dim[i];
        }
    }
    return j;
}

/* Rows [first, first + n) of a plane, from where they start in x and in y */
typedef struct {
    int64_t x, y, n;
} part;

static part part_of(const job *j, int64_t task)
{
    const int64_t pieces = lt_ceil_div(j->rows, ROWS), first = task % pieces * ROWS;
    part p = { first * j->ld_x, first, lt_min_i64(ROWS, j->rows - first) };
    int64_t plane = task / pieces;

    for (int i = 0; i < j->n_others; i++) {
        p.x += plane % j->dim[i] * j->x_step[i];
        p.y += plane % j->dim[i] * j->y_step[i];
        plane /= j->dim[i];
    }
    return p;
}

static void forward_part(const lt_call *c, int64_t task)
{
    const job *j = c->work;
    const part p = part_of(j, task);
    const lt_real *x = (const lt_real *)c->in[0]->data + p.x;
    lt_real *y = (lt_real *)c->out->data + p.y;

    if (j->copied)
        memcpy(y, x, (size_t)j->cols * sizeof(*y));
    else
        lt_k->turn(y, j->ld_y, x, j->ld_x, p.n, j->cols, false);
}

static void backward_part(const lt_call *c, int64_t task)
{
    const job *j = c->work;
    const part p = part_of(j, task);
    const lt_real *dy = c->dout + p.y;
    lt_real *dx = c->din[0] + p.x;

    if (j->copied) {
        op_start(c, 0, p.x, j->cols);
        lt_k->add_to(dx, dy, (size_t)j->cols);
    } else {
        lt_k->turn(dx, j->ld_x, dy, j->ld_y, j->cols, p.n, !c->fresh[0]);
    }
}

/* work: the job, once for all tasks */
static void plan(lt_call *c)
{
    c->work_bytes = sizeof(job);
}

static void by_part(const lt_call *c, op_row_fn fn)
{
    job *j = c->work;

    if (lt_numel(c->out) == 0)
        return;
    *j = make_job(c);
    op_by_row(c, j->planes * lt_ceil_div(j->rows, ROWS), lt_min_i64(ROWS, j->rows) * j->cols, fn);
}

static void forward(const lt_call *c)
{
    by_part(c, forward_part);
}

static void backward(const lt_call *c)
{
    if (c->din[0])
        by_part(c, backward_part);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const permute_attr *a = n->attr;
    const char *x = lt_onnx_of(w, n->in[0]);

    lt_onnx_is(w, n->outs[0], lt_onnx_transpose(w, x, a->order, n->in[0]->shape.rank));
}

static const lt_op permute_op = {
    .name = "permute", .flags = LT_OP_CHEAP | LT_OP_ASSIGNS, .keeps = LT_KEEP_NOTHING, .infer = infer,
    .plan = plan, .forward = forward, .backward = backward, .onnx = onnx,
};

lt_tensor *(lt_permute)(lt_tensor *x, const int *order)
{
    permute_attr a = { { 0 } };

    memcpy(a.order, order, (size_t)x->shape.rank * sizeof(*order));
    return lt_apply(&permute_op, &a, sizeof(a), &x, 1);
}
