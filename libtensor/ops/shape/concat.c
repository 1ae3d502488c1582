/* SPDX-License-Identifier: Apache-2.0 */
/* concat: tensors one after another along an axis; slice: a piece along an axis.
 *   concat  dx_i += its piece of dy
 *   slice   dx's piece += dy
 *
 * Both are rows of `length * inner` elements moved between a whole and a part of it. Where that is one row, an
 * inference plan may let the part be a piece of the whole's memory, and nothing is moved.
 */
#include "libtensor/ops/common.h"

typedef struct {
    int axis;
    int64_t start, length;          /* of slice */
} piece_attr;

static lt_status check_axis(lt_call *c, int axis)
{
    char text[LT_SHAPE_TEXT];

    if (axis < 0 || axis >= c->in[0]->shape.rank)
        return lt_fail(c, "axis %d is not one of %s", axis, lt_shape_text(&c->in[0]->shape, text));
    return LT_OK;
}

/* ---- concat ------------------------------------------------------------------------------------------- */

static lt_status concat_infer(lt_call *c)
{
    const piece_attr *a = c->attr;
    lt_shape *s = &c->out->shape;
    char ta[LT_SHAPE_TEXT], tb[LT_SHAPE_TEXT];

    if (check_axis(c, a->axis))
        return LT_ESHAPE;
    *s = c->in[0]->shape;
    for (int i = 1; i < c->n_in; i++) {
        lt_shape other = c->in[i]->shape;
        const int64_t length = other.rank == s->rank ? other.dim[a->axis] : 0;

        if (other.rank == s->rank)
            other.dim[a->axis] = s->dim[a->axis];
        if (!lt_same_shape(s, &other))
            return lt_fail(c, "%s and %s differ in more than axis %d", lt_shape_text(&c->in[0]->shape, ta),
                           lt_shape_text(&c->in[i]->shape, tb), a->axis);
        s->dim[a->axis] += length;
    }
    return LT_OK;
}

static int64_t row_of(const lt_tensor *t, int axis)
{
    return lt_dim(t, axis) * op_inner(t, axis);
}

static void concat_row(const lt_call *c, int64_t row)
{
    const piece_attr *a = c->attr;
    lt_real *y = (lt_real *)c->out->data + row * row_of(c->out, a->axis);

    for (int i = 0; i < c->n_in; i++) {
        const int64_t n = row_of(c->in[i], a->axis);

        if (y != (const lt_real *)c->in[i]->data + row * n)
            memcpy(y, (const lt_real *)c->in[i]->data + row * n, (size_t)n * sizeof(*y));
        y += n;
    }
}

static void concat_grad_row(const lt_call *c, int64_t row)
{
    const piece_attr *a = c->attr;
    const lt_real *dy = c->dout + row * row_of(c->out, a->axis);

    for (int i = 0; i < c->n_in; i++) {
        const int64_t n = row_of(c->in[i], a->axis);

        op_start(c, i, row * n, n);
        if (c->din[i])
            lt_k->add_to(c->din[i] + row * n, dy, (size_t)n);
        dy += n;
    }
}

static void by_row(const lt_call *c, const lt_tensor *t, op_row_fn fn)
{
    const piece_attr *a = c->attr;

    op_by_row(c, op_outer(t, a->axis), row_of(t, a->axis), fn);
}

static void concat_forward(const lt_call *c)
{
    by_row(c, c->out, concat_row);
}

static void concat_backward(const lt_call *c)
{
    by_row(c, c->out, concat_grad_row);
}

/* Channels in blocks are put together block by block. */
static unsigned concat_takes_blocks(const lt_node *n)
{
    unsigned takes = LT_BLOCKS_OUT;

    for (int i = 0; i < n->n_in; i++) {
        if (!op_fills_blocks(n->in[i]))
            return 0;
        takes |= LT_BLOCKS_IN(i);
    }
    return ((const piece_attr *)n->attr)->axis == 1 ? takes : 0;
}

static int64_t concat_piece(const lt_node *n, int i)
{
    const int axis = ((const piece_attr *)n->attr)->axis;
    int64_t at = 0;

    for (int k = 0; k < i; k++)
        at += lt_numel(n->in[k]);
    return op_outer(n->outs[0], axis) == 1 ? at : -1;
}

