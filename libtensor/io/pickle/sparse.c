/* SPDX-License-Identifier: Apache-2.0 */
/*
 * SciPy's sparse matrices and arrays: seven ways to say which elements are not zero. Each is made dense, for what
 * people keep so are regressors of some thousand columns.
 *
 * Source: scipy.sparse _bsr.py, _coo.py, _csc.py, _csr.py, _dia.py, _dok.py, _lil.py; the members are the same under
 * all names that these modules have had.
 */
#include "libtensor/io/pickle/sparse.h"

#include <string.h>

typedef struct {
    const lt_pvalue *object;
    int64_t rows, cols;
    double *out;                            /* (rows, cols) */
} sparse;

static lt_status bad(const char *what)
{
    return lt_error(LT_EFORMAT, "sparse matrix: %s", what);
}

static const lt_pvalue *member(const sparse *s, const char *name)
{
    return lt_pdict_get(s->object->u.object.state, name);
}

/* The array of numbers of this rank that v is; NULL where it is none. */
static const lt_array *array_of(const lt_pvalue *v, int rank)
{
    const lt_array *a = lt_parray(v);

    return a && a->type != LT_ELEM_TEXT && a->rank == rank ? a : NULL;
}

bool lt_take_shape(const lt_pvalue *v, lt_array *out)
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
        if (out->shape[i] < 0 || out->shape[i] > LT_DENSE_MAX)
            return false;
    }
    return true;
}

/* SciPy adds up repeated places. */
static bool put(sparse *s, int64_t row, int64_t col, double x)
{
    if (row < 0 || row >= s->rows || col < 0 || col >= s->cols)
        return false;
    s->out[row * s->cols + col] += x;
    return true;
}

/* ---- coo: row, column and value of each; since SciPy 1.13 the first two are "coords" ---------------- */

static lt_status fill_coo(sparse *s)
{
    const lt_pvalue *coords = member(s, "coords");
    const bool pair = coords && coords->kind == LT_PTUPLE && coords->n == 2;
    const lt_array *data = array_of(member(s, "data"), 1);
    const lt_array *row = array_of(pair ? coords->u.item[0] : member(s, "row"), 1);
    const lt_array *col = array_of(pair ? coords->u.item[1] : member(s, "col"), 1);

    if (!data || !row || !col)
        return bad("lacks data, rows or columns");
    if (row->shape[0] != data->shape[0] || col->shape[0] != data->shape[0])
        return bad("rows, columns and data of different lengths");
    for (size_t i = 0; i < (size_t)data->shape[0]; i++)
        if (!put(s, lt_array_int(row, i), lt_array_int(col, i), lt_array_get(data, i)))
            return bad("index outside its shape");
    return LT_OK;
}

/* ---- csc walks columns, csr rows, bsr rows of blocks: indptr says where each one's entries lie ------ */

typedef struct {
    const lt_array *data, *indptr, *indices;
    int64_t major, high, wide;              /* how many are walked; size of a block */
    bool by_column;
} compressed;

static bool put_block(sparse *s, const compressed *c, int64_t major, int64_t minor, size_t i)
{
    const size_t size = (size_t)(c->high * c->wide);

    if (minor < 0 || minor > LT_DENSE_MAX)
        return false;
    for (size_t k = 0; k < size; k++) {
        const int64_t r = (c->by_column ? minor : major) * c->high + (int64_t)k / c->wide;
        const int64_t q = (c->by_column ? major : minor) * c->wide + (int64_t)k % c->wide;

        if (!put(s, r, q, lt_array_get(c->data, i * size + k)))
            return false;
    }
    return true;
}

static lt_status walk_compressed(sparse *s, const compressed *c)
{
    const int64_t n = c->data->shape[0];

    if (c->indptr->shape[0] != c->major + 1 || c->indices->shape[0] != n || lt_array_int(c->indptr, 0) != 0 ||
        lt_array_int(c->indptr, (size_t)c->major) != n)
        return bad("indptr that does not fit its shape and data");
    for (int64_t j = 0; j < c->major; j++) {
        const int64_t begin = lt_array_int(c->indptr, (size_t)j), end = lt_array_int(c->indptr, (size_t)j + 1);

        if (begin > end || begin < 0 || end > n)
            return bad("indptr that is not ascending");
        for (int64_t i = begin; i < end; i++)
            if (!put_block(s, c, j, lt_array_int(c->indices, (size_t)i), (size_t)i))
                return bad("index outside its shape");
    }
    return LT_OK;
}

static lt_status fill_compressed(sparse *s, bool by_column, bool blocks)
{
    compressed c = {
        .data = array_of(member(s, "data"), blocks ? 3 : 1), .indptr = array_of(member(s, "indptr"), 1),
        .indices = array_of(member(s, "indices"), 1), .high = 1, .wide = 1, .by_column = by_column,
    };

    if (!c.data || !c.indptr || !c.indices)
        return bad("lacks data, indptr or indices");
    if (blocks) {
        c.high = c.data->shape[1];
        c.wide = c.data->shape[2];
    }
    if (c.high < 1 || c.wide < 1 || s->rows % c.high || s->cols % c.wide)
        return bad("blocks that do not fit its shape");
    c.major = by_column ? s->cols : s->rows / c.high;
    return walk_compressed(s, &c);
}

