/* SPDX-License-Identifier: Apache-2.0 */
/* Opens an HO3D tree and reads its samples, from OpenGL axes and MANO order to ours. */
#include "data/ho3d.h"

#include "data/picture.h"
#include "data/ycb.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/file.h"
#include "libtensor/io/json.h"
#include "libtensor/io/pickle.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { WIDTH = 640, HEIGHT = 480 };

typedef struct {
    dataset base;                   /* first: a dataset * is a ho3d * */
    lt_arena *arena;                /* of everything, this struct included */
    const char *models;
    const char **name;              /* base.count of them, "ABF10/0123" */
    bool evaluation;
    const float *xyz, *vertices;    /* ground truth of the evaluation: our axes, MANO order; or NULL */
} ho3d;

/* "train/ABF10/rgb/0123.png" from the split, the sample and what is asked for. */
static const char *frame_path(const ho3d *h, int64_t index, lt_arena *arena, const char *kind,
                              const char *ending)
{
    const char *name = h->name[index], *slash = strchr(name, '/');

    return lt_arena_printf(arena, "%s/%s/%.*s/%s/%s.%s", h->base.root, h->base.split,
                           (int)(slash - name), name, kind, slash + 1, ending);
}

/* ---- images ---- */

/* The colour image's path: png in version 2, jpg in version 3. */
static lt_status rgb_path(const ho3d *h, int64_t index, lt_arena *arena, const char **out)
{
    const char *png = frame_path(h, index, arena, "rgb", "png");
    const char *jpg = frame_path(h, index, arena, "rgb", "jpg");

    if (!png || !jpg)
        return lt_error(LT_ENOMEM, "%s: no memory", h->name[index]);
    if (access(png, F_OK) && access(jpg, F_OK))
        return lt_error(LT_EIO, "%s: no such file, nor %s", png, strrchr(jpg, '/') + 1);
    *out = access(png, F_OK) ? jpg : png;
    return LT_OK;
}

static lt_status read_rgb(const ho3d *h, int64_t index, lt_arena *arena, dataset_sample *s)
{
    const char *path = NULL;
    lt_image img;
    lt_status st = rgb_path(h, index, arena, &path);

    if (!st)
        st = picture_read_rgb(arena, path, WIDTH, HEIGHT, &img);
    if (st)
        return st;
    s->rgb = img.data;
    s->width = img.width;
    s->height = img.height;
    return LT_OK;
}

static lt_status read_depth(const ho3d *h, int64_t index, lt_arena *arena, dataset_sample *s)
{
    const char *path = frame_path(h, index, arena, "depth", "png");
    float *depth;
    const lt_status st = path ? picture_read_depth(arena, path, WIDTH, HEIGHT, &depth)
                              : lt_error(LT_ENOMEM, "%s: no memory", h->name[index]);

    if (st)
        return st;
    s->depth = depth;
    s->flags |= SAMPLE_DEPTH;
    return LT_OK;
}

/* Not every copy of the data has the masks: without one, the sample has no foreground. */
static lt_status read_foreground(const ho3d *h, int64_t index, lt_arena *arena, dataset_sample *s)
{
    const char *png = frame_path(h, index, arena, "seg", "png"), *jpg = frame_path(h, index, arena, "seg", "jpg");
    lt_image mask;
    lt_status st;

    if (!png || !jpg)
        return lt_error(LT_ENOMEM, "%s: no memory", h->name[index]);
    if (access(png, F_OK) && access(jpg, F_OK))
        return LT_OK;
    st = picture_read_mask(arena, access(png, F_OK) ? jpg : png, WIDTH, HEIGHT, &mask);
    if (st)
        return st;
    s->foreground = mask.data;
    s->foreground_width = mask.width;
    s->foreground_height = mask.height;
    s->flags |= SAMPLE_FOREGROUND;
    return LT_OK;
}

/* ---- the annotation ---- */

/* What angles (radians), shapes (deviations) and places (metres) stay far below, unless the unit is another. */
static const float MOST = 100, MOST_PIXELS = 1e6f;

/* n numbers below `most` under key, or an error line with file and key. */
static lt_status numbers(const lt_pvalue *meta, const char *path, const char *key, float most, float *out, size_t n)
{
    const lt_pvalue *v = lt_pdict_get(meta, key);
    lt_status st;

    if (v && lt_pis_none(v))
        return lt_error(LT_EFORMAT, "%s: %s is None, expected %zu numbers: this frame is not annotated, so "
                        "it should not be listed", path, key, n);
    st = lt_pfloats(v, key, out, n);
    for (size_t i = 0; i < n && !st; i++)
        if (fabsf(out[i]) >= most)
            st = lt_error(LT_EFORMAT, "%s: number %zu is %g, expected less than %g", key, i, (double)out[i],
                          (double)most);
    return st ? lt_error_prefix(st, "%s", path) : LT_OK;
}

