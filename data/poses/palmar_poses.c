/* SPDX-License-Identifier: Apache-2.0 */
/* palmar.poses/1: a header of conventions, and a pose of hand and object for each frame's name (docs/formats.md). */
#include "data/poses/pose_file.h"

#include "libtensor/geometry/rotation.h"
#include "libtensor/io/text/json.h"
#include "libtensor/io/text/json_object.h"
#include "libtensor/io/text/nearest.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

typedef enum { AXIS_ANGLE, MATRIX, QUATERNION_XYZW, QUATERNION_WXYZ } rotation_form;

typedef struct {
    int opengl, millimetres, rotation, pca;
    bool flat_hand_mean;
} header;

/* ---- the header ---- */

static const char *const axes[] = { "opencv", "opengl" }, *const units[] = { "m", "mm" };
static const char *const rotations[] = { "axis-angle", "matrix", "quaternion-xyzw", "quaternion-wxyz" };
static const char *const hand_poses[] = { "axis-angle", "pca45" };
static const char *const keys[] = { "format", "frames", "axes", "unit", "rotation", "hand_pose", "flat_hand_mean" };

static lt_status choose(const pose_reader *r, const char *key, const cJSON *value, const char *const *names, size_t n,
                        int *out)
{
    char there[128];
    size_t at = 0;

    for (size_t i = 0; i < n; i++)
        if (cJSON_IsString(value) && strcmp(value->valuestring, names[i]) == 0) {
            *out = (int)i;
            return LT_OK;
        }
    for (size_t i = 0; i < n; i++)
        at += (size_t)snprintf(there + at, sizeof(there) - at, "%s\"%s\"", i ? ", " : "", names[i]);
    return lt_error(LT_EFORMAT, "%s: %s: want one of %s", r->file.path, key, there);
}

static lt_status take_key(const pose_reader *r, const char *key, const cJSON *value, header *h)
{
    if (strcmp(key, "axes") == 0)
        return choose(r, key, value, axes, LT_COUNT(axes), &h->opengl);
    if (strcmp(key, "unit") == 0)
        return choose(r, key, value, units, LT_COUNT(units), &h->millimetres);
    if (strcmp(key, "rotation") == 0)
        return choose(r, key, value, rotations, LT_COUNT(rotations), &h->rotation);
    if (strcmp(key, "hand_pose") == 0)
        return choose(r, key, value, hand_poses, LT_COUNT(hand_poses), &h->pca);
    if (strcmp(key, "format") == 0)
        return LT_OK;
    if (strcmp(key, "flat_hand_mean") != 0)
        return lt_unknown_name(key, keys, LT_COUNT(keys), "there are: format, axes, unit, rotation, hand_pose, "
                               "flat_hand_mean, frames", "%s: no such key \"%s\"", r->file.path, key);
    if (!cJSON_IsBool(value))
        return lt_error(LT_EFORMAT, "%s: flat_hand_mean: want true or false", r->file.path);
    h->flat_hand_mean = cJSON_IsTrue(value);
    return LT_OK;
}

/* All keys but the frames, which may stand anywhere. */
static lt_status read_header(pose_reader *r, header *h, lt_json_member *frames)
{
    lt_json_object o;
    lt_json_member m;
    bool more = false;
    lt_status st = lt_json_object_open(r->file.path, r->file.text, r->file.n, &o);

    while (!st && !(st = lt_json_object_next(&o, r->scratch, &m, &more)) && more) {
        cJSON *value = NULL;

        if (strcmp(m.key, "frames") == 0) {
            *frames = m;
            continue;
        }
        st = lt_json_parse(r->file.path, m.value, m.n, &value);
        if (!st)
            st = take_key(r, m.key, value, h);
        cJSON_Delete(value);
    }
    if (!st && !frames->value)
        st = lt_error(LT_EFORMAT, "%s: no key \"frames\"", r->file.path);
    return st;
}

/* ---- a frame ---- */

