/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Hand models on disk. One list of keys, whichever of the two formats they come from.
 */
#include "libtensor/io/hand_file.h"

#include "libtensor/io/file.h"
#include "libtensor/io/npz.h"
#include "libtensor/io/pickle.h"
#include "libtensor/io/pickle_dense.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Where arrays come from: exactly one of the two. */
typedef struct {
    lt_arena *arena;                    /* scratch */
    const char *path;
    const lt_npz *npz;
    const lt_pvalue *dict;
} source;

/* False, and no error, when the key is not there. */
static bool has_key(const source *s, const char *key)
{
    return s->npz ? lt_npz_find(s->npz, key) != NULL : !lt_pis_none(lt_pdict_get(s->dict, key));
}

static lt_status get_array(const source *s, const char *key, lt_array *out)
{
    const lt_array *a;
    lt_status st;

    if (s->npz) {
        st = lt_npz_get(s->npz, key, &a);
        if (st)
            return st;
        if (a->type == LT_ELEM_TEXT)
            return lt_error(LT_EFORMAT, "%s: \"%s\": text, want numbers", s->path, key);
        *out = *a;
        return LT_OK;
    }
    if (!has_key(s, key))
        return lt_error(LT_EFORMAT, "%s: no \"%s\", which a hand model must have", s->path, key);
    st = lt_pickle_dense(s->arena, lt_pdict_get(s->dict, key), out);
    return st ? lt_error_prefix(st, "%s: \"%s\"", s->path, key) : LT_OK;
}

/* The array under key, of exactly this shape; -1 matches any. */
static lt_status get_shaped(const source *s, const char *key, int rank, const int64_t *shape, lt_array *out)
{
    const lt_array want = lt_array_make(LT_ELEM_F4, rank, shape, NULL);
    char found[96], wanted[96];
    lt_status st = get_array(s, key, out);

    if (st || lt_array_has_shape(out, rank, shape))
        return st;
    return lt_error(LT_EFORMAT, "%s: \"%s\": shape %s, want %s", s->path, key,
                    lt_array_shape_text(out, found, sizeof(found)),
                    lt_array_shape_text(&want, wanted, sizeof(wanted)));
}

static lt_status get_floats(const source *s, const char *key, int rank, const int64_t *shape, float *out)
{
    lt_array a;
    lt_status st = get_shaped(s, key, rank, shape, &a);
    const size_t n = st ? 0 : lt_array_count(&a);

    lt_array_to_float(&a, out, n);
    for (size_t i = 0; i < n; i++)
        if (!isfinite(out[i]))
            return lt_error(LT_EFORMAT, "%s: \"%s\": element %zu is not finite", s->path, key, i);
    return st;
}

/* The first 10 of however many directions the file has. */
static lt_status get_shapedirs(const source *s, lt_hand_model *m)
{
    lt_array a;
    lt_status st = get_shaped(s, "shapedirs", 3, (int64_t[]){ LT_HAND_VERTICES, 3, -1 }, &a);
    float *out = &m->shapedirs[0][0][0];

    if (st)
        return st;
    if (a.shape[2] < LT_HAND_BETAS)
        return lt_error(LT_EFORMAT, "%s: \"shapedirs\": %lld directions, want at least %d", s->path,
                        (long long)a.shape[2], LT_HAND_BETAS);
    for (size_t row = 0; row < LT_HAND_VERTICES * 3; row++) {
        for (size_t k = 0; k < LT_HAND_BETAS; k++, out++) {
            *out = (float)lt_array_get(&a, row * (size_t)a.shape[2] + k);
            if (!isfinite(*out))
                return lt_error(LT_EFORMAT, "%s: \"shapedirs\": a number is not finite", s->path);
        }
    }
    return LT_OK;
}

static lt_status get_faces(const source *s, lt_hand_model *m)
{
    lt_array a;
    lt_status st = get_shaped(s, "f", 2, (int64_t[]){ LT_HAND_FACES, 3 }, &a);

    for (size_t i = 0; !st && i < LT_HAND_FACES * 3; i++) {
        const int64_t v = lt_array_int(&a, i);

        if (v < 0 || v >= LT_HAND_VERTICES)
            return lt_error(LT_EFORMAT, "%s: \"f\": vertex %lld in triangle %zu, want 0 to %d", s->path,
                            (long long)v, i / 3, LT_HAND_VERTICES - 1);
        m->faces[i / 3][i % 3] = (int32_t)v;
    }
    return st;
}

/* The tree must be MANO's; its root is written as -1 or as the unsigned 2^32 - 1. */
static lt_status check_tree(const source *s)
{
    lt_array a;
    lt_status st;

    if (!has_key(s, "kintree_table"))
        return LT_OK;
    st = get_shaped(s, "kintree_table", 2, (int64_t[]){ 2, LT_HAND_JOINTS }, &a);
    for (size_t j = 0; !st && j < LT_HAND_JOINTS; j++) {
        const int64_t parent = lt_array_int(&a, j);
        const bool root = parent < 0 || parent == UINT32_MAX;

        if ((root ? -1 : parent) != lt_hand_parent[j])
            return lt_error(LT_EFORMAT, "%s: \"kintree_table\": joint %zu hangs on %lld, want %d", s->path,
                            j, (long long)parent, lt_hand_parent[j]);
    }
    return st;
}

static lt_status check_weights(const source *s, const lt_hand_model *m)
{
    for (int v = 0; v < LT_HAND_VERTICES; v++) {
        double sum = 0;

        for (int j = 0; j < LT_HAND_JOINTS; j++)
            sum += m->weights[v][j];
        if (fabs(sum - 1) > 1e-3)
            return lt_error(LT_EFORMAT, "%s: \"weights\": row %d sums to %g, want 1", s->path, v, sum);
    }
    return LT_OK;
}