static void concat_onnx(lt_onnx *w, const lt_node *n)
{
    lt_onnx_same(w, n, "Concat");
    lt_onnx_int(w, "axis", ((const piece_attr *)n->attr)->axis);
}

static const lt_op concat_op = {
    .name = "concat", .flags = LT_OP_CHEAP | LT_OP_ASSIGNS, .keeps = LT_KEEP_NOTHING, .infer = concat_infer,
    .forward = concat_forward, .backward = concat_backward, .takes_blocks = concat_takes_blocks,
    .in_piece = concat_piece, .onnx = concat_onnx,
};

lt_tensor *(lt_concat)(lt_tensor *const *x, int n, int axis)
{
    const piece_attr a = { .axis = axis };

    return lt_apply(&concat_op, &a, sizeof(a), x, n);
}

/* ---- slice -------------------------------------------------------------------------------------------- */

static lt_status slice_infer(lt_call *c)
{
    const piece_attr *a = c->attr;
    char text[LT_SHAPE_TEXT];

    if (check_axis(c, a->axis))
        return LT_ESHAPE;
    if (a->start < 0 || a->length < 0 || a->start > lt_dim(c->in[0], a->axis) - a->length)
        return lt_fail(c, "%lld elements from %lld are not inside axis %d of %s", (long long)a->length,
                       (long long)a->start, a->axis, lt_shape_text(&c->in[0]->shape, text));
    c->out->shape = c->in[0]->shape;
    c->out->shape.dim[a->axis] = a->length;
    return LT_OK;
}

/* Of a row of the whole; start and length count channels, of which the shapes may have blocks. */
static int64_t piece_start(const piece_attr *a, const lt_tensor *whole, const lt_tensor *piece)
{
    return a->length ? a->start * lt_dim(piece, a->axis) / a->length * op_inner(whole, a->axis) : 0;
}

static int64_t place_in_whole(const lt_call *c, int64_t row)
{
    const piece_attr *a = c->attr;

    return row * row_of(c->in[0], a->axis) + piece_start(a, c->in[0], c->out);
}

static void slice_row(const lt_call *c, int64_t row)
{
    const piece_attr *a = c->attr;
    const int64_t n = row_of(c->out, a->axis);

    const lt_real *x = (const lt_real *)c->in[0]->data + place_in_whole(c, row);
    lt_real *y = (lt_real *)c->out->data + row * n;

    if (y != x)
        memcpy(y, x, (size_t)n * sizeof(*y));
}

static void slice_grad_row(const lt_call *c, int64_t row)
{
    const piece_attr *a = c->attr;
    const int64_t n = row_of(c->out, a->axis);

    lt_k->add_to(c->din[0] + place_in_whole(c, row), c->dout + row * n, (size_t)n);
}

static void slice_forward(const lt_call *c)
{
    by_row(c, c->out, slice_row);
}

static void slice_backward(const lt_call *c)
{
    if (c->din[0])
        by_row(c, c->out, slice_grad_row);
}

static unsigned slice_takes_blocks(const lt_node *n)
{
    const piece_attr *a = n->attr;

    return a->axis == 1 && a->start % LT_BLOCK == 0 && op_fills_blocks(n->in[0]) && op_fills_blocks(n->outs[0])
           ? LT_BLOCKS_IN(0) | LT_BLOCKS_OUT : 0;
}

static int64_t slice_piece(const lt_node *n)
{
    const piece_attr *a = n->attr;

    return op_outer(n->outs[0], a->axis) == 1 ? piece_start(a, n->in[0], n->outs[0]) : -1;
}

static void slice_onnx(lt_onnx *w, const lt_node *n)
{
    const piece_attr *a = n->attr;
    const char *x = lt_onnx_of(w, n->in[0]);

    lt_onnx_is(w, n->outs[0], lt_onnx_slice(w, x, a->axis, a->start, a->length));
}

static const lt_op slice_op = {
    .name = "slice", .flags = LT_OP_CHEAP, .keeps = LT_KEEP_NOTHING, .infer = slice_infer,
    .forward = slice_forward, .backward = slice_backward, .takes_blocks = slice_takes_blocks,
    .out_piece = slice_piece, .onnx = slice_onnx,
};

lt_tensor *(lt_slice)(lt_tensor *x, int axis, int64_t start, int64_t length)
{
    const piece_attr a = { .axis = axis, .start = start, .length = length };

    return lt_apply(&slice_op, &a, sizeof(a), &x, 1);
}
