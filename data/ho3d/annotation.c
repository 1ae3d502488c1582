/* SPDX-License-Identifier: Apache-2.0 */
/* The annotation of a sample of an HO3D tree, from OpenGL axes and MANO order to ours; and where its files are. */
#include "data/ho3d/internal.h"

#include "libtensor/geometry/rotation.h"
#include "libtensor/io/pickle/pickle.h"
#include "vision/picture.h"

#include <math.h>
#include <string.h>

/* "train/ABF10/rgb/0123" from the split, the sample and what is asked for */
static const char *stem_of(const ho3d *h, int64_t index, lt_arena *arena, const char *kind)
{
    const char *name = h->name[index], *slash = strchr(name, '/');

    return lt_arena_printf(arena, "%s/%s/%.*s/%s/%s", h->base.root, h->base.split, (int)(slash - name), name, kind,
                           slash + 1);
}

const char *ho3d_picture(const ho3d *h, int64_t index, lt_arena *arena, const char *kind)
{
    const bool jpg = h->version == 3 && !strcmp(kind, "rgb");
    const char *stem = stem_of(h, index, arena, kind);

    return stem ? picture_path(arena, stem, jpg ? "jpg" : "png") : NULL;
}

const char *ho3d_meta_path(const ho3d *h, int64_t index, lt_arena *arena)
{
    const char *stem = stem_of(h, index, arena, "meta");

    return stem ? lt_arena_printf(arena, "%s.pkl", stem) : NULL;
}

/* ---- the annotation ---- */

/* What angles (radians), shapes (deviations) and places (metres) stay far below, unless the unit is another. */
static const float MOST = 100, MOST_PIXELS = 1e6f;

/* A sample's annotation, and what numbers in it stay below. */
typedef struct { const lt_pvalue *meta; const char *path; float most; } annotation;

/* n numbers below `most` under key, or an error line with file and key. */
static lt_status numbers(const annotation *a, const char *key, float most, float *out, size_t n)
{
    const lt_pvalue *v = lt_pdict_get(a->meta, key);
    lt_status st;

    if (v && lt_pis_none(v))
        return lt_error(LT_EFORMAT, "%s: %s is None, expected %zu numbers: this frame is not annotated, so "
                        "it should not be listed", a->path, key, n);
    st = lt_pfloats(v, key, out, n);
    for (size_t i = 0; i < n && !st; i++)
        if (fabsf(out[i]) >= most)
            st = lt_error(LT_EFORMAT, "%s: number %zu is %g, expected less than %g", key, i, (double)out[i],
                          (double)most);
    return st ? lt_error_prefix(st, "%s", a->path) : LT_OK;
}

/* Intrinsics by columns, as OpenGL and MATLAB have them. */
static bool is_transposed(const float K[9])
{
    return K[0] > 0 && K[4] > 0 && K[1] == 0 && K[2] == 0 && K[3] == 0 && K[5] == 0 && K[8] == 1;
}

static lt_status read_camera(const annotation *a, lt_camera *cam)
{
    float K[9];
    const lt_status st = numbers(a, "camMat", MOST_PIXELS, K, 9);

    if (st)
        return st;
    if (!(K[0] > 0 && K[4] > 0) || K[1] != 0 || K[3] != 0 || K[6] != 0 || K[7] != 0 ||
        K[8] != 1)
        return lt_error(LT_EFORMAT, "%s: camMat is [%g %g %g; %g %g %g; %g %g %g], expected "
                        "[fx 0 cx; 0 fy cy; 0 0 1]%s", a->path, K[0], K[1], K[2], K[3], K[4], K[5], K[6],
                        K[7], K[8], is_transposed(K) ? "; it is transposed" : "");
    *cam = (lt_camera){ K[0], K[4], K[2], K[5] };
    return LT_OK;
}

static void rotation_from(const float aa[3], bool flip, float out[9])
{
    const double v[3] = { aa[0], aa[1], aa[2] };
    double R[9];

    lt_rot_from_axis_angle(v, R);
    for (int i = 0; i < 9; i++)
        out[i] = (float)(flip && i >= 3 ? -R[i] : R[i]);
}

static lt_status read_pose(const annotation *a, dataset_sample *s)
{
    float pose[3 * LT_HAND_JOINTS];
    lt_status st = numbers(a, "handPose", a->most, pose, LT_COUNT(pose));

    if (!st)
        st = numbers(a, "handBeta", a->most, s->beta, LT_HAND_BETAS);
    if (st)
        return st;
    for (int i = 0; i < LT_HAND_JOINTS; i++)
        rotation_from(pose + 3 * i, i == 0, s->rotation[i]);
    s->flags |= SAMPLE_HAND_POSE;
    return LT_OK;
}

