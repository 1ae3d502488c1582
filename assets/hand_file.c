/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Hand models on disk. One list of keys, whichever of the two formats they come from.
 */
#include "assets/hand_file.h"

#include "assets/keyed_arrays.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The first 10 of however many directions the file has. */
static lt_status get_shapedirs(const keyed *k, lt_hand_model *m)
{
    lt_array a;
    lt_status st = keyed_get(k, "shapedirs", 3, (int64_t[]){ LT_HAND_VERTICES, 3, -1 }, &a);
    float *out = &m->shapedirs[0][0][0];

    if (st)
        return st;
    if (a.shape[2] < LT_HAND_BETAS)
        return lt_error(LT_EFORMAT, "%s: \"shapedirs\": %lld directions, want at least %d", k->path,
                        (long long)a.shape[2], LT_HAND_BETAS);
    for (size_t row = 0; row < LT_HAND_VERTICES * 3; row++) {
        for (size_t b = 0; b < LT_HAND_BETAS; b++, out++) {
            *out = (float)lt_array_get(&a, row * (size_t)a.shape[2] + b);
            if (!isfinite(*out))
                return lt_error(LT_EFORMAT, "%s: \"shapedirs\": a number is not finite", k->path);
        }
    }
    return LT_OK;
}

/* The tree must be MANO's; its root is written as -1 or as the unsigned 2^32 - 1. */
static lt_status check_tree(const keyed *k)
{
    lt_array a;
    lt_status st;

    if (!keyed_has(k, "kintree_table"))
        return LT_OK;
    st = keyed_get(k, "kintree_table", 2, (int64_t[]){ 2, LT_HAND_JOINTS }, &a);
    for (size_t j = 0; !st && j < LT_HAND_JOINTS; j++) {
        const int64_t parent = lt_array_int(&a, j);
        const bool root = parent < 0 || parent == UINT32_MAX;

        if ((root ? -1 : parent) != lt_hand_parent[j])
            return lt_error(LT_EFORMAT, "%s: \"kintree_table\": joint %zu hangs on %lld, want %d", k->path,
                            j, (long long)parent, lt_hand_parent[j]);
    }
    return st;
}

/* ---- size and axes --------------------------------------------------------------------------------- */

/* Longest side of the box around the mean hand. */
static double hand_span(const lt_hand_model *m)
{
    double span = 0;

    for (int d = 0; d < 3; d++) {
        float low = m->v_template[0][d], high = low;

        for (int v = 1; v < LT_HAND_VERTICES; v++) {
            low = fminf(low, m->v_template[v][d]);
            high = fmaxf(high, m->v_template[v][d]);
        }
        span = fmax(span, (double)high - low);
    }
    return span;
}

/* A grown hand is about 0.2 long; one that is not may be in another unit. */
static lt_status check_size(const char *path, const lt_hand_model *m)
{
    static const struct {
        const char *name;
        double metres;
    } units[] = { { "millimetres", 1e-3 }, { "centimetres", 1e-2 }, { "inches", 0.0254 } };
    const double span = hand_span(m);

    if (span > 0.05 && span < 0.6)
        return LT_OK;
    for (size_t i = 0; i < LT_COUNT(units); i++)
        if (span * units[i].metres > 0.1 && span * units[i].metres < 0.35)
            return lt_error(LT_EFORMAT, "%s: \"v_template\" spans %.3g, and a hand some 0.2 metres: in %s? then "
                            "multiply v_template, shapedirs and posedirs by %g", path, span, units[i].name,
                            units[i].metres);
    return lt_error(LT_EFORMAT, "%s: \"v_template\" spans %.3g, and a hand some 0.2 metres", path, span);
}

/* From the wrist to the tip of the middle finger: along -x in a right hand, along x in a left one. */
static void finger_direction(const lt_hand_model *m, double out[3])
{
    const int middle_tip = lt_hand_tips_ho3d[2];

    for (int d = 0; d < 3; d++) {
        out[d] = m->v_template[middle_tip][d];
        for (int v = 0; v < LT_HAND_VERTICES; v++)
            out[d] -= (double)m->J_regressor[0][v] * m->v_template[v][d];
    }
}