static lt_status read_camera(const lt_pvalue *meta, const char *path, lt_camera *cam)
{
    float K[9];
    const lt_status st = numbers(meta, path, "camMat", MOST_PIXELS, K, 9);

    if (st)
        return st;
    if (!(K[0] > 0 && K[4] > 0) || K[1] != 0 || K[3] != 0 || K[6] != 0 || K[7] != 0 ||
        K[8] != 1)
        return lt_error(LT_EFORMAT, "%s: camMat is [%g %g %g; %g %g %g; %g %g %g], expected "
                        "[fx 0 cx; 0 fy cy; 0 0 1]", path, K[0], K[1], K[2], K[3], K[4], K[5], K[6],
                        K[7], K[8]);
    *cam = (lt_camera){ K[0], K[4], K[2], K[5] };
    return LT_OK;
}

/* From OpenGL axes: y and z change their sign. out may be in. */
static void from_gl(const float in[3], float out[3])
{
    out[0] = in[0];
    out[1] = -in[1];
    out[2] = -in[2];
}

static void rotation_from(const float aa[3], bool flip, float out[9])
{
    const double v[3] = { aa[0], aa[1], aa[2] };
    double R[9];

    lt_rot_from_axis_angle(v, R);
    for (int i = 0; i < 9; i++)
        out[i] = (float)(flip && i >= 3 ? -R[i] : R[i]);
}

