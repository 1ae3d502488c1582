/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/ops/broadcast.h"

/* Dimension i of the result, counted from the last, in t: 1 where t has none. */
static int64_t dim_from_end(const lt_tensor *t, int i)
{
    return i < t->shape.rank ? t->shape.dim[t->shape.rank - 1 - i] : 1;
}

lt_status broadcast_infer(lt_call *c)
{
    const lt_tensor *a = c->in[0], *b = c->in[1];
    char ta[LT_SHAPE_TEXT], tb[LT_SHAPE_TEXT];
    lt_shape *s = &c->out->shape;

    s->rank = (int)lt_max_i64(a->shape.rank, b->shape.rank);
    for (int i = 0; i < s->rank; i++) {
        const int64_t da = dim_from_end(a, i), db = dim_from_end(b, i);

        if (da != db && da != 1 && db != 1)
            return lt_fail(c, "%s and %s do not broadcast", lt_shape_text(&a->shape, ta),
                           lt_shape_text(&b->shape, tb));
        s->dim[s->rank - 1 - i] = da == 1 ? db : da;
    }
    return LT_OK;
}

static void strides_of(const lt_tensor *t, const lt_tensor *out, int64_t *stride)
{
    int64_t run = 1;

    for (int i = 0; i < out->shape.rank; i++) {         /* from the last */
        const int64_t d = dim_from_end(t, i);

        stride[out->shape.rank - 1 - i] = d == 1 ? 0 : run;
        run *= d;
    }
}

/* Whether dimension `outer` continues dimension `inner` (merged so far) in both operands. */
static bool continues(const broadcast *b, int at, const int64_t sa[], const int64_t sb[], int i)
{
    return sa[i] == b->stride[0][at] * b->dim[at] && sb[i] == b->stride[1][at] * b->dim[at];
}

broadcast broadcast_plan(const lt_tensor *out, const lt_tensor *x, const lt_tensor *y)
{
    int64_t sx[LT_MAX_RANK], sy[LT_MAX_RANK];
    broadcast b = { .rank = 0, .n_rows = 1, .inner = 1, .step = { 1, 1 } };

    strides_of(x, out, sx);
    strides_of(y, out, sy);
    for (int i = out->shape.rank - 1; i >= 0; i--) {    /* b.dim[0] is innermost here */
        const int at = b.rank - 1;

        if (out->shape.dim[i] == 1)
            continue;
        if (b.rank && continues(&b, at, sx, sy, i)) {
            b.dim[at] *= out->shape.dim[i];
            continue;
        }
        b.dim[b.rank] = out->shape.dim[i];
        b.stride[0][b.rank] = sx[i];
        b.stride[1][b.rank] = sy[i];
        b.rank++;
    }
    if (b.rank) {
        b.inner = b.dim[0];
        b.step[0] = b.stride[0][0];
        b.step[1] = b.stride[1][0];
    }
    for (int i = 1; i < b.rank; i++)
        b.n_rows *= b.dim[i];
    return b;
}

int64_t broadcast_row(const broadcast *b, int operand, int64_t row)
{
    int64_t at = 0;

    for (int i = 1; i < b->rank; i++) {
        at += row % b->dim[i] * b->stride[operand][i];
        row /= b->dim[i];
    }
    return at;
}
