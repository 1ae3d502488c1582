/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The array that a pickled value stands for. chumpy pickles a lazy expression: Ch holds its value in x,
 * Select gathers idxs out of the flattened value of a. Only these shapes of it are evaluated.
 *
 * Source: chumpy ch.py, reordering.py.
 */
#include "libtensor/io/pickle/dense.h"

#include "libtensor/io/array/raw_array.h"
#include "libtensor/io/pickle/sparse.h"

#include <string.h>

enum { NESTING_MAX = 16 };

static const lt_pvalue *member(const lt_pvalue *v, const char *name)
{
    return lt_pdict_get(v->u.object.state, name);
}

static bool class_is(const lt_pvalue *v, const char *name)
{
    const char *dot = strrchr(v->u.object.class_name, '.');

    return dot && strcmp(dot + 1, name) == 0;
}

/* ---- lists of numbers ---------------------------------------------------------------------------- */

static bool is_sequence(const lt_pvalue *v)
{
    return v->kind == LT_PLIST || v->kind == LT_PTUPLE;
}

/* The shape that a list has down its first items; false where it has too many dimensions or elements. */
static bool list_shape(const lt_pvalue *v, lt_array *out)
{
    size_t count = 1;

    for (out->rank = 0; is_sequence(v); out->rank++) {
        if (out->rank == LT_ARRAY_MAX_RANK || !lt_size_mul(count, v->n, &count) || count > LT_DENSE_MAX)
            return false;
        out->shape[out->rank] = (int64_t)v->n;
        if (v->n == 0) {
            out->rank++;
            break;
        }
        v = v->u.item[0];
    }
    return true;
}

/* All of it, each level as long as its shape says. */
static bool take_list(const lt_pvalue *v, const lt_array *shape, int d, double **out)
{
    if (d == shape->rank)
        return lt_pfloat(v, (*out)++);
    if (!is_sequence(v) || v->n != (size_t)shape->shape[d])
        return false;
    for (size_t i = 0; i < v->n; i++)
        if (!take_list(v->u.item[i], shape, d + 1, out))
            return false;
    return true;
}

static lt_status list_of_numbers(lt_arena *arena, const lt_pvalue *v, lt_array *a)
{
    lt_array list = { .type = LT_ELEM_F8 };
    double *out;

    if (!list_shape(v, &list))
        return lt_error(LT_EFORMAT, "a list of more than 8 dimensions or %d elements", LT_DENSE_MAX);
    list.data = out = lt_arena_array(arena, lt_array_count(&list), sizeof(*out));
    if (!out)
        return lt_error(LT_ENOMEM, "no memory for %zu numbers", lt_array_count(&list));
    if (!take_list(v, &list, 0, &out))
        return lt_error(LT_EFORMAT, "a list that is no array of numbers: of rows of one length each");
    *a = list;
    return LT_OK;
}

/* ---- chumpy -------------------------------------------------------------------------------------- */

/* A new shape for as many elements. */
static lt_status reshape(const lt_pvalue *shape, lt_array *a)
{
    lt_array wanted = *a;
    size_t bytes, now;

    if (!lt_take_shape(shape, &wanted) || !lt_array_bytes(&wanted, &bytes) || !lt_array_bytes(a, &now) ||
        bytes != now)
        return lt_error(LT_EFORMAT, "a chumpy shape that does not fit its elements");
    *a = wanted;
    return LT_OK;
}

/* Select: elements idxs of a, in the shape preferred_shape */
static lt_status select_elements(lt_arena *arena, const lt_pvalue *v, lt_array *a)
{
    const lt_array *index = lt_parray(member(v, "idxs"));
    const lt_pvalue *shape = member(v, "preferred_shape");
    const size_t count = lt_array_count(a), n = index ? lt_array_count(index) : 0;
    double *out;

    if (!index || index->type == LT_ELEM_TEXT)
        return lt_error(LT_EFORMAT, "chumpy Select without an array idxs");
    out = lt_arena_array(arena, n, sizeof(*out));
    if (!out)
        return lt_error(LT_ENOMEM, "no memory for %zu numbers", n);
    for (size_t i = 0; i < n; i++) {
        const int64_t from = lt_array_int(index, i);

        if (from < 0 || (uint64_t)from >= count)
            return lt_error(LT_EFORMAT, "chumpy Select: index %lld of %zu elements", (long long)from,
                            count);
        out[i] = lt_array_get(a, (size_t)from);
    }
    *a = lt_array_make(LT_ELEM_F8, 1, &(int64_t){ (int64_t)n }, out);
    return lt_pis_none(shape) ? LT_OK : reshape(shape, a);
}