static lt_status read_pose(const lt_pvalue *meta, const char *path, dataset_sample *s)
{
    float pose[3 * LT_HAND_JOINTS];
    lt_status st = numbers(meta, path, "handPose", MOST, pose, LT_COUNT(pose));

    if (!st)
        st = numbers(meta, path, "handBeta", MOST, s->beta, LT_HAND_BETAS);
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

static lt_status read_train_hand(const lt_pvalue *meta, const char *path, dataset_sample *s)
{
    float mano[LT_HAND_KEYPOINTS][3];
    lt_status st = read_pose(meta, path, s);

    if (!st)
        st = numbers(meta, path, "handJoints3D", MOST, &mano[0][0], LT_COUNT(mano) * 3);
    if (st)
        return st;
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++)
        from_gl(mano[i], mano[i]);
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
static lt_status read_evaluation_hand(const ho3d *h, int64_t index, const lt_pvalue *meta,
                                      const char *path, dataset_sample *s)
{
    float root[3];
    lt_status st = numbers(meta, path, "handJoints3D", MOST, root, 3);

    if (!st)
        st = numbers(meta, path, "handBoundingBox", MOST_PIXELS, s->hand_box, 4);
    if (st)
        return st;
    if (h->xyz)
        set_joints((const float (*)[3])(h->xyz + index * LT_HAND_KEYPOINTS * 3), s);
    if (h->vertices) {
        s->vertices = (const float (*)[3])(h->vertices + index * LT_HAND_VERTICES * 3);
        s->flags |= SAMPLE_VERTICES;
    }
    from_gl(root, s->root);
    s->flags |= SAMPLE_HAND_BOX | SAMPLE_ROOT;
    return h->xyz ? same_wrist(path, index, s->root, s->joints[0]) : LT_OK;
}

static lt_status read_object(const ho3d *h, const lt_pvalue *meta, const char *path, dataset_sample *s)
{
    const char *name = lt_pstr(lt_pdict_get(meta, "objName"));
    float aa[3], t[3];
    lt_status st;

    if (!name)
        return lt_error(LT_EFORMAT, "%s: objName: expected a text, the name of a YCB model", path);
    s->object = dataset_find_object(&h->base, name);
    if (s->object < 0)
        return lt_error(LT_EIO, "%s: objName is %s, which is not in %s", path, name, h->models);
    st = numbers(meta, path, "objRot", MOST, aa, 3);
    if (!st)
        st = numbers(meta, path, "objTrans", MOST, t, 3);
    if (st)
        return st;
    rotation_from(aa, true, s->R);
    from_gl(t, s->t);
    s->flags |= SAMPLE_OBJECT;
    return LT_OK;
}

static lt_status read_meta(const ho3d *h, int64_t index, lt_arena *arena, dataset_sample *s)
{
    const char *path = frame_path(h, index, arena, "meta", "pkl");
    const lt_pvalue *meta;
    lt_status st;

    if (!path)
        return lt_error(LT_ENOMEM, "%s: no memory", h->name[index]);
    st = lt_pickle_read(arena, path, &meta);
    if (st)
        return st;
    if (meta->kind != LT_PDICT)
        return lt_error(LT_EFORMAT, "%s: expected a dictionary of annotations", path);
    st = read_camera(meta, path, &s->camera);
    if (!st)
        st = h->evaluation ? read_evaluation_hand(h, index, meta, path, s)
                           : read_train_hand(meta, path, s);
    if (!st && h->base.n_objects)
        st = read_object(h, meta, path, s);
    return st;
}

static lt_status read_sample(const dataset *d, int64_t index, unsigned want, lt_arena *arena,
                             dataset_sample *out)
{
    const ho3d *h = (const ho3d *)d;
    dataset_sample s = { .name = h->name[index], .object = -1 };
    lt_status st = read_meta(h, index, arena, &s);

    if (!st)
        st = dataset_project(d, &s);
    if (!st)
        st = read_rgb(h, index, arena, &s);
    if (!st && (want & SAMPLE_DEPTH))
        st = read_depth(h, index, arena, &s);
    if (!st && (want & SAMPLE_FOREGROUND))
        st = read_foreground(h, index, arena, &s);
    if (!st && (want & SAMPLE_OBJECT) && s.object >= 0)
        st = dataset_draw_silhouette(d, arena, &s);
    if (!st)
        *out = s;
    return st;
}

static lt_status read_annotation(const dataset *d, int64_t index, lt_arena *arena, dataset_sample *out)
{
    const ho3d *h = (const ho3d *)d;

    *out = (dataset_sample){ .name = h->name[index], .object = -1, .width = WIDTH, .height = HEIGHT };
    return read_meta(h, index, arena, out);
}

static const char *missing_file(const dataset *d, int64_t index, lt_arena *arena)
{
    const ho3d *h = (const ho3d *)d;
    const char *png = frame_path(h, index, arena, "rgb", "png"), *jpg = frame_path(h, index, arena, "rgb", "jpg");
    const char *const other[] = { frame_path(h, index, arena, "depth", "png"),
                                  frame_path(h, index, arena, "meta", "pkl") };

    if (png && jpg && access(png, F_OK) && access(jpg, F_OK))
        return jpg;
    for (int i = 0; i < 2; i++)
        if (other[i] && access(other[i], F_OK))
            return other[i];
    return NULL;
}

static const char *sample_name(const dataset *d, int64_t index)
{
    return ((const ho3d *)d)->name[index];
}

static void free_dataset(dataset *d)
{
    lt_arena_free(((ho3d *)d)->arena);
}

static const dataset_ops ops = { read_sample, read_annotation, missing_file, sample_name, free_dataset };

/* ---- opening ---- */

static bool good_name(const char *name)
{
    const char *slash = strchr(name, '/');

    return slash && slash > name && slash[1] && !strchr(slash + 1, '/') && lt_path_is_inside(name);
}

/* The lines of text into h->name, in place. */
static lt_status split_list(ho3d *h, const char *path, char *text)
{
    char *rest = NULL;
    size_t lines = 1;

    for (const char *p = text; *p; p++)
        lines += *p == '\n';
    h->name = lt_arena_array(h->arena, lines, sizeof(*h->name));
    if (!h->name)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    for (char *line = strtok_r(text, "\r\n", &rest); line; line = strtok_r(NULL, "\r\n", &rest)) {
        if (!good_name(line))
            return lt_error(LT_EFORMAT, "%s: entry %lld is \"%.40s\", expected SEQUENCE/FRAME, such as "
                            "ABF10/0123", path, (long long)h->base.count + 1, line);
        h->name[h->base.count++] = line;
    }
    return h->base.count ? LT_OK : lt_error(LT_EFORMAT, "%s: lists no frame", path);
}

static lt_status read_list(ho3d *h)
{
    const char *path = lt_arena_printf(h->arena, "%s/%s.txt", h->base.root, h->base.split);
    uint8_t *text;
    size_t n;
    lt_status st;

    if (!path)
        return lt_error(LT_ENOMEM, "%s: no memory", h->base.root);
    if (!lt_is_folder(h->base.root))
        return lt_error(LT_EIO, "%s: no such folder; give the HO3D folder that holds train.txt, or make "
                        "a synthetic one with `palmar synth`", h->base.root);
    if (access(path, F_OK))
        return lt_error(LT_EIO, "%s: no such file; the folder of HO3D v2 or v3 holds train.txt and "
                        "evaluation.txt", path);
    st = lt_read_file(h->arena, path, (size_t)64 << 20, &text, &n);
    if (!st && memchr(text, 0, n))
        st = lt_error(LT_EFORMAT, "%s: a byte 0 in the list, expected lines SEQUENCE/FRAME", path);
    return st ? st : split_list(h, path, (char *)text);
}

static lt_status open_models(ho3d *h, const ho3d_options *o)
{
    const char *names[YCB_COUNT];
    int n = 0;

    h->models = o->models ? lt_arena_strdup(h->arena, o->models)
                          : lt_arena_printf(h->arena, "%s/models", h->base.root);
    if (h->models && !o->models && access(h->models, F_OK))
        h->models = lt_arena_printf(h->arena, "%s/../models", h->base.root);
    if (!h->models)
        return lt_error(LT_ENOMEM, "%s: no memory", h->base.root);
    if (!lt_is_folder(h->models))
        return o->models ? lt_error(LT_EIO, "%s: no such folder; name that of the YCB models", h->models)
                         : lt_error(LT_EIO, "%s/models: no such folder, nor %s; put the YCB models there (HO3D's page "
                                    "links them), or name their folder", h->base.root, h->models);
    for (int id = 1; id <= YCB_COUNT; id++)
        names[n++] = ycb_find(id)->name;
    return dataset_load_objects(h->arena, h->models, names, n, &h->base.objects, &h->base.n_objects);
}

/* One of the two files of ground truth into our axes, where it is there. */
static lt_status open_truth(ho3d *h, const char *file, int points, const float **out)
{
    const char *path = lt_arena_printf(h->arena, "%s/%s", h->base.root, file);
    float *xyz;
    lt_status st;

    if (!path)
        return lt_error(LT_ENOMEM, "%s: no memory", h->base.root);
    if (access(path, F_OK))
        return LT_OK;
    st = ho3d_read_truth(h->arena, path, h->base.count, points, &xyz);
    if (st)
        return st;
    for (int64_t i = 0; i < h->base.count * points; i++)
        from_gl(xyz + 3 * i, xyz + 3 * i);
    *out = xyz;
    return LT_OK;
}

/* Our own generator leaves a manifest that says so, and names its sequences as no real one is. */
static lt_status find_whether_synthetic(ho3d *h)
{
    const char *path = lt_arena_printf(h->arena, "%s/manifest.json", h->base.root);
    struct cJSON *manifest = NULL;
    lt_status st = LT_OK;

    h->base.synthetic = h->base.count && strncmp(h->name[0], "SYN", 3) == 0;
    if (path && !access(path, F_OK))
        st = lt_json_read(path, &manifest);
    h->base.synthetic |= cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(manifest, "synthetic"));
    cJSON_Delete(manifest);
    return st;
}

