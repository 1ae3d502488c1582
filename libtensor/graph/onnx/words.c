/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The words with which an op says what it is in ONNX: operators, attributes, constants.
 */
#include "libtensor/graph/onnx/internal.h"

#include <string.h>

enum { MAX_ATTRS = 8 };

/* ---- operators and their attributes --------------------------------------------------------------------------- */

static lt_onnx_attr *add_attr(lt_onnx *w, const char *name, lt_onnx_attr_kind kind)
{
    lt_onnx_node *n = w->status ? NULL : &w->model.node[w->model.n_nodes - 1];

    if (n && !n->attr)
        n->attr = lt_onnx_alloc(w, MAX_ATTRS, sizeof(*n->attr));
    if (n && n->n_attr == MAX_ATTRS)
        lt_onnx_refuse(w, "more than %d attributes", MAX_ATTRS);
    if (w->status)
        return NULL;
    n->attr[n->n_attr] = (lt_onnx_attr){ .name = name, .kind = kind };
    return &n->attr[n->n_attr++];
}

void lt_onnx_int(lt_onnx *w, const char *name, int64_t value)
{
    lt_onnx_attr *a = add_attr(w, name, LT_ONNX_A_INT);

    if (a)
        a->i = value;
}

void lt_onnx_float(lt_onnx *w, const char *name, double value)
{
    lt_onnx_attr *a = add_attr(w, name, LT_ONNX_A_FLOAT);

    if (a)
        a->f = (float)value;
}

void lt_onnx_text_of(lt_onnx *w, const char *name, const char *value)
{
    lt_onnx_attr *a = add_attr(w, name, LT_ONNX_A_TEXT);

    if (a)
        a->text = value;
}

void lt_onnx_ints(lt_onnx *w, const char *name, const int64_t *value, int n)
{
    int64_t *copy = lt_onnx_alloc(w, (size_t)n, sizeof(*copy));
    lt_onnx_attr *a = add_attr(w, name, LT_ONNX_A_INTS);

    if (!a)
        return;
    if (n)
        memcpy(copy, value, (size_t)n * sizeof(*value));
    a->ints = copy;
    a->n_ints = n;
}

void lt_onnx_same(lt_onnx *w, const lt_node *n, const char *op)
{
    const char *in[LT_MAX_IN];
    int n_in = n->n_in;

    while (n_in && !n->in[n_in - 1])            /* left out at the end: not mentioned */
        n_in--;
    for (int i = 0; i < n_in; i++)
        in[i] = lt_onnx_of(w, n->in[i]);
    lt_onnx_is(w, n->outs[0], lt_onnx_put(w, op, in, n_in));
}

/* ---- constants -------------------------------------------------------------------------------------------------- */

const char *lt_onnx_numbers(lt_onnx *w, lt_shape shape, const lt_real *value)
{
    const size_t n = (size_t)lt_shape_numel(&shape);
    lt_real *copy = lt_onnx_alloc(w, n, sizeof(*copy));

    if (!copy)
        return "";
    memcpy(copy, value, n * sizeof(*copy));
    return lt_onnx_add_tensor(w, lt_onnx_part_name(w), LT_ONNX_FLOAT, shape, copy, true);
}

const char *lt_onnx_number(lt_onnx *w, double value)
{
    const lt_real v = (lt_real)value;

    return lt_onnx_numbers(w, (lt_shape){ 0 }, &v);
}

static const char *whole_numbers(lt_onnx *w, lt_shape shape, const int64_t *value)
{
    const size_t n = (size_t)lt_shape_numel(&shape);
    int64_t *copy = lt_onnx_alloc(w, n, sizeof(*copy));

    if (!copy)
        return "";
    memcpy(copy, value, n * sizeof(*copy));
    return lt_onnx_add_tensor(w, lt_onnx_part_name(w), LT_ONNX_INT64, shape, copy, false);
}

const char *lt_onnx_index(lt_onnx *w, int64_t value)
{
    return whole_numbers(w, (lt_shape){ 0 }, &value);
}

const char *lt_onnx_indices(lt_onnx *w, const int64_t *value, int n)
{
    return whole_numbers(w, LT_SHAPE(n), value);
}

/* ---- what many ops are made of ----------------------------------------------------------------------------------- */

const char *lt_onnx_reshape(lt_onnx *w, const char *x, lt_shape shape)
{
    int unknown = 0;

    for (int i = 0; i < shape.rank; i++) {
        unknown += shape.dim[i] < 0;
        if (shape.dim[i] == 0)                  /* "as it was", to ONNX */
            lt_onnx_refuse(w, "its tensors are empty");
    }
    if (unknown > 1)
        lt_onnx_refuse(w, "%d dimensions of a shape depend on the batch; give the batch a fixed size", unknown);
    return LT_ONNX(w, "Reshape", x, lt_onnx_indices(w, shape.dim, shape.rank));
}

const char *lt_onnx_transpose(lt_onnx *w, const char *x, const int *order, int rank)
{
    const char *y = LT_ONNX(w, "Transpose", x);
    int64_t perm[LT_MAX_RANK];

    for (int i = 0; i < rank; i++)
        perm[i] = order[i];
    lt_onnx_ints(w, "perm", perm, rank);
    return y;
}

const char *lt_onnx_slice(lt_onnx *w, const char *x, int axis, int64_t start, int64_t length)
{
    const int64_t end = start + length, along = axis;

    return LT_ONNX(w, "Slice", x, lt_onnx_indices(w, &start, 1), lt_onnx_indices(w, &end, 1),
                   lt_onnx_indices(w, &along, 1));
}

const char *lt_onnx_gather(lt_onnx *w, const char *x, int axis, const int *index, int n)
{
    int64_t *list = lt_onnx_alloc(w, (size_t)n, sizeof(*list));
    const char *y;

    for (int i = 0; list && i < n; i++)
        list[i] = index[i];
    y = list ? LT_ONNX(w, "Gather", x, lt_onnx_indices(w, list, n)) : "";
    lt_onnx_int(w, "axis", axis);
    return y;
}

const char *lt_onnx_sum(lt_onnx *w, const char *x, int axis, bool keep)
{
    const int64_t along = axis;
    const char *y = LT_ONNX(w, "ReduceSum", x, lt_onnx_indices(w, &along, 1));

    lt_onnx_int(w, "keepdims", keep);
    return y;
}
