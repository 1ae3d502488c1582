/* SPDX-License-Identifier: Apache-2.0 */
/* A frame's labels_*.npz: what is annotated of hand and object, in the camera's axes. */
#include "data/dexycb/internal.h"

#include "libtensor/geometry/rotation.h"
#include "libtensor/io/array/npz.h"

#include <math.h>
#include <string.h>

enum { HAND = 255 };                /* in seg; objects have their YCB ids, all else is 0 */

/* What coefficients and places (metres) stay far below, unless the unit is another. */
static const float MOST = 100, MOST_PIXELS = 1e6f;

/* n numbers below `most` of an array of that shape; a NaN is an error too. */
static lt_status numbers(const lt_npz *npz, const char *key, int rank, const int64_t *shape, float most, float *out,
                         size_t n)
{
    const lt_array *a;
    char found[64], wanted[64];
    lt_status st = lt_npz_get(npz, key, &a);

    if (st)
        return st;
    if (a->type == LT_ELEM_TEXT || !lt_array_has_shape(a, rank, shape)) {
        const lt_array want = lt_array_make(LT_ELEM_F4, rank, shape, NULL);
        return lt_error(LT_EFORMAT, "%s: %s is %s, expected numbers of shape %s", npz->path, key,
                        lt_array_shape_text(a, found, sizeof(found)),
                        lt_array_shape_text(&want, wanted, sizeof(wanted)));
    }
    lt_array_to_float(a, out, n);
    for (size_t i = 0; i < n; i++)
        if (!(fabsf(out[i]) < most))
            return lt_error(LT_EFORMAT, "%s: %s: number %zu is %g, expected less than %g", npz->path, key, i,
                            (double)out[i], (double)most);
    return LT_OK;
}

static bool all(const float *x, int n, float value)
{
    for (int i = 0; i < n; i++)
        if (x[i] != value)
            return false;
    return true;
}

static lt_status read_hand(const lt_npz *npz, float most, dexycb_label *out)
{
    static const int64_t pose[2] = { 1, 51 }, joints[3] = { 1, LT_HAND_KEYPOINTS, 3 },
                         joints2d[3] = { 1, LT_HAND_KEYPOINTS, 2 };
    lt_status st = numbers(npz, "pose_m", 2, pose, most, out->pose, 51);

    if (!st)
        st = numbers(npz, "joint_3d", 3, joints, most, out->joints[0], LT_HAND_KEYPOINTS * 3);
    if (!st)
        st = numbers(npz, "joint_2d", 3, joints2d, MOST_PIXELS, out->joints2d[0], LT_HAND_KEYPOINTS * 2);
    if (!st)
        out->hand = !all(out->joints[0], LT_HAND_KEYPOINTS * 3, -1) && !all(out->pose, 51, 0);
    return st;
}

static lt_status read_objects(const lt_npz *npz, const dexycb_sequence *q, float most,
                              float out[DEXYCB_MAX_OBJECTS][12])
{
    const int64_t shape[3] = { q->n_objects, 3, 4 };

    return numbers(npz, "pose_y", 3, shape, most, out[0], (size_t)q->n_objects * 12);
}

/* [R|t] of an object; R is a rotation but for what float and a labeller's rounding leave of it. */
static lt_status pose_of(const lt_npz *npz, int object, const float Rt[12], dexycb_pose *out)
{
    double R[9];

    out->known = !all(Rt, 12, 0);
    for (int i = 0; i < 9; i++)
        R[i] = out->R[i] = Rt[4 * (i / 3) + i % 3];
    for (int i = 0; i < 3; i++)
        out->t[i] = Rt[4 * i + 3];
    if (out->known && !lt_rot_is_near(R, 1e-2))
        return lt_error(LT_EFORMAT, "%s: pose_y: object %d: expected a rotation matrix beside the translation",
                        npz->path, object);
    return LT_OK;
}

const char *dexycb_label_path(const dexycb *d, dexycb_spot spot, lt_arena *arena)
{
    return lt_arena_printf(arena, "%s/%s/%s/labels_%06d.npz", d->base.root, spot.sequence->folder,
                           d->serial[spot.camera], spot.frame);
}

static lt_status open_label(lt_arena *arena, const dexycb *d, dexycb_spot spot, const char *const *key, size_t n,
                            lt_npz *out)
{
    const char *path = arena ? dexycb_label_path(d, spot, arena) : NULL;

    return path ? lt_npz_read_only(arena, path, key, n, out)
                : lt_error(LT_ENOMEM, "%s: no memory", spot.sequence->folder);
}