static lt_status check_axes(const char *path, const lt_hand_model *m)
{
    double along[3];
    int longest = 0;

    finger_direction(m, along);
    for (int d = 1; d < 3; d++)
        if (fabs(along[d]) > fabs(along[longest]))
            longest = d;
    if (longest == 0)
        return LT_OK;
    return lt_error(LT_EFORMAT, "%s: \"v_template\": the middle finger points along %c, and MANO's along x: axes "
                    "swapped?", path, "xyz"[longest]);
}

static bool points_to_plus_x(const lt_hand_model *m)
{
    double along[3];

    finger_direction(m, along);
    return along[0] > 0;
}

/* ---- reading --------------------------------------------------------------------------------------- */

static bool is_synthetic(const keyed *k)
{
    const char *kind = keyed_text(k, "asset_kind");

    return kind && strcmp(kind, "synthetic") == 0;
}

static lt_status fill_model(const keyed *k, lt_hand_model *m)
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
        st = keyed_floats(k, list[i].key, list[i].rank, list[i].shape, list[i].out);
    if (!st)
        st = get_shapedirs(k, m);
    if (!st)
        st = keyed_faces(k, "f", LT_HAND_FACES, LT_HAND_VERTICES, m->faces);
    if (!st)
        st = check_tree(k);
    if (!st)
        st = keyed_sums(k, "weights", &m->weights[0][0], LT_HAND_VERTICES, LT_HAND_JOINTS);
    if (!st)
        st = check_size(k->path, m);
    if (!st)
        st = check_axes(k->path, m);
    m->left = !st && points_to_plus_x(m);
    m->synthetic = !st && is_synthetic(k);
    return st;
}

lt_status hand_file_take(lt_arena *arena, const keyed *k, lt_hand_model **out)
{
    void *model;
    lt_status st = lt_arena_try(arena, sizeof(lt_hand_model), &model);

    if (!st)
        st = fill_model(k, model);
    if (!st)
        *out = model;
    return st;
}

lt_status hand_file_read(lt_arena *arena, const char *path, lt_hand_model **out)
{
    lt_arena *scratch = lt_arena_new();
    keyed k;
    lt_status st = scratch ? keyed_open(scratch, path, &k) : lt_error(LT_ENOMEM, "%s: no memory", path);

    if (!st)
        st = hand_file_take(arena, &k, out);
    lt_arena_free(scratch);
    return st;
}

/* ---- left hands ----------------------------------------------------------------------------------- */

bool hand_left_is_flipped(const lt_hand_model *left, const lt_hand_model *right)
{
    double apart = 0;

    for (int v = 0; v < LT_HAND_VERTICES; v++)
        for (int b = 0; b < LT_HAND_BETAS; b++)
            apart += fabs((double)left->shapedirs[v][0][b] - right->shapedirs[v][0][b]);
    return left->left && !right->left && apart < 1;
}

void hand_left_shape(lt_hand_model *left, hand_left_fix how)
{
    const int axes = how == HAND_LEFT_AS_IS ? 0 : how == HAND_LEFT_FIX_X ? 1 : 3;

    for (int v = 0; v < LT_HAND_VERTICES; v++)
        for (int k = 0; k < axes; k++)
            for (int b = 0; b < LT_HAND_BETAS; b++)
                left->shapedirs[v][k][b] = -left->shapedirs[v][k][b];
}

/* ---- writing -------------------------------------------------------------------------------------- */

static lt_named_array named(const char *name, lt_elem type, int rank, const int64_t *shape,
                            const void *data)
{
    return (lt_named_array){ name, lt_array_make(type, rank, shape, data) };
}

lt_status hand_file_write(const char *path, const lt_hand_model *m)
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