/* transpose: the axes in another order, reversed when none is given */
static lt_status transpose(lt_arena *arena, const lt_pvalue *axes, lt_array *a)
{
    const size_t n = lt_array_count(a), size = lt_elem_size(a->type);
    uint64_t stride[LT_ARRAY_MAX_RANK], turned[LT_ARRAY_MAX_RANK], step = 1;
    lt_array order = { .rank = a->rank }, result = *a;
    unsigned seen = 0;

    result.data = lt_arena_array(arena, n, size);
    if (!result.data)
        return lt_error(LT_ENOMEM, "no memory for %zu numbers", n);
    for (int d = 0; d < a->rank; d++)
        order.shape[d] = a->rank - 1 - d;
    if (!lt_pis_none(axes) && (!lt_take_shape(axes, &order) || order.rank != a->rank))
        return lt_error(LT_EFORMAT, "chumpy transpose with other axes than its array");
    for (int d = a->rank - 1; d >= 0; d--) {
        stride[d] = step;
        step *= (uint64_t)a->shape[d];
    }
    for (int d = 0; d < a->rank; d++) {
        if (order.shape[d] >= a->rank || seen & 1u << order.shape[d])
            return lt_error(LT_EFORMAT, "chumpy transpose with axes that are no permutation");
        seen |= 1u << order.shape[d];
        result.shape[d] = a->shape[order.shape[d]];
        turned[d] = stride[order.shape[d]];
    }
    lt_copy_strided(result.data, a->data, size, result.rank, result.shape, turned);
    *a = result;
    return LT_OK;
}

/* ---- expressions --------------------------------------------------------------------------------- */

static lt_status apply(lt_arena *arena, const lt_pvalue *node, lt_array *a)
{
    if (class_is(node, "Select"))
        return select_elements(arena, node, a);
    if (class_is(node, "Reshape"))
        return reshape(member(node, "newshape"), a);
    if (class_is(node, "transpose"))
        return transpose(arena, member(node, "axes"), a);
    return LT_OK;                               /* Ch: its value is x */
}

/* NULL is what is not there. */
static lt_status plain_array(lt_arena *arena, const lt_pvalue *v, lt_array *a)
{
    char found[160];

    if (v && lt_is_sparse(v))
        return lt_sparse_dense(arena, v, a);
    if (v && is_sequence(v) && v->n)
        return list_of_numbers(arena, v, a);
    if (!lt_parray(v))
        return lt_error(LT_EFORMAT, "%s, no array of numbers", v ? lt_pdescribe(v, found, sizeof(found)) : "nothing");
    if (lt_parray(v)->type == LT_ELEM_TEXT)
        return lt_error(LT_EFORMAT, "text, no array of numbers");
    *a = *lt_parray(v);
    return LT_OK;
}

/* Down to the array at the bottom of the expression, then its operations on the way back up. */
lt_status lt_pickle_dense(lt_arena *arena, const lt_pvalue *v, lt_array *out)
{
    const lt_pvalue *node[NESTING_MAX];
    int n = 0;
    lt_array a;
    lt_status st;

    while (v && v->kind == LT_POBJECT && strncmp(v->u.object.class_name, "chumpy.", 7) == 0) {
        if (n == NESTING_MAX)
            return lt_error(LT_EFORMAT, "chumpy expression nested deeper than %d", NESTING_MAX);
        node[n++] = v;
        v = member(v, class_is(v, "Ch") ? "x" : "a");
    }
    st = plain_array(arena, v, &a);
    while (!st && n > 0)
        st = apply(arena, node[--n], &a);
    if (!st)
        *out = a;
    return st;
}
