/* SPDX-License-Identifier: Apache-2.0 */
/* add, sub, mul: y = a + b, a - b, a * b, with broadcasting.
 *   add  da += dy      db += dy
 *   sub  da += dy      db -= dy
 *   mul  da += dy b    db += dy a
 *
 * One file for the three: they differ in one line each. Where an operand stretches, its gradient is the
 * sum over what it was stretched to, taken in the order of the elements by one task.
 */
#include "libtensor/ops/broadcast.h"

/* ---- forward ------------------------------------------------------------------------------------------ */

/* One row; an operand whose step is 0 is one number for all of it. */
typedef void (*row_fn)(lt_real *y, const lt_real *a, const lt_real *b, int64_t sa, int64_t sb, size_t n);

static const lt_act plain = { .kind = LT_ACT_NONE };

static void add_row(lt_real *y, const lt_real *a, const lt_real *b, int64_t sa, int64_t sb, size_t n)
{
    if (sa && sb)
        lt_k->add(y, a, b, n);
    else
        lt_k->affine(y, sa ? a : b, 1, sa ? *b : *a, NULL, plain, n);
}

static void sub_row(lt_real *y, const lt_real *a, const lt_real *b, int64_t sa, int64_t sb, size_t n)
{
    if (sa && sb)
        lt_k->sub(y, a, b, n);
    else
        lt_k->affine(y, sa ? a : b, sa ? 1 : -1, sa ? -*b : *a, NULL, plain, n);
}

static void mul_row(lt_real *y, const lt_real *a, const lt_real *b, int64_t sa, int64_t sb, size_t n)
{
    if (sa && sb)
        lt_k->mul(y, a, b, n);
    else
        lt_k->scale(y, sa ? a : b, sa ? *b : *a, n);
}

enum { TASK = 16384 };              /* elements */

/* How rows become tasks: long ones are cut, short ones bundled. */
typedef struct {
    int64_t rows, piece;
} row_cut;

static row_cut cut_rows(const broadcast *b)
{
    return (row_cut){ lt_max_i64(1, TASK / b->inner), lt_min_i64(TASK, b->inner) };
}

static int64_t tasks_of(const broadcast *b, const row_cut *cut)
{
    return lt_ceil_div(b->inner, cut->piece) * lt_ceil_div(b->n_rows, cut->rows);
}

/* Task i: rows [first, end), elements [at, at + n) of each */
typedef struct {
    int64_t first, end, at, n;
} task_part;

static task_part part_of(const broadcast *b, const row_cut *cut, int64_t i)
{
    const int64_t pieces = lt_ceil_div(b->inner, cut->piece), at = i % pieces * cut->piece;
    const int64_t first = i / pieces * cut->rows;

    return (task_part){ first, lt_min_i64(b->n_rows, first + cut->rows), at, lt_min_i64(cut->piece, b->inner - at) };
}

typedef struct {
    const lt_call *c;
    broadcast b;
    row_cut cut;
    row_fn fn;
} forward_job;

static void forward_task(void *ctx, int64_t i)
{
    const forward_job *j = ctx;
    const task_part t = part_of(&j->b, &j->cut, i);

    for (int64_t r = t.first; r < t.end; r++) {
        const lt_real *a = (const lt_real *)j->c->in[0]->data + broadcast_row(&j->b, 0, r);
        const lt_real *b = (const lt_real *)j->c->in[1]->data + broadcast_row(&j->b, 1, r);

        j->fn((lt_real *)j->c->out->data + r * j->b.inner + t.at, a + t.at * j->b.step[0],
              b + t.at * j->b.step[1], j->b.step[0], j->b.step[1], (size_t)t.n);
    }
}

static void run_forward(const lt_call *c, row_fn fn)
{
    forward_job j = { .c = c, .b = broadcast_plan(c->out, c->in[0], c->in[1]), .fn = fn };

    if (lt_numel(c->out) == 0)
        return;
    j.cut = cut_rows(&j.b);
    lt_parallel_for(tasks_of(&j.b, &j.cut), forward_task, &j);
}

static void add_forward(const lt_call *c) { run_forward(c, add_row); }
static void sub_forward(const lt_call *c) { run_forward(c, sub_row); }
static void mul_forward(const lt_call *c) { run_forward(c, mul_row); }

/* ---- backward ----------------------------------------------------------------------------------------- */

/* dx += sign * dy * other, where other may be NULL for 1; x, other stretch by their steps. */
static void grad_row(lt_real *dx, int64_t sx, const lt_real *dy, lt_real sign, const lt_real *other,
                     int64_t so, size_t n)
{
    if (sx == 0) {
        double sum = !other ? lt_k->sum(dy, n) : so ? lt_k->dot(dy, other, n) : lt_k->sum(dy, n) * *other;

        *dx += sign * (lt_real)sum;
    } else if (!other) {
        lt_k->axpy(dx, sign, dy, n);
    } else if (so == 0) {
        lt_k->axpy(dx, sign * *other, dy, n);
    } else {
        lt_k->mul_to(dx, dy, other, n);
    }
}

typedef struct {
    const lt_call *c;
    broadcast b;
    row_cut cut;
    lt_real sign[2];
    bool product, wanted[2], apart[2];      /* apart: no two rows reach the same place of the operand */
} backward_job;

static void backward_row(const backward_job *j, int k, int64_t r, const task_part *t)
{
    const broadcast *b = &j->b;
    const int64_t dx = broadcast_row(b, k, r) + t->at * b->step[k];
    const lt_real *other = NULL;

    if (j->product)
        other = (const lt_real *)j->c->in[1 - k]->data + broadcast_row(b, 1 - k, r) + t->at * b->step[1 - k];
    if (j->apart[k])
        op_start(j->c, k, dx, b->step[k] ? t->n : 1);
    grad_row(j->c->din[k] + dx, b->step[k], j->c->dout + r * b->inner + t->at, j->sign[k], other,
             b->step[1 - k], (size_t)t->n);
}