static const char *kind_of(const ho3d *h)
{
    const char *png = frame_path(h, 0, h->arena, "rgb", "png");

    return png && !access(png, F_OK) ? "HO3D v2" : "HO3D v3";
}

static lt_status open_all(ho3d *h, const ho3d_options *o)
{
    lt_status st = read_list(h);

    if (!st && !o->no_objects)
        st = open_models(h, o);
    if (!st && h->evaluation)
        st = open_truth(h, "evaluation_xyz.json", LT_HAND_KEYPOINTS, &h->xyz);
    if (!st && h->evaluation && o->vertices)
        st = open_truth(h, "evaluation_verts.json", LT_HAND_VERTICES, &h->vertices);
    if (st)
        return st;
    h->base.kind = kind_of(h);
    return find_whether_synthetic(h);
}

lt_status ho3d_open(const ho3d_options *o, dataset **out)
{
    lt_arena *arena = lt_arena_new();
    ho3d *h = arena ? lt_arena_alloc(arena, sizeof(*h)) : NULL;
    lt_status st;

    if (strcmp(o->split, "train") && strcmp(o->split, "evaluation")) {
        lt_arena_free(arena);
        return lt_error(LT_EINVAL, "HO3D has no split \"%s\": \"train\" or \"evaluation\"", o->split);
    }
    if (!h || !(h->base.root = lt_arena_strdup(arena, o->root))) {
        lt_arena_free(arena);
        return lt_error(LT_ENOMEM, "%s: no memory", o->root);
    }
    h->arena = arena;
    h->evaluation = !strcmp(o->split, "evaluation");
    h->base.ops = &ops;
    h->base.split = h->evaluation ? "evaluation" : "train";
    h->base.tips = lt_hand_tips_ho3d;
    st = open_all(h, o);
    if (st)
        lt_arena_free(arena);
    else
        *out = &h->base;
    return st;
}