lt_status dexycb_read_label(const dexycb *d, dexycb_spot spot, dexycb_label *out)
{
    static const char *const key[] = { "pose_m", "joint_3d", "joint_2d", "pose_y" };
    const int grasped = spot.sequence->grasped;
    const float most = d->base.any_size ? INFINITY : MOST;
    float object[DEXYCB_MAX_OBJECTS][12];
    lt_arena *arena = lt_arena_new();
    lt_npz npz;
    lt_status st = open_label(arena, d, spot, key, LT_COUNT(key), &npz);

    *out = (dexycb_label){ 0 };
    if (!st)
        st = read_hand(&npz, most, out);
    if (!st)
        st = read_objects(&npz, spot.sequence, most, object);
    if (!st)
        st = pose_of(&npz, grasped, object[grasped], &out->object);
    lt_arena_free(arena);
    return st;
}

lt_status dexycb_read_poses(const dexycb *d, dexycb_spot spot, dexycb_pose out[DEXYCB_MAX_OBJECTS])
{
    static const char *const key[] = { "pose_y" };
    float object[DEXYCB_MAX_OBJECTS][12];
    lt_arena *arena = lt_arena_new();
    lt_npz npz;
    lt_status st = open_label(arena, d, spot, key, LT_COUNT(key), &npz);

    if (!st)
        st = read_objects(&npz, spot.sequence, MOST, object);
    for (int i = 0; !st && i < spot.sequence->n_objects; i++)
        st = pose_of(&npz, i, object[i], &out[i]);
    lt_arena_free(arena);
    return st;
}

lt_status dexycb_read_segments(const dexycb *d, dexycb_spot spot, lt_arena *arena, uint8_t **out)
{
    static const char *const key[] = { "seg" };
    static const int64_t shape[2] = { DEXYCB_HEIGHT, DEXYCB_WIDTH };
    const size_t n = (size_t)DEXYCB_HEIGHT * DEXYCB_WIDTH;
    const uint8_t object = (uint8_t)spot.sequence->object[spot.sequence->grasped], *seg;
    const lt_array *a;
    char found[64];
    uint8_t *label;
    lt_npz npz;
    lt_status st = open_label(arena, d, spot, key, LT_COUNT(key), &npz);

    if (!st)
        st = lt_npz_get(&npz, "seg", &a);
    if (!st && (a->type != LT_ELEM_U1 || !lt_array_has_shape(a, 2, shape)))
        st = lt_error(LT_EFORMAT, "%s: seg is %s, expected bytes of shape (%d, %d)", npz.path,
                      lt_array_shape_text(a, found, sizeof(found)), DEXYCB_HEIGHT, DEXYCB_WIDTH);
    if (!st)
        st = lt_arena_try(arena, n, (void **)&label);
    if (st)
        return st;
    seg = a->data;
    for (size_t i = 0; i < n; i++)
        label[i] = seg[i] == HAND ? SEGMENT_HAND : seg[i] == object ? SEGMENT_OBJECT : 0;
    *out = label;
    return LT_OK;
}

/* ---- to a sample ---- */

static void rotation_of(const float aa[3], float out[9])
{
    const double v[3] = { aa[0], aa[1], aa[2] };
    double R[9];

    lt_rot_from_axis_angle(v, R);
    for (int i = 0; i < 9; i++)
        out[i] = (float)R[i];
}

void dexycb_fill_hand(const dexycb *d, dexycb_spot spot, const dexycb_label *label, dataset_sample *s)
{
    const dexycb_pose_space *space = &d->hand[spot.sequence->left];
    float pose[LT_HAND_PCA];

    for (int i = 0; i < LT_HAND_PCA; i++) {
        double x = space->mean[i];
        for (int k = 0; k < LT_HAND_PCA; k++)
            x += (double)label->pose[3 + k] * space->component[k][i];
        pose[i] = (float)x;
    }
    rotation_of(label->pose, s->rotation[0]);
    for (int j = 1; j < LT_HAND_JOINTS; j++)
        rotation_of(pose + 3 * (j - 1), s->rotation[j]);
    memcpy(s->beta, spot.sequence->beta, sizeof(s->beta));
    memcpy(s->joints, label->joints, sizeof(s->joints));
    memcpy(s->root, label->joints[0], sizeof(s->root));
    s->flags |= SAMPLE_HAND_POSE | SAMPLE_JOINTS | SAMPLE_ROOT;
}
