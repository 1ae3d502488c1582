/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/scorers/models_info.h"

#include "assets/ycb/symmetry.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>

#define MM 1e-3

/* Motions of a model, the first of them none. */
typedef struct { lt_pose *motion; int n; } motions;

/* The object that is being read. */
typedef struct { lt_arena *arena; const char *path; const ycb_object *ycb; } reader;

static lt_status fail(const reader *r, const char *what)
{
    return lt_error(LT_EFORMAT, "%s: object %d: %s", r->path, r->ycb->id, what);
}

static bool is_number(const cJSON *v)
{
    return cJSON_IsNumber(v) && fabs(v->valuedouble) < 1e6;
}

static bool numbers(const cJSON *list, int n, double *out)
{
    const cJSON *v;

    if (!cJSON_IsArray(list) || cJSON_GetArraySize(list) != n)
        return false;
    cJSON_ArrayForEach(v, list) {
        if (!is_number(v))
            return false;
        *out++ = v->valuedouble;
    }
    return true;
}

/* A list of the object's that may be missing: its length, or -1 for what is none. */
static int length_of(const cJSON *list)
{
    return !list ? 0 : cJSON_IsArray(list) ? cJSON_GetArraySize(list) : -1;
}

static lt_status make_room(const reader *r, int64_t n, motions *out)
{
    if (n > BOP_SYMMETRIES)
        return fail(r, "has too many symmetries");
    out->n = 1;
    out->motion = lt_arena_array(r->arena, (size_t)n, sizeof(*out->motion));
    if (!out->motion)
        return lt_error(LT_ENOMEM, "%s: no memory", r->path);
    out->motion[0] = (lt_pose){ { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, { 0 } };
    return LT_OK;
}

/* x -> R x + t of BOP's frame, p_bop = p - centre, is x -> R (x - centre) + t + centre of ours. */
static bool add_discrete(const reader *r, const double M[16], motions *out)
{
    lt_pose *s = &out->motion[out->n++];
    double moved[3];

    for (int i = 0; i < 9; i++)
        s->R[i] = M[4 * (i / 3) + i % 3];
    lt_mat3_mulvec(s->R, r->ycb->centre, moved);
    for (int i = 0; i < 3; i++)
        s->t[i] = M[4 * i + 3] * MM + r->ycb->centre[i] - moved[i];
    return lt_rot_is_near(s->R, 1e-2) && M[12] == 0 && M[13] == 0 && M[14] == 0 && M[15] == 1;
}

static lt_status read_discrete(const reader *r, const cJSON *list, motions *out)
{
    const int n = length_of(list);
    const cJSON *v;
    lt_status st;

    if (n < 0)
        return fail(r, "symmetries_discrete: expected a list");
    st = make_room(r, 1 + (int64_t)n, out);
    cJSON_ArrayForEach(v, list) {
        double M[16];
        if (st)
            break;
        if (!numbers(v, 16, M) || !add_discrete(r, M, out))
            st = fail(r, "symmetries_discrete: expected rigid motions, 16 numbers each");
    }
    return st;
}

/* All but the first step, which is none */
static bool add_turns(const reader *r, const double axis[3], const double offset[3], motions *out)
{
    const double length = lt_vec3_norm(axis);
    double unit[3], point[3];

    for (int i = 0; i < 3; i++) {
        unit[i] = axis[i] / length;
        point[i] = offset[i] * MM + r->ycb->centre[i];
    }
    for (int i = 1; i < YCB_TURNS; i++)
        out->motion[out->n++] = lt_pose_turn(point, unit, 2 * M_PI * i / YCB_TURNS);
    return length > 1e-6;
}

static lt_status read_continuous(const reader *r, const cJSON *list, motions *out)
{
    const int n = length_of(list);
    const cJSON *v;
    lt_status st;

    if (n < 0)
        return fail(r, "symmetries_continuous: expected a list");
    st = make_room(r, 1 + (int64_t)n * (YCB_TURNS - 1), out);
    cJSON_ArrayForEach(v, list) {
        double axis[3], offset[3];
        if (st)
            break;
        if (!numbers(cJSON_GetObjectItemCaseSensitive(v, "axis"), 3, axis)
            || !numbers(cJSON_GetObjectItemCaseSensitive(v, "offset"), 3, offset)
            || !add_turns(r, axis, offset, out))
            st = fail(r, "symmetries_continuous: expected an axis and an offset, 3 numbers each");
    }
    return st;
}

/* Each turn after each discrete symmetry */
static lt_status combine(const reader *r, const motions *discrete, const motions *turns, bop_model *out)
{
    motions all;
    const lt_status st = make_room(r, (int64_t)discrete->n * turns->n, &all);

    if (st)
        return st;
    all.n = 0;
    for (int i = 0; i < discrete->n; i++)
        for (int k = 0; k < turns->n; k++)
            all.motion[all.n++] = lt_pose_compose(&turns->motion[k], &discrete->motion[i]);
    out->n_symmetries = all.n - 1;
    out->symmetry = all.motion + 1;
    return LT_OK;
}

static lt_status read_model(const reader *r, const cJSON *v, bop_model *out)
{
    const cJSON *diameter = cJSON_GetObjectItemCaseSensitive(v, "diameter");
    motions discrete, turns;
    lt_status st;

    if (!is_number(diameter) || !(diameter->valuedouble > 0))
        return fail(r, "diameter: expected a number of millimetres above 0");
    out->diameter = diameter->valuedouble * MM;
    st = read_discrete(r, cJSON_GetObjectItemCaseSensitive(v, "symmetries_discrete"), &discrete);
    if (!st)
        st = read_continuous(r, cJSON_GetObjectItemCaseSensitive(v, "symmetries_continuous"), &turns);
    return st ? st : combine(r, &discrete, &turns, out);
}

lt_status models_info_read(lt_arena *arena, const char *path, bop_model out[YCB_COUNT + 1])
{
    struct cJSON *root;
    lt_status st = lt_json_read(path, &root);

    if (st)
        return st;
    if (!cJSON_IsObject(root))
        st = lt_error(LT_EFORMAT, "%s: expected an object with a model for each id", path);
    for (int id = 1; !st && id <= YCB_COUNT; id++) {
        const reader r = { arena, path, ycb_find(id) };
        const cJSON *v;
        char key[8];
        snprintf(key, sizeof(key), "%d", id);
        v = cJSON_GetObjectItemCaseSensitive(root, key);
        out[id] = (bop_model){ 0 };
        if (v)
            st = read_model(&r, v, &out[id]);
    }
    cJSON_Delete(root);
    return st;
}
