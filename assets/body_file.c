/* SPDX-License-Identifier: Apache-2.0 */
#include "assets/body_file.h"

#include "assets/keyed_arrays.h"

#include <string.h>

enum { V = BODY_VERTICES, F = BODY_FACES, J = BODY_JOINTS, P = BODY_HAND_PCA };

/* Files with few directions have ten of each kind, others a hundred expressions behind the shapes. */
static lt_status count_directions(const keyed *k, body_model *m)
{
    lt_array a;
    const lt_status st = keyed_get(k, "shapedirs", 3, (int64_t[]){ V, 3, -1 }, &a);
    const int n = st ? 0 : (int)lt_min_i64(a.shape[2], 100000);

    if (!st && n != 20 && n <= 100)
        return lt_error(LT_EFORMAT, "%s: \"shapedirs\": %d directions, want 20, or more than 100", k->path, n);
    m->expressions = n == 20 ? 10 : 100;
    m->shapes = n - m->expressions;
    return st;
}

/* The root is written as -1 or as an unsigned number's largest. */
static lt_status take_tree(const keyed *k, body_model *m)
{
    lt_array a;
    const lt_status st = keyed_get(k, "kintree_table", 2, (int64_t[]){ 2, J }, &a);

    for (int j = 0; !st && j < J; j++) {
        const int64_t parent = lt_array_int(&a, (size_t)j);

        m->parent[j] = j == 0 ? -1 : (int)lt_max_i64(-1, lt_min_i64(parent, J));
        if (j > 0 && (m->parent[j] < 0 || m->parent[j] >= j))
            return lt_error(LT_EFORMAT, "%s: \"kintree_table\": joint %d hangs on %lld, want one before it", k->path, j,
                            (long long)parent);
    }
    return st;
}

static lt_status fill(lt_arena *arena, const keyed *k, body_model *m)
{
    const int64_t directions = m->shapes + m->expressions;
    const struct {
        const char *key;
        int rank;
        int64_t shape[3];
        void *out;
    } list[] = {
        { "v_template", 2, { V, 3 }, &m->v_template }, { "shapedirs", 3, { V, 3, directions }, &m->shapedirs },
        { "posedirs", 3, { V, 3, BODY_FEATURES }, &m->posedirs }, { "J_regressor", 2, { J, V }, &m->J_regressor },
        { "weights", 2, { V, J }, &m->weights }, { "hands_componentsl", 2, { P, P }, &m->hand_components[0] },
        { "hands_componentsr", 2, { P, P }, &m->hand_components[1] }, { "hands_meanl", 1, { P }, &m->hand_mean[0] },
        { "hands_meanr", 1, { P }, &m->hand_mean[1] },
    };
    lt_status st = LT_OK;

    for (size_t i = 0; i < LT_COUNT(list) && !st; i++) {
        const lt_array want = lt_array_make(LT_ELEM_F4, list[i].rank, list[i].shape, NULL);
        float *out = lt_arena_array(arena, lt_array_count(&want), sizeof(*out));

        if (!out)
            return lt_error(LT_ENOMEM, "%s: no memory for \"%s\"", k->path, list[i].key);
        st = keyed_floats(k, list[i].key, list[i].rank, list[i].shape, out);
        memcpy(list[i].out, &out, sizeof(out));
    }
    m->faces = lt_arena_array(arena, F, sizeof(*m->faces));
    if (!st && !m->faces)
        st = lt_error(LT_ENOMEM, "%s: no memory", k->path);
    return st ? st : keyed_faces(k, "f", F, V, m->faces);
}

lt_status body_file_take(lt_arena *arena, const keyed *k, body_model **out)
{
    body_model *m = lt_arena_alloc(arena, sizeof(*m));
    lt_status st = m ? count_directions(k, m) : lt_error(LT_ENOMEM, "%s: no memory", k->path);

    if (!st)
        st = fill(arena, k, m);
    if (!st)
        st = take_tree(k, m);
    if (!st)
        st = keyed_sums(k, "weights", m->weights, V, J);
    if (!st) {
        const char *kind = keyed_text(k, "asset_kind");

        m->synthetic = kind && strcmp(kind, "synthetic") == 0;
        *out = m;
    }
    return st;
}

lt_status body_file_read(lt_arena *arena, const char *path, body_model **out)
{
    lt_arena *scratch = lt_arena_new();
    keyed k;
    lt_status st = scratch ? keyed_open(scratch, path, &k) : lt_error(LT_ENOMEM, "%s: no memory", path);

    if (!st)
        st = body_file_take(arena, &k, out);
    lt_arena_free(scratch);
    return st;
}

static lt_named_array named(const char *name, lt_elem type, int rank, const int64_t *shape, const void *data)
{
    return (lt_named_array){ name, lt_array_make(type, rank, shape, data) };
}

lt_status body_file_write(const char *path, const body_model *m)
{
    const char *kind = m->synthetic ? "synthetic" : "smplx";
    int32_t tree[2][J];

    for (int j = 0; j < J; j++) {
        tree[0][j] = m->parent[j];
        tree[1][j] = j;
    }
    const lt_named_array list[] = {
        named("v_template", LT_ELEM_F4, 2, (int64_t[]){ V, 3 }, m->v_template),
        named("shapedirs", LT_ELEM_F4, 3, (int64_t[]){ V, 3, m->shapes + m->expressions }, m->shapedirs),
        named("posedirs", LT_ELEM_F4, 3, (int64_t[]){ V, 3, BODY_FEATURES }, m->posedirs),
        named("J_regressor", LT_ELEM_F4, 2, (int64_t[]){ J, V }, m->J_regressor),
        named("weights", LT_ELEM_F4, 2, (int64_t[]){ V, J }, m->weights),
        named("f", LT_ELEM_I4, 2, (int64_t[]){ F, 3 }, m->faces),
        named("kintree_table", LT_ELEM_I4, 2, (int64_t[]){ 2, J }, tree),
        named("hands_componentsl", LT_ELEM_F4, 2, (int64_t[]){ P, P }, m->hand_components[0]),
        named("hands_componentsr", LT_ELEM_F4, 2, (int64_t[]){ P, P }, m->hand_components[1]),
        named("hands_meanl", LT_ELEM_F4, 1, (int64_t[]){ P }, m->hand_mean[0]),
        named("hands_meanr", LT_ELEM_F4, 1, (int64_t[]){ P }, m->hand_mean[1]),
        named("asset_kind", LT_ELEM_TEXT, 0, NULL, &kind),
    };
    return lt_npz_write(path, list, LT_COUNT(list), true);
}
