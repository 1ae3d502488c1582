/* SPDX-License-Identifier: Apache-2.0 */
#include "assets/keyed_arrays.h"

#include "libtensor/io/file.h"
#include "libtensor/io/pickle/dense.h"

#include <math.h>
#include <string.h>

lt_status keyed_open(lt_arena *arena, const char *path, keyed *out)
{
    keyed k = { .arena = arena, .path = path };
    uint8_t *bytes;
    size_t n;
    lt_status st = lt_read_file(arena, path, (size_t)1 << 30, &bytes, &n);

    if (!st && n >= 4 && memcmp(bytes, "PK\3\4", 4) == 0)
        st = lt_npz_parse(arena, path, bytes, n, &k.npz);
    else if (!st)
        st = lt_pickle_parse(arena, path, bytes, n, &k.dict);
    if (!st && k.dict && k.dict->kind != LT_PDICT)
        st = lt_error(LT_EFORMAT, "%s: the pickle holds no dict", path);
    if (!st)
        *out = k;
    return st;
}

bool keyed_has(const keyed *k, const char *key)
{
    return k->dict ? !lt_pis_none(lt_pdict_get(k->dict, key)) : lt_npz_find(&k->npz, key) != NULL;
}

const char *keyed_text(const keyed *k, const char *key)
{
    const lt_array *a = k->dict ? NULL : lt_npz_find(&k->npz, key);

    if (k->dict)
        return lt_pstr(lt_pdict_get(k->dict, key));
    return a && lt_array_count(a) == 1 ? lt_array_text(a, 0) : NULL;
}

static lt_status get_array(const keyed *k, const char *key, lt_array *out)
{
    const lt_array *a;
    lt_status st;

    if (k->dict) {
        if (!keyed_has(k, key))
            return lt_error(LT_EFORMAT, "%s: no \"%s\", which such a model must have", k->path, key);
        st = lt_pickle_dense(k->arena, lt_pdict_get(k->dict, key), out);
        return st ? lt_error_prefix(st, "%s: \"%s\"", k->path, key) : LT_OK;
    }
    st = lt_npz_get(&k->npz, key, &a);
    if (!st && a->type == LT_ELEM_TEXT)
        st = lt_error(LT_EFORMAT, "%s: \"%s\": text, want numbers", k->path, key);
    if (!st)
        *out = *a;
    return st;
}

lt_status keyed_get(const keyed *k, const char *key, int rank, const int64_t *shape, lt_array *out)
{
    const lt_array want = lt_array_make(LT_ELEM_F4, rank, shape, NULL);
    char found[96], wanted[96];
    const lt_status st = get_array(k, key, out);

    if (st || lt_array_has_shape(out, rank, shape))
        return st;
    return lt_error(LT_EFORMAT, "%s: \"%s\": shape %s, want %s", k->path, key,
                    lt_array_shape_text(out, found, sizeof(found)),
                    lt_array_shape_text(&want, wanted, sizeof(wanted)));
}

lt_status keyed_floats(const keyed *k, const char *key, int rank, const int64_t *shape, float *out)
{
    lt_array a;
    const lt_status st = keyed_get(k, key, rank, shape, &a);
    const size_t n = st ? 0 : lt_array_count(&a);

    if (n)
        lt_array_to_float(&a, out, n);
    for (size_t i = 0; i < n; i++)
        if (!isfinite(out[i]))
            return lt_error(LT_EFORMAT, "%s: \"%s\": element %zu is not finite", k->path, key, i);
    return st;
}

lt_status keyed_faces(const keyed *k, const char *key, int n, int n_vertices, int32_t (*out)[3])
{
    lt_array a;
    const lt_status st = keyed_get(k, key, 2, (int64_t[]){ n, 3 }, &a);

    for (size_t i = 0; !st && i < 3 * (size_t)n; i++) {
        const int64_t v = lt_array_int(&a, i);

        if (v < 0 || v >= n_vertices)
            return lt_error(LT_EFORMAT, "%s: \"%s\": vertex %lld in triangle %zu, want 0 to %d", k->path, key,
                            (long long)v, i / 3, n_vertices - 1);
        out[i / 3][i % 3] = (int32_t)v;
    }
    return st;
}

lt_status keyed_sums(const keyed *k, const char *key, const float *weights, int n, int width)
{
    for (int row = 0; row < n; row++) {
        double sum = 0;

        for (int i = 0; i < width; i++)
            sum += weights[(size_t)row * (size_t)width + (size_t)i];
        if (fabs(sum - 1) > 1e-3)
            return lt_error(LT_EFORMAT, "%s: \"%s\": row %d sums to %g, want 1", k->path, key, row, sum);
    }
    return LT_OK;
}
