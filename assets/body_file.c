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
    if (!st)
        *out = m;
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
