/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The array that a pickled value stands for. chumpy pickles a lazy expression: Ch holds its value in x,
 * Select gathers idxs out of the flattened value of a. Only these shapes of it are evaluated.
 */
#include "libtensor/io/pickle/dense.h"

#include "libtensor/io/array/raw_array.h"

#include <string.h>

enum { NESTING_MAX = 16, ELEMENTS_MAX = 1 << 22 };

static const lt_pvalue *member(const lt_pvalue *v, const char *name)
{
    return lt_pdict_get(v->u.object.state, name);
}

static bool class_is(const lt_pvalue *v, const char *name)
{
    const char *dot = strrchr(v->u.object.class_name, '.');

    return dot && strcmp(dot + 1, name) == 0;
}

/* A tuple, list or array of at most 8 sizes, as a shape. */
static bool take_shape(const lt_pvalue *v, lt_array *out)
{
    const lt_array *a = lt_parray(v);
    const bool sequence = v && (v->kind == LT_PTUPLE || v->kind == LT_PLIST);
    const size_t n = sequence ? v->n : a && a->type != LT_ELEM_TEXT ? lt_array_count(a) : 0;

    if ((!sequence && !a) || n > LT_ARRAY_MAX_RANK)
        return false;
    out->rank = (int)n;
    for (size_t i = 0; i < n; i++) {
        if (sequence && !lt_pint(v->u.item[i], &out->shape[i]))
            return false;
        if (!sequence)
            out->shape[i] = lt_array_int(a, i);
        if (out->shape[i] < 0 || out->shape[i] > ELEMENTS_MAX)
            return false;
    }
    return true;
}

/* A new shape for as many elements. */
static lt_status reshape(const lt_pvalue *shape, lt_array *a)
{
    lt_array wanted = *a;
    size_t bytes, now;

    if (!take_shape(shape, &wanted) || !lt_array_bytes(&wanted, &bytes) || !lt_array_bytes(a, &now) ||
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
    if (!lt_pis_none(axes) && (!take_shape(axes, &order) || order.rank != a->rank))
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

/* ---- sparse matrices ----------------------------------------------------------------------------- */

typedef struct {
    const lt_array *data, *major, *minor;   /* csc: indptr, indices; coo: rows, columns */
    int64_t rows, cols;
    double *out;                            /* (rows, cols) */
} sparse;

static lt_status bad_sparse(const char *what)
{
    return lt_error(LT_EFORMAT, "sparse matrix: %s", what);
}

static bool is_vector(const lt_array *a)
{
    return a && a->type != LT_ELEM_TEXT && a->rank == 1;
}

static bool put(sparse *s, int64_t row, int64_t col, size_t i)
{
    if (row < 0 || row >= s->rows || col < 0 || col >= s->cols)
        return false;
    s->out[row * s->cols + col] += lt_array_get(s->data, i);        /* SciPy adds up repeated places */
    return true;
}

static lt_status fill_coo(sparse *s)
{
    if (s->major->shape[0] != s->data->shape[0] || s->minor->shape[0] != s->data->shape[0])
        return bad_sparse("rows, columns and data of different lengths");
    for (size_t i = 0; i < (size_t)s->data->shape[0]; i++)
        if (!put(s, lt_array_int(s->major, i), lt_array_int(s->minor, i), i))
            return bad_sparse("index outside its shape");
    return LT_OK;
}

/* csc walks columns, csr rows; indptr says where each one's entries lie. */
static lt_status fill_compressed(sparse *s, bool by_column)
{
    const int64_t n = by_column ? s->cols : s->rows;

    if (s->major->shape[0] != n + 1 || s->minor->shape[0] != s->data->shape[0] ||
        lt_array_int(s->major, 0) != 0 || lt_array_int(s->major, (size_t)n) != s->data->shape[0])
        return bad_sparse("indptr that does not fit its shape and data");
    for (int64_t j = 0; j < n; j++) {
        const int64_t begin = lt_array_int(s->major, (size_t)j);
        const int64_t end = lt_array_int(s->major, (size_t)j + 1);

        if (begin > end || begin < 0 || end > s->data->shape[0])
            return bad_sparse("indptr that is not ascending");
        for (int64_t i = begin; i < end; i++) {
            const int64_t k = lt_array_int(s->minor, (size_t)i);

            if (!put(s, by_column ? k : j, by_column ? j : k, (size_t)i))
                return bad_sparse("index outside its shape");
        }
    }
    return LT_OK;
}

static lt_status densify(lt_arena *arena, const lt_pvalue *v, lt_array *out)
{
    const bool coo = class_is(v, "coo_matrix");
    sparse s = {
        .data = lt_parray(member(v, "data")),
        .major = lt_parray(member(v, coo ? "row" : "indptr")),
        .minor = lt_parray(member(v, coo ? "col" : "indices")),
    };
    const lt_pvalue *shape = member(v, "_shape");
    lt_array dense = { .type = LT_ELEM_F8 };
    size_t bytes;
    lt_status st;

    if (!is_vector(s.data) || !is_vector(s.major) || !is_vector(s.minor) || !take_shape(shape, &dense) ||
        dense.rank != 2)
        return bad_sparse("lacks _shape, data or indices");
    s.rows = dense.shape[0];
    s.cols = dense.shape[1];
    if (!lt_array_bytes(&dense, &bytes) || bytes / 8 > ELEMENTS_MAX)
        return bad_sparse("too large when made dense");
    s.out = lt_arena_alloc(arena, bytes);
    if (!s.out)
        return lt_error(LT_ENOMEM, "no memory for %zu bytes", bytes);
    st = coo ? fill_coo(&s) : fill_compressed(&s, class_is(v, "csc_matrix"));
    dense.data = s.out;
    if (!st)
        *out = dense;
    return st;
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

/* Down to the array at the bottom of the expression, then its operations on the way back up. */
lt_status lt_pickle_dense(lt_arena *arena, const lt_pvalue *v, lt_array *out)
{
    const lt_pvalue *node[NESTING_MAX];
    int n = 0;
    lt_array a;
    lt_status st = LT_OK;

    while (v && v->kind == LT_POBJECT && strncmp(v->u.object.class_name, "chumpy.", 7) == 0) {
        if (n == NESTING_MAX)
            return lt_error(LT_EFORMAT, "chumpy expression nested deeper than %d", NESTING_MAX);
        node[n++] = v;
        v = member(v, class_is(v, "Ch") ? "x" : "a");
    }
    if (v && v->kind == LT_POBJECT && strncmp(v->u.object.class_name, "scipy.", 6) == 0)
        st = densify(arena, v, &a);
    else if (!lt_parray(v) || lt_parray(v)->type == LT_ELEM_TEXT)
        return lt_error(LT_EFORMAT, "no array of numbers");
    else
        a = *lt_parray(v);
    while (!st && n > 0)
        st = apply(arena, node[--n], &a);
    if (!st)
        *out = a;
    return st;
}
