/* SPDX-License-Identifier: Apache-2.0 */
#include "assets/keyed_arrays.h"

#include "libtensor/io/array/npy_entry.h"
#include "libtensor/io/array/safetensors.h"
#include "libtensor/io/file.h"
#include "libtensor/io/pickle/dense.h"
#include "libtensor/io/torch/torch.h"

#include <math.h>
#include <string.h>

/* ---- opening ------------------------------------------------------------------------------------------- */

/* numpy.save of a dict: an array of one Python object. */
static lt_status open_npy(keyed *k)
{
    lt_refused_array refused;
    lt_array a;
    lt_status st = lt_npy_parse_entry(k->arena, k->path, k->bytes, k->n, &a, &refused);

    if (!st && (!refused.reason || !refused.pickle))
        st = lt_error(LT_EFORMAT, "%s: a .npy array, want one of a dict of arrays, or an .npz of them", k->path);
    return st ? st : lt_pickle_parse(k->arena, k->path, refused.pickle, refused.n, &k->dict);
}

static lt_status open_torch(keyed *k)
{
    lt_torch_file f;
    const lt_status st = lt_torch_parse(k->arena, k->path, k->bytes, k->n, &f);

    if (!st)
        k->dict = f.value;
    return st;
}

static lt_status open_safetensors(keyed *k)
{
    lt_safetensors s;
    const lt_status st = lt_safetensors_parse(k->arena, k->path, k->bytes, k->n, &s);

    if (!st)
        k->npz = (lt_npz){ k->path, .n = s.n, .entry = s.entry, .n_refused = s.n_refused, .refused = s.refused };
    return st;
}

static lt_status open_kind(keyed *k)
{
    switch (k->kind) {
    case LT_KIND_ZIP: case LT_KIND_NPZ:
        return lt_npz_parse_list(k->arena, k->path, k->bytes, k->n, &k->npz);
    case LT_KIND_NPY:
        return open_npy(k);
    case LT_KIND_TORCH_ZIP: case LT_KIND_TORCH_STREAM: case LT_KIND_TAR:
        return open_torch(k);
    case LT_KIND_SAFETENSORS:
        return open_safetensors(k);
    default:
        if (!lt_pickle_sniff(k->bytes, k->n))
            return lt_refuse_kind(k->path, k->kind, "an .npz, a pickle or other arrays by name");
        return lt_pickle_parse(k->arena, k->path, k->bytes, k->n, &k->dict);
    }
}

lt_status keyed_open(lt_arena *arena, const char *path, keyed *out)
{
    keyed k = { .arena = arena, .path = lt_arena_strdup(arena, path) };
    uint8_t *bytes;
    lt_status st = k.path ? lt_read_file(arena, path, (size_t)1 << 30, &bytes, &k.n)
                          : lt_error(LT_ENOMEM, "%s: no memory", path);

    if (st)
        return st;
    k.bytes = bytes;
    k.kind = lt_kind_of(bytes, k.n);
    st = open_kind(&k);
    if (!st && k.dict && k.dict->kind != LT_PDICT)
        st = lt_error(LT_EFORMAT, "%s: the pickle holds no dict", path);
    if (!st)
        *out = k;
    return st;
}

/* ---- by key ---------------------------------------------------------------------------------------------- */

bool keyed_has(const keyed *k, const char *key)
{
    if (k->dict)
        return !lt_pis_none(lt_pdict_get(k->dict, key));
    return lt_npz_find(&k->npz, key) || lt_refused_find(k->npz.refused, k->npz.n_refused, key);
}

/* The array of one key with its elements, which those of an .npz have not before. */
static lt_status load(const keyed *k, const char *key, lt_npz *one)
{
    if (k->kind == LT_KIND_ZIP || k->kind == LT_KIND_NPZ)
        return lt_npz_parse_one(k->arena, k->path, k->bytes, k->n, key, one);
    *one = k->npz;
    return LT_OK;
}

lt_status keyed_value(const keyed *k, const char *key, const lt_pvalue **out)
{
    const lt_refused_array *r = lt_refused_find(k->npz.refused, k->npz.n_refused, key);
    char *where;
    lt_npz one;
    lt_status st;

    *out = k->dict ? lt_pdict_get(k->dict, key) : NULL;
    if (!r)
        return LT_OK;
    st = load(k, key, &one);
    r = st ? NULL : lt_refused_find(one.refused, one.n_refused, key);
    if (!r || !r->pickle)
        return st;
    where = lt_arena_printf(k->arena, "%s: \"%s\"", k->path, key);
    return where ? lt_pickle_parse(k->arena, where, r->pickle, r->n, out)
                 : lt_error(LT_ENOMEM, "%s: no memory", k->path);
}

const char *keyed_text(const keyed *k, const char *key)
{
    const lt_array *a = k->dict ? NULL : lt_npz_find(&k->npz, key);
    lt_npz one;

    if (k->dict)
        return lt_pstr(lt_pdict_get(k->dict, key));
    if (!a || a->type != LT_ELEM_TEXT || lt_array_count(a) != 1 || load(k, key, &one) != LT_OK)
        return NULL;
    return lt_array_text(lt_npz_find(&one, key), 0);
}

static lt_status wrong_shape(const keyed *k, const char *key, const lt_array *a, const lt_array *want)
{
    char found[96], wanted[96];

    return lt_error(LT_EFORMAT, "%s: \"%s\": shape %s, want %s", k->path, key,
                    lt_array_shape_text(a, found, sizeof(found)), lt_array_shape_text(want, wanted, sizeof(wanted)));
}

/* An object of Python's: an array of its own, a sparse matrix, lists of numbers. */
static lt_status get_value(const keyed *k, const char *key, lt_array *out)
{
    const lt_pvalue *v;
    lt_status st = keyed_value(k, key, &v);

    if (st)
        return st;
    if (lt_pis_none(v))
        return lt_error(LT_EFORMAT, "%s: no \"%s\", which such a model must have", k->path, key);
    st = lt_pickle_dense(k->arena, v, out);
    return st ? lt_error_prefix(st, "%s: \"%s\"", k->path, key) : LT_OK;
}

/* An array, which is not unpacked before its shape is the one that is wanted. */
static lt_status get_array(const keyed *k, const char *key, const lt_array *want, lt_array *out)
{
    const lt_array *a = lt_npz_find(&k->npz, key);
    const lt_pvalue *v;
    lt_npz one;
    lt_status st;

    if (a && a->type == LT_ELEM_TEXT)
        return lt_error(LT_EFORMAT, "%s: \"%s\": text, want numbers", k->path, key);
    if (a && !lt_array_has_shape(a, want->rank, want->shape))
        return wrong_shape(k, key, a, want);
    st = a ? load(k, key, &one) : keyed_value(k, key, &v);
    if (st)
        return st;
    if (!a)
        return v ? get_value(k, key, out) : lt_npz_get(&k->npz, key, &a);
    *out = *lt_npz_find(&one, key);
    return LT_OK;
}

lt_status keyed_get(const keyed *k, const char *key, int rank, const int64_t *shape, lt_array *out)
{
    const lt_array want = lt_array_make(LT_ELEM_F4, rank, shape, NULL);
    const lt_status st = k->dict ? get_value(k, key, out) : get_array(k, key, &want, out);

    return st || lt_array_has_shape(out, rank, shape) ? st : wrong_shape(k, key, out, &want);
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