static void backward_task(void *ctx, int64_t i)
{
    const backward_job *j = ctx;
    const task_part t = part_of(&j->b, &j->cut, i);

    for (int64_t r = t.first; r < t.end; r++)
        for (int k = 0; k < 2; k++)
            if (j->wanted[k])
                backward_row(j, k, r, &t);
}

static bool rows_are_apart(const broadcast *b, int operand)
{
    for (int i = 1; i < b->rank; i++)
        if (b->stride[operand][i] == 0)
            return false;
    return true;
}

/* Rows that reach the same place of operand k stay in one task: all of them, or those of one outermost index. */
static row_cut keep_together(const broadcast *b, int k, row_cut cut)
{
    const int outer = b->rank - 1;

    cut.piece = b->step[k] ? cut.piece : b->inner;
    if (!rows_are_apart(b, k))
        cut = (row_cut){ b->stride[k][outer] ? b->n_rows / b->dim[outer] : b->n_rows, b->inner };
    return cut;
}

/* The operands that are wanted. Both in one sweep over dy, where their rows allow. */
static void sweep(backward_job *j, bool first, bool second)
{
    if (!first && !second)
        return;
    j->wanted[0] = first;
    j->wanted[1] = second;
    j->cut = cut_rows(&j->b);
    for (int k = 0; k < 2; k++) {
        if (!j->wanted[k])
            continue;
        j->cut = keep_together(&j->b, k, j->cut);
        if (!j->apart[k])
            op_start(j->c, k, 0, lt_numel(j->c->in[k]));
    }
    lt_parallel_for(tasks_of(&j->b, &j->cut), backward_task, j);
}

static void run_backward(const lt_call *c, lt_real second_sign, bool product)
{
    const bool first = c->din[0] != NULL, second = c->din[1] != NULL;
    backward_job j = { .c = c, .b = broadcast_plan(c->out, c->in[0], c->in[1]), .sign = { 1, second_sign },
                       .product = product };

    if (lt_numel(c->out) == 0) {
        for (int k = 0; k < 2; k++)
            op_start(c, k, 0, lt_numel(c->in[k]));
        return;
    }
    for (int k = 0; k < 2; k++)
        j.apart[k] = rows_are_apart(&j.b, k);
    if (j.apart[0] && j.apart[1]) {
        sweep(&j, first, second);
    } else {
        sweep(&j, first, false);
        sweep(&j, false, second);
    }
}

static void add_backward(const lt_call *c) { run_backward(c, 1, false); }
static void sub_backward(const lt_call *c) { run_backward(c, -1, false); }
static void mul_backward(const lt_call *c) { run_backward(c, 1, true); }

/* ---- the ops ------------------------------------------------------------------------------------------ */

/* A residual sum is a tail on either of its operands when neither stretches. */
static bool add_as_tail(const lt_node *n, int i, lt_tail *tail)
{
    tail->addend = n->in[1 - i];
    return n->in[0] != n->in[1] && lt_same_shape(&n->in[0]->shape, &n->in[1]->shape);
}

static unsigned add_takes_blocks(const lt_node *n)
{
    return op_fills_blocks(n->in[0]) && lt_same_shape(&n->in[0]->shape, &n->in[1]->shape)
           ? LT_BLOCKS_IN(0) | LT_BLOCKS_IN(1) | LT_BLOCKS_OUT : 0;
}

/* One number for each map. */
static bool mul_as_gate(const lt_node *n)
{
    const lt_shape *x = &n->in[0]->shape, *gate = &n->in[1]->shape;

    return x->rank == 4 && gate->rank == 4 && gate->dim[0] == x->dim[0] && gate->dim[1] == x->dim[1]
           && gate->dim[2] == 1 && gate->dim[3] == 1;
}

static void add_onnx(lt_onnx *w, const lt_node *n)
{
    lt_onnx_same(w, n, "Add");
}

static const lt_op add_op = {
    .name = "add", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_NOTHING, .infer = broadcast_infer,
    .forward = add_forward, .backward = add_backward, .as_tail = add_as_tail, .takes_blocks = add_takes_blocks,
    .onnx = add_onnx,
};

static void sub_onnx(lt_onnx *w, const lt_node *n)
{
    lt_onnx_same(w, n, "Sub");
}

static const lt_op sub_op = {
    .name = "sub", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_NOTHING, .infer = broadcast_infer,
    .forward = sub_forward, .backward = sub_backward, .onnx = sub_onnx,
};

static void mul_onnx(lt_onnx *w, const lt_node *n)
{
    lt_onnx_same(w, n, "Mul");
}

static const lt_op mul_op = {
    .name = "mul", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(0) | LT_KEEP_IN(1),
    .infer = broadcast_infer, .forward = mul_forward, .backward = mul_backward, .as_gate = mul_as_gate,
    .onnx = mul_onnx,
};

lt_tensor *(lt_add)(lt_tensor *a, lt_tensor *b)
{
    return lt_apply(&add_op, NULL, 0, (lt_tensor *[]){ a, b }, 2);
}

lt_tensor *(lt_sub)(lt_tensor *a, lt_tensor *b)
{
    return lt_apply(&sub_op, NULL, 0, (lt_tensor *[]){ a, b }, 2);
}

lt_tensor *(lt_mul)(lt_tensor *a, lt_tensor *b)
{
    return lt_apply(&mul_op, NULL, 0, (lt_tensor *[]){ a, b }, 2);
}