/* ---- dia: diagonals; each has its element of column j at place j ------------------------------------ */

static lt_status fill_dia(sparse *s)
{
    const lt_array *data = array_of(member(s, "data"), 2), *offsets = array_of(member(s, "offsets"), 1);

    if (!data || !offsets)
        return bad("lacks data or offsets");
    if (offsets->shape[0] != data->shape[0])
        return bad("diagonals and offsets of different lengths");
    for (int64_t k = 0; k < data->shape[0]; k++) {
        const int64_t offset = lt_array_int(offsets, (size_t)k);

        if (offset <= -s->rows || offset >= s->cols)        /* what lies outside is cut */
            continue;
        for (int64_t j = offset > 0 ? offset : 0; j < data->shape[1] && j < s->cols && j - offset < s->rows; j++)
            put(s, j - offset, j, lt_array_get(data, (size_t)(k * data->shape[1] + j)));
    }
    return LT_OK;
}

/* ---- lil: lists of columns and of values for each row ------------------------------------------------ */

static lt_status fill_lil(sparse *s)
{
    const lt_pvalue *rows = member(s, "rows"), *data = member(s, "data");

    if (!rows || !data || rows->kind != LT_PLIST || data->kind != LT_PLIST)
        return bad("lacks rows or data");
    if (rows->n != (size_t)s->rows || data->n != rows->n)
        return bad("as many lists as it has no rows");
    for (size_t r = 0; r < rows->n; r++) {
        const lt_pvalue *cols = rows->u.item[r], *values = data->u.item[r];

        if (cols->kind != LT_PLIST || values->kind != LT_PLIST || cols->n != values->n)
            return bad("rows, columns and data of different lengths");
        if (cols->n > (size_t)s->cols)                      /* they may be shared, and walked for each row */
            return bad("more elements in a row than it has columns");
        for (size_t i = 0; i < cols->n; i++) {
            int64_t col;
            double x;

            if (!lt_pint(cols->u.item[i], &col) || !lt_pfloat(values->u.item[i], &x))
                return bad("an element that is no number");
            if (!put(s, (int64_t)r, col, x))
                return bad("index outside its shape");
        }
    }
    return LT_OK;
}

/* ---- dok: a dict by row and column; it is one itself, or since SciPy 1.12 keeps one ------------------ */

static lt_status fill_dok(sparse *s)
{
    const lt_pvalue *dict = member(s, "_dict") ? member(s, "_dict") : s->object->items;

    if (!dict || dict->kind != LT_PDICT)
        return bad("lacks its dict");
    for (size_t i = 0; i < dict->n; i++) {
        const lt_pvalue *key = dict->u.item[2 * i];
        int64_t row, col;
        double x;

        if (key->kind != LT_PTUPLE || key->n != 2 || !lt_pint(key->u.item[0], &row) ||
            !lt_pint(key->u.item[1], &col) || !lt_pfloat(dict->u.item[2 * i + 1], &x))
            return bad("an element that is no number, or whose place is none");
        if (!put(s, row, col, x))
            return bad("index outside its shape");
    }
    return LT_OK;
}

/* ---- all ---------------------------------------------------------------------------------------------- */

/* "csc" of "scipy.sparse._csc.csc_matrix" and "scipy.sparse._arrays.csc_array"; "" of anything else */
static const char *format_of(const lt_pvalue *v)
{
    static const char *const formats[] = { "bsr", "coo", "csc", "csr", "dia", "dok", "lil" };
    const char *name = v->kind == LT_POBJECT ? v->u.object.class_name : "", *dot = strrchr(name, '.');

    if (strncmp(name, "scipy.sparse.", 13) != 0)
        return "";
    for (size_t i = 0; i < LT_COUNT(formats); i++)
        if (strncmp(dot + 1, formats[i], 3) == 0 &&
            (strcmp(dot + 4, "_matrix") == 0 || strcmp(dot + 4, "_array") == 0))
            return formats[i];
    return "";
}

bool lt_is_sparse(const lt_pvalue *v)
{
    return *format_of(v) != '\0';
}

static lt_status fill(sparse *s, const char *format)
{
    if (strcmp(format, "coo") == 0)
        return fill_coo(s);
    if (strcmp(format, "dok") == 0)
        return fill_dok(s);
    if (strcmp(format, "dia") == 0)
        return fill_dia(s);
    if (strcmp(format, "lil") == 0)
        return fill_lil(s);
    return fill_compressed(s, strcmp(format, "csc") == 0, strcmp(format, "bsr") == 0);
}

lt_status lt_sparse_dense(lt_arena *arena, const lt_pvalue *v, lt_array *out)
{
    sparse s = { .object = v };
    lt_array dense = { .type = LT_ELEM_F8 };
    size_t bytes;
    lt_status st;

    if (!lt_take_shape(member(&s, "_shape"), &dense) || dense.rank != 2)
        return bad("lacks _shape, of rows and columns");
    s.rows = dense.shape[0];
    s.cols = dense.shape[1];
    if (!lt_array_bytes(&dense, &bytes) || bytes / sizeof(*s.out) > LT_DENSE_MAX)
        return bad("too large when made dense");
    st = lt_arena_try(arena, bytes, (void **)&s.out);
    if (st)
        return st;
    st = fill(&s, format_of(v));
    dense.data = s.out;
    if (!st)
        *out = dense;
    return st;
}