/* A right hand's middle finger points from the wrist to -x. */
static bool points_to_plus_x(const lt_hand_model *m)
{
    const int middle_tip = lt_hand_tips_ho3d[2];
    double wrist = 0;

    for (int v = 0; v < LT_HAND_VERTICES; v++)
        wrist += (double)m->J_regressor[0][v] * m->v_template[v][0];
    return m->v_template[middle_tip][0] > wrist;
}

static bool is_synthetic(const source *s)
{
    const lt_array *a = s->npz ? lt_npz_find(s->npz, "asset_kind") : NULL;
    const char *kind = a && lt_array_count(a) == 1 ? lt_array_text(a, 0) : NULL;

    if (s->dict)
        kind = lt_pstr(lt_pdict_get(s->dict, "asset_kind"));
    return kind && strcmp(kind, "synthetic") == 0;
}

static lt_status fill_model(const source *s, lt_hand_model *m)
{
    const struct {
        const char *key;
        int rank;
        int64_t shape[3];
        float *out;
    } list[] = {
        { "v_template", 2, { LT_HAND_VERTICES, 3 }, &m->v_template[0][0] },
        { "posedirs", 3, { LT_HAND_VERTICES, 3, LT_HAND_POSE_FEATURES }, &m->posedirs[0][0][0] },
        { "J_regressor", 2, { LT_HAND_JOINTS, LT_HAND_VERTICES }, &m->J_regressor[0][0] },
        { "weights", 2, { LT_HAND_VERTICES, LT_HAND_JOINTS }, &m->weights[0][0] },
        { "hands_mean", 1, { LT_HAND_PCA }, m->hands_mean },
        { "hands_components", 2, { LT_HAND_PCA, LT_HAND_PCA }, &m->hands_components[0][0] },
    };
    lt_status st = LT_OK;

    for (size_t i = 0; i < LT_COUNT(list) && !st; i++)
        st = get_floats(s, list[i].key, list[i].rank, list[i].shape, list[i].out);
    if (!st)
        st = get_shapedirs(s, m);
    if (!st)
        st = get_faces(s, m);
    if (!st)
        st = check_tree(s);
    if (!st)
        st = check_weights(s, m);
    m->left = !st && points_to_plus_x(m);
    m->synthetic = !st && is_synthetic(s);
    return st;
}

static lt_status open_source(source *s, const uint8_t *bytes, size_t n, lt_npz *npz)
{
    lt_status st;

    if (n >= 4 && memcmp(bytes, "PK\3\4", 4) == 0) {
        st = lt_npz_parse(s->arena, s->path, bytes, n, npz);
        s->npz = npz;
        return st;
    }
    st = lt_pickle_parse(s->arena, s->path, bytes, n, &s->dict);
    if (!st && s->dict->kind != LT_PDICT)
        st = lt_error(LT_EFORMAT, "%s: the pickle holds no dict", s->path);
    return st;
}

static lt_status read_model(lt_arena *arena, lt_arena *scratch, const char *path, lt_hand_model **out)
{
    source s = { .arena = scratch, .path = path };
    void *model;
    uint8_t *bytes;
    lt_npz npz;
    lt_status st;
    size_t n;

    st = lt_read_file(scratch, path, (size_t)1 << 30, &bytes, &n);
    if (!st)
        st = open_source(&s, bytes, n, &npz);
    if (!st)
        st = lt_arena_try(arena, sizeof(lt_hand_model), &model);
    if (!st)
        st = fill_model(&s, model);
    if (!st)
        *out = model;
    return st;
}

lt_status lt_hand_model_read(lt_arena *arena, const char *path, lt_hand_model **out)
{
    lt_arena *scratch = lt_arena_new();
    lt_status st;

    if (!scratch)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    st = read_model(arena, scratch, path, out);
    lt_arena_free(scratch);
    return st;
}

static lt_named_array named(const char *name, lt_elem type, int rank, const int64_t *shape,
                            const void *data)
{
    return (lt_named_array){ name, lt_array_make(type, rank, shape, data) };
}

lt_status lt_hand_model_write(const char *path, const lt_hand_model *m)
{
    enum { V = LT_HAND_VERTICES, F = LT_HAND_FACES, J = LT_HAND_JOINTS, P = LT_HAND_PCA };
    const char *kind = m->synthetic ? "synthetic" : "mano";
    int32_t tree[2][J];

    for (int j = 0; j < J; j++) {
        tree[0][j] = lt_hand_parent[j];
        tree[1][j] = j;
    }
    const lt_named_array list[] = {
        named("v_template", LT_ELEM_F4, 2, (int64_t[]){ V, 3 }, m->v_template),
        named("shapedirs", LT_ELEM_F4, 3, (int64_t[]){ V, 3, LT_HAND_BETAS }, m->shapedirs),
        named("posedirs", LT_ELEM_F4, 3, (int64_t[]){ V, 3, LT_HAND_POSE_FEATURES }, m->posedirs),
        named("J_regressor", LT_ELEM_F4, 2, (int64_t[]){ J, V }, m->J_regressor),
        named("weights", LT_ELEM_F4, 2, (int64_t[]){ V, J }, m->weights),
        named("f", LT_ELEM_I4, 2, (int64_t[]){ F, 3 }, m->faces),
        named("kintree_table", LT_ELEM_I4, 2, (int64_t[]){ 2, J }, tree),
        named("hands_mean", LT_ELEM_F4, 1, (int64_t[]){ P }, m->hands_mean),
        named("hands_components", LT_ELEM_F4, 2, (int64_t[]){ P, P }, m->hands_components),
        named("asset_kind", LT_ELEM_TEXT, 0, NULL, &kind),
    };
    return lt_npz_write(path, list, LT_COUNT(list), true);
}
