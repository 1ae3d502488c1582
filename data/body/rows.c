/* SPDX-License-Identifier: Apache-2.0 */
#include "data/body/rows.h"

#include "assets/ycb/ycb.h"
#include "libtensor/io/array/npz.h"

#include <math.h>
#include <string.h>

#define FIELD(name, type, ...) { #name, offsetof(body_row, name), type, { __VA_ARGS__ } }

/* Of a row: sizes end with 0. */
static const struct {
    const char *name;
    size_t offset;
    lt_elem type;
    int64_t size[3];
} fields[] = {
    FIELD(pose, LT_ELEM_F4, BODY_JOINTS, 3), FIELD(shape, LT_ELEM_F4, BODY_SHAPES),
    FIELD(expression, LT_ELEM_F4, BODY_EXPRESSIONS), FIELD(trans, LT_ELEM_F4, 3), FIELD(K, LT_ELEM_F4, 3, 3),
    FIELD(nodes_3d, LT_ELEM_F4, BODY_NODES, 3), FIELD(nodes_2d, LT_ELEM_F4, BODY_NODES, 2),
    FIELD(seen, LT_ELEM_U1, BODY_NODES), FIELD(boxes, LT_ELEM_F4, BODY_BOXES, 4),
    FIELD(subject, LT_ELEM_I4, 0), FIELD(holds, LT_ELEM_U1, 2), FIELD(cut, LT_ELEM_U1, 0), FIELD(sits, LT_ELEM_U1, 0),
};

/* The array of a field of n rows, without data, and the bytes of one row in it */
static lt_array array_of(size_t field, int64_t n, size_t *bytes)
{
    int64_t shape[3] = { n, 0, 0 };
    int rank = 1;

    *bytes = lt_elem_size(fields[field].type);
    for (; rank < 3 && fields[field].size[rank - 1]; rank++) {
        shape[rank] = fields[field].size[rank - 1];
        *bytes *= (size_t)shape[rank];
    }
    return lt_array_make(fields[field].type, rank, shape, NULL);
}

/* ---- writing ---- */

lt_status body_rows_write(lt_arena *arena, const char *path, const body_row *row, int64_t n)
{
    lt_named_array list[LT_COUNT(fields)];

    for (size_t f = 0; f < LT_COUNT(fields); f++) {
        size_t bytes;
        lt_array a = array_of(f, n, &bytes);
        uint8_t *data = lt_arena_array(arena, (size_t)lt_max_i64(1, n), bytes);

        if (!data)
            return lt_error(LT_ENOMEM, "%s: no memory for \"%s\"", path, fields[f].name);
        for (int64_t i = 0; i < n; i++)
            memcpy(data + (size_t)i * bytes, (const char *)&row[i] + fields[f].offset, bytes);
        a.data = data;
        list[f] = (lt_named_array){ fields[f].name, a };
    }
    return lt_npz_write(path, list, LT_COUNT(list), true);
}

/* ---- reading ---- */

static bool all_finite(const lt_array *a, int64_t *row)
{
    const size_t n = a->type == LT_ELEM_F4 ? lt_array_count(a) : 0;

    for (size_t i = 0; i < n; i++)
        if (!isfinite(((const float *)a->data)[i])) {
            *row = (int64_t)(i / (n / (size_t)a->shape[0]));
            return false;
        }
    return true;
}

static lt_status take_field(const lt_npz *npz, size_t field, int64_t n, body_row *row)
{
    const lt_array *a;
    size_t bytes;
    const lt_array want = array_of(field, n, &bytes);
    char found[128], wanted[128];
    int64_t bad;
    lt_status st = lt_npz_get(npz, fields[field].name, &a);

    if (st)
        return st;
    if (a->type != want.type || !lt_array_has_shape(a, want.rank, want.shape))
        return lt_error(LT_EFORMAT, "%s: \"%s\" is %s %s, expected %s %s", npz->path, fields[field].name,
                        lt_elem_name(a->type), lt_array_shape_text(a, found, sizeof(found)), lt_elem_name(want.type),
                        lt_array_shape_text(&want, wanted, sizeof(wanted)));
    if (!all_finite(a, &bad))
        return lt_error(LT_EFORMAT, "%s: \"%s\" of picture %lld: a number is not finite", npz->path, fields[field].name,
                        (long long)bad + 1);
    for (int64_t i = 0; i < n; i++)
        memcpy((char *)&row[i] + fields[field].offset, (const char *)a->data + (size_t)i * bytes, bytes);
    return LT_OK;
}

static lt_status check_row(const char *name, int64_t i, const body_row *r)
{
    if (!(r->K[0][0] > 0 && r->K[1][1] > 0))
        return lt_error(LT_EFORMAT, "%s: \"K\" of picture %lld: focal lengths are %g and %g, expected more than 0",
                        name, (long long)i + 1, (double)r->K[0][0], (double)r->K[1][1]);
    if (!(r->nodes_3d[0][2] > 0))
        return lt_error(LT_EFORMAT, "%s: \"nodes_3d\" of picture %lld: the pelvis is %g m before the camera, expected "
                        "more than 0", name, (long long)i + 1, (double)r->nodes_3d[0][2]);
    for (int k = 0; k < 2; k++)
        if (r->holds[k] > YCB_COUNT)
            return lt_error(LT_EFORMAT, "%s: \"holds\" of picture %lld: object %d, expected at most %d", name,
                            (long long)i + 1, r->holds[k], YCB_COUNT);
    return LT_OK;
}

lt_status body_rows_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, body_row **out,
                          int64_t *n_rows)
{
    lt_npz npz;
    const lt_array *first;
    body_row *row = NULL;
    int64_t rows = 0;
    lt_status st = lt_npz_parse(arena, name, bytes, n, &npz);

    if (!st)
        st = lt_npz_get(&npz, fields[0].name, &first);
    if (!st) {
        rows = first->rank ? first->shape[0] : 0;
        row = lt_arena_array(arena, (size_t)lt_max_i64(1, rows), sizeof(*row));
        st = row ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory for %lld rows", name, (long long)rows);
    }
    for (size_t f = 0; !st && f < LT_COUNT(fields); f++)
        st = take_field(&npz, f, rows, row);
    for (int64_t i = 0; !st && i < rows; i++)
        st = check_row(name, i, &row[i]);
    if (!st) {
        *out = row;
        *n_rows = rows;
    }
    return st;
}