static lt_status read_rotation(const pose_reader *r, const cJSON *value, int form, double R[9])
{
    static const int count[] = { 3, 9, 4, 4 };
    double x[9], norm = 0, q[4];
    lt_status st = pose_numbers(r, value, "object.R", count[form], x);

    if (st)
        return st;
    if (form == AXIS_ANGLE) {
        lt_rot_from_axis_angle(x, R);
        return LT_OK;
    }
    if (form == MATRIX) {
        memcpy(R, x, sizeof(x));
        return pose_rotation(r, "object.R", R);
    }
    for (int i = 0; i < 4; i++) {
        q[i] = form == QUATERNION_WXYZ ? x[i] : x[(i + 3) % 4];
        norm += q[i] * q[i];
    }
    if (fabs(sqrt(norm) - 1) > 1e-2)
        return lt_error(LT_EFORMAT, "%s: object.R, a quaternion, has the length %.4g, want 1", r->name, sqrt(norm));
    lt_rot_from_quat(q, R);
    return LT_OK;
}

static lt_status read_hand(const pose_reader *r, const header *h, const cJSON *hand, pose_record *out)
{
    const cJSON *side = cJSON_GetObjectItemCaseSensitive(hand, "side");
    lt_status st;

    if (side && (!cJSON_IsString(side) || strcmp(side->valuestring, "right") != 0))
        return lt_error(LT_EFORMAT, "%s: hand.side is not \"right\": initial poses are of right hands alone", r->name);
    st = pose_numbers(r, cJSON_GetObjectItemCaseSensitive(hand, "pose"), "hand.pose", 48, out->pose);
    if (!st)
        st = pose_numbers(r, cJSON_GetObjectItemCaseSensitive(hand, "shape"), "hand.shape", 10, out->beta);
    if (!st)
        st = pose_numbers(r, cJSON_GetObjectItemCaseSensitive(hand, "trans"), "hand.trans", 3, out->trans);
    for (int k = 0; k < 3 && !st; k++)
        out->trans[k] *= h->millimetres ? 0.001 : 1;
    out->has_hand = true;
    out->placed = POSE_BY_TRANS;
    out->pca = h->pca;
    out->add_mean = !h->flat_hand_mean;
    return st;
}

static lt_status read_object(const pose_reader *r, const header *h, const cJSON *object, pose_record *out)
{
    const cJSON *id = cJSON_GetObjectItemCaseSensitive(object, "id");
    lt_status st;

    if (id && (!cJSON_IsNumber(id) || id->valuedouble != id->valueint || id->valueint < 0))
        return lt_error(LT_EFORMAT, "%s: object.id: want a whole number, YCB's from 1 to 21", r->name);
    st = read_rotation(r, cJSON_GetObjectItemCaseSensitive(object, "R"), h->rotation, out->R);
    if (!st)
        st = pose_numbers(r, cJSON_GetObjectItemCaseSensitive(object, "t"), "object.t", 3, out->t);
    for (int k = 0; k < 3 && !st; k++)
        out->t[k] *= h->millimetres ? 0.001 : 1;
    out->has_object = true;
    out->object_id = id ? id->valueint : 0;
    return st;
}

static lt_status read_frame(pose_reader *r, const header *h, const lt_json_member *m)
{
    pose_record out = { .frame = m->key, .opengl = h->opengl };
    const cJSON *hand, *object;
    cJSON *frame = NULL;
    lt_status st;

    pose_reader_at(r, m->key);
    st = lt_json_parse(r->name, m->value, m->n, &frame);
    hand = cJSON_GetObjectItemCaseSensitive(frame, "hand");
    object = cJSON_GetObjectItemCaseSensitive(frame, "object");
    if (!st && !cJSON_IsObject(frame))
        st = lt_error(LT_EFORMAT, "%s: want an object of hand and object", r->name);
    if (!st && cJSON_IsObject(hand))
        st = read_hand(r, h, hand, &out);
    if (!st && cJSON_IsObject(object))
        st = read_object(r, h, object, &out);
    if (!st)
        st = r->take(r->ctx, &out);
    cJSON_Delete(frame);
    return st;
}

lt_status pose_read_palmar(pose_reader *r)
{
    header h = { .flat_hand_mean = true };
    lt_json_member frames = { NULL }, m;
    lt_json_object o;
    bool more = false;
    lt_status st = read_header(r, &h, &frames);

    if (!st)
        st = lt_json_object_open(r->file.path, frames.value, frames.n, &o);
    while (!st && !(st = lt_json_object_next(&o, r->scratch, &m, &more)) && more) {
        st = read_frame(r, &h, &m);
        lt_arena_reset(r->scratch);
    }
    return st;
}