/* From MANO's order, in our axes. */
static void set_joints(const float mano[LT_HAND_KEYPOINTS][3], dataset_sample *s)
{
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++)
        memcpy(s->joints[i], mano[lt_mano_to_simple[i]], sizeof(s->joints[i]));
    memcpy(s->root, s->joints[0], sizeof(s->root));
    s->flags |= SAMPLE_JOINTS | SAMPLE_ROOT;
}

static lt_status read_train_hand(const annotation *a, dataset_sample *s)
{
    float mano[LT_HAND_KEYPOINTS][3];
    lt_status st = read_pose(a, s);

    if (!st)
        st = numbers(a, "handJoints3D", a->most, &mano[0][0], LT_COUNT(mano) * 3);
    if (st)
        return st;
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++)
        ho3d_from_gl(mano[i], mano[i]);
    set_joints((const float (*)[3])mano, s);
    return LT_OK;
}

/* The truth's files have no names of frames, only an order. */
static lt_status same_wrist(const char *path, int64_t index, const float root[3], const float truth[3])
{
    static const double APART = 0.01;           /* metres; annotations of the same frame differ by rounding */
    const double d = hypot(hypot((double)root[0] - truth[0], (double)root[1] - truth[1]), (double)root[2] - truth[2]);

    if (d <= APART)
        return LT_OK;
    return lt_error(LT_EFORMAT, "%s: its wrist is %.3g m from that of evaluation_xyz.json at %lld, expected the same "
                    "place; is the truth in the order of evaluation.txt, in metres?", path, d, (long long)index);
}

/* Wrist and box from the annotation; the rest from the ground-truth files where they are. */
static lt_status read_evaluation_hand(const ho3d *h, int64_t index, const annotation *a, dataset_sample *s)
{
    float root[3];
    lt_status st = numbers(a, "handJoints3D", a->most, root, 3);

    if (!st)
        st = numbers(a, "handBoundingBox", MOST_PIXELS, s->hand_box, 4);
    if (st)
        return st;
    if (h->xyz)
        set_joints((const float (*)[3])(h->xyz + index * LT_HAND_KEYPOINTS * 3), s);
    if (h->vertices) {
        s->vertices = (const float (*)[3])(h->vertices + index * LT_HAND_VERTICES * 3);
        s->flags |= SAMPLE_VERTICES;
    }
    ho3d_from_gl(root, s->root);
    s->flags |= SAMPLE_HAND_BOX | SAMPLE_ROOT;
    return h->xyz && !h->base.any_size ? same_wrist(a->path, index, s->root, s->joints[0]) : LT_OK;
}

static lt_status read_object(const ho3d *h, const annotation *a, dataset_sample *s)
{
    const char *name = lt_pstr(lt_pdict_get(a->meta, "objName"));
    float aa[3], t[3];
    lt_status st;

    if (!name)
        return lt_error(LT_EFORMAT, "%s: objName: expected a text, the name of a YCB model", a->path);
    s->object = dataset_find_object(&h->base, name);
    if (s->object < 0)
        return lt_error(LT_EIO, "%s: objName is %s, which is not in %s", a->path, name, h->models);
    st = numbers(a, "objRot", a->most, aa, 3);
    if (!st)
        st = numbers(a, "objTrans", a->most, t, 3);
    if (st)
        return st;
    rotation_from(aa, true, s->R);
    ho3d_from_gl(t, s->t);
    s->flags |= SAMPLE_OBJECT;
    return LT_OK;
}

lt_status ho3d_read_meta(const ho3d *h, int64_t index, lt_arena *arena, dataset_sample *s)
{
    annotation a = { .path = ho3d_meta_path(h, index, arena), .most = h->base.any_size ? INFINITY : MOST };
    lt_status st;

    if (!a.path)
        return lt_error(LT_ENOMEM, "%s: no memory", h->name[index]);
    st = lt_pickle_read(arena, a.path, &a.meta);
    if (st)
        return st;
    if (a.meta->kind != LT_PDICT)
        return lt_error(LT_EFORMAT, "%s: expected a dictionary of annotations", a.path);
    st = read_camera(&a, &s->camera);
    if (!st)
        st = h->evaluation ? read_evaluation_hand(h, index, &a, s) : read_train_hand(&a, s);
    if (!st && h->base.n_objects)
        st = read_object(h, &a, s);
    return st;
}

lt_status ho3d_read_annotation(const dataset *d, int64_t index, lt_arena *arena, dataset_sample *out)
{
    const ho3d *h = (const ho3d *)d;

    *out = (dataset_sample){ .name = h->name[index], .object = -1, .width = h->width, .height = h->height };
    return ho3d_read_meta(h, index, arena, out);
}
