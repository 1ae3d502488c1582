/* SPDX-License-Identifier: Apache-2.0 */
/* One frame of an HO3D tree: images packed, poses turned to OpenGL axes, annotation pickled. */
#include "synth/write/ho3d.h"

#include "libtensor/geometry/rotation.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "libtensor/io/pickle/pickle.h"
#include "vision/picture.h"

#include <math.h>
#include <string.h>

/* Masks are stored at a quarter of the size, those of small pictures whole; quality of version 2's JPEG. */
enum { SEG_STEP = 4, SEG_QUALITY = 95 };

static const char *split_name(bool evaluation)
{
    return evaluation ? "evaluation" : "train";
}

lt_status synth_make_sequence(const char *root, const char *sequence, bool evaluation)
{
    static const char *const kinds[] = { "rgb", "depth", "meta", "seg" };
    lt_arena *arena = lt_arena_new();
    lt_status st = arena ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", sequence);

    for (size_t i = 0; !st && i < LT_COUNT(kinds); i++) {
        const char *path = lt_arena_printf(arena, "%s/%s/%s/%s", root, split_name(evaluation), sequence,
                                           kinds[i]);
        st = path ? lt_make_dirs(path) : lt_error(LT_ENOMEM, "%s: no memory", sequence);
    }
    lt_arena_free(arena);
    return st;
}

/* ---- images ---- */

static lt_status write_rgb(const synth_picture *p, const char *path, bool png, int quality)
{
    const lt_image img = { p->width, p->height, 3, 8, (uint8_t *)p->rgb };

    return png ? lt_png_write(path, &img) : lt_jpeg_write(path, &img, quality);
}

static lt_status write_depth(lt_arena *arena, const synth_picture *p, const char *path)
{
    lt_image img;
    lt_status st = lt_image_init(arena, p->width, p->height, 3, 8, &img);

    if (st)
        return st;
    for (size_t i = 0; i < (size_t)p->width * (size_t)p->height; i++) {
        const long raw = lrint(fmin(p->depth[i] / HO3D_DEPTH_UNIT, 65535));
        img.data[3 * i] = (uint8_t)(raw & 255);
        img.data[3 * i + 1] = (uint8_t)(raw >> 8);
    }
    return lt_png_write_fast(path, &img);
}

/* Version 2 has JPEG, the hand red and the object blue; version 3 PNG, the hand blue and the object green. */
static lt_status write_seg(lt_arena *arena, const synth_picture *p, const char *path, bool version_2)
{
    const int step = p->width == SYNTH_WIDTH ? SEG_STEP : 1, w = p->width / step, h = p->height / step;
    const int hand = version_2 ? 0 : 2, object = version_2 ? 2 : 1;
    lt_image img;
    lt_status st = lt_image_init(arena, w, h, 3, 8, &img);

    if (st)
        return st;
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++) {
            const int middle = (y * step + step / 2) * p->width + x * step + step / 2;
            const uint8_t label = p->label[middle];
            img.data[3 * (y * w + x) + hand] = label == 255 ? 255 : 0;
            img.data[3 * (y * w + x) + object] = label == p->object_id ? 255 : 0;
        }
    return version_2 ? lt_jpeg_write(path, &img, SEG_QUALITY) : lt_png_write_fast(path, &img);
}

/* ---- the annotation ---- */

/* The numbers of a meta file, as floats in its axes. */
typedef struct {
    float K[9], obj_rot[3], obj_trans[3], rest[8][3], corners[8][3];
    float pose[48], trans[3], beta[10], joints[21][3], nearest[LT_HAND_VERTICES][3];
    float hand_box[4];
} meta_numbers;

static void to_gl(const double in[3], float out[3])
{
    out[0] = (float)in[0];
    out[1] = (float)-in[1];
    out[2] = (float)-in[2];
}

static void fill_object(const synth_picture *p, meta_numbers *m)
{
    double R[9], t[3], aa[3], control[LT_BOX_POINTS][3], x[3];

    memcpy(R, p->R, sizeof(R));
    memcpy(t, p->t, sizeof(t));
    lt_flip_yz_pose(R, t);
    lt_rot_to_axis_angle(R, aa);
    lt_box21(&p->box, control);
    for (int k = 0; k < 3; k++) {
        m->obj_rot[k] = (float)aa[k];
        m->obj_trans[k] = (float)t[k];
    }
    for (int i = 0; i < LT_BOX_CORNERS; i++) {
        lt_rigid_apply(R, t, control[i], x);
        for (int k = 0; k < 3; k++) {
            m->rest[i][k] = (float)control[i][k];
            m->corners[i][k] = (float)x[k];
        }
    }
}

static void fill_hand(const synth_picture *p, meta_numbers *m)
{
    double root[3] = { p->pose[0], p->pose[1], p->pose[2] };
    double trans[3] = { p->trans[0], p->trans[1], p->trans[2] };

    lt_flip_yz_mano(root, trans, p->rest_wrist);
    for (int i = 0; i < 48; i++)
        m->pose[i] = (float)(i < 3 ? root[i] : p->pose[i]);
    for (int i = 0; i < 3; i++)
        m->trans[i] = (float)trans[i];
    for (int i = 0; i < LT_HAND_BETAS; i++)
        m->beta[i] = (float)p->beta[i];
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++)
        to_gl(p->joints[i], m->joints[i]);
    for (int i = 0; i < LT_HAND_VERTICES; i++) {
        const double x[3] = { p->contact.nearest[i][0], p->contact.nearest[i][1], p->contact.nearest[i][2] };
        to_gl(x, m->nearest[i]);
    }
}

/* The extent of the hand's joints, cut to the image. */
static void fill_hand_box(const synth_picture *p, float box[4])
{
    double lo[2] = { INFINITY, INFINITY }, hi[2] = { -INFINITY, -INFINITY };
    const double size[2] = { p->width - 1, p->height - 1 };

    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        double uv[2];
        lt_camera_project(&p->camera, p->joints[i], uv);
        for (int k = 0; k < 2; k++) {
            lo[k] = fmin(lo[k], uv[k]);
            hi[k] = fmax(hi[k], uv[k]);
        }
    }
    for (int k = 0; k < 2; k++) {
        box[k] = (float)fmax(0, fmin(size[k], lo[k]));
        box[2 + k] = (float)fmax(0, fmin(size[k], hi[k]));
    }
}

static void fill_numbers(const synth_picture *p, meta_numbers *m)
{
    const double K[9] = { p->camera.fx, 0, p->camera.cx, 0, p->camera.fy, p->camera.cy, 0, 0, 1 };

    for (int i = 0; i < 9; i++)
        m->K[i] = (float)K[i];
    fill_object(p, m);
    fill_hand(p, m);
    fill_hand_box(p, m->hand_box);
}

static lt_pwrite text_item(const char *key, const char *text)
{
    return (lt_pwrite){ .key = key, .kind = LT_PW_STR, .text = text };
}

/* A (rows, columns) array; columns 0: (rows). */
static lt_pwrite array_item(const char *key, lt_elem type, int rows, int columns, const void *data)
{
    const int64_t shape[2] = { rows, columns };

    return (lt_pwrite){ .key = key, .kind = LT_PW_ARRAY,
                        .array = lt_array_make(type, columns ? 2 : 1, shape, data) };
}

enum { MAX_CAMERAS = 8, COMMON_KEYS = 8, TRAIN_KEYS = 8, EVALUATION_KEYS = 2 };

/* The keys that both splits have. cameras: room for the camera list. */
static void common_items(const synth_picture *p, const meta_numbers *m, lt_pwrite *cameras, lt_pwrite *out)
{
    static const char *const number[MAX_CAMERAS] = { "0", "1", "2", "3", "4", "5", "6", "7" };
    int n = 0;

    for (int i = 0; i < p->n_cameras; i++)
        cameras[i] = text_item(NULL, number[i]);
    out[n++] = array_item("camMat", LT_ELEM_F4, 3, 3, m->K);
    out[n++] = text_item("objName", p->object);
    out[n++] = (lt_pwrite){ .key = "objLabel", .kind = LT_PW_INT, .integer = p->object_id };
    out[n++] = array_item("objRot", LT_ELEM_F4, 3, 1, m->obj_rot);
    out[n++] = array_item("objTrans", LT_ELEM_F4, 3, 0, m->obj_trans);
    out[n++] = array_item("objCorners3DRest", LT_ELEM_F4, 8, 3, m->rest);
    out[n++] = array_item("objCorners3D", LT_ELEM_F4, 8, 3, m->corners);
    out[n++] = (lt_pwrite){ .key = "camIDList", .kind = LT_PW_LIST, .item = cameras,
                            .n_items = (size_t)p->n_cameras };
}

static void train_items(const synth_picture *p, const meta_numbers *m, lt_pwrite *out)
{
    const int n = LT_HAND_VERTICES;
    int i = 0;

    out[i++] = array_item("handPose", LT_ELEM_F4, 48, 0, m->pose);
    out[i++] = array_item("handTrans", LT_ELEM_F4, 3, 0, m->trans);
    out[i++] = array_item("handBeta", LT_ELEM_F4, 10, 0, m->beta);
    out[i++] = array_item("handJoints3D", LT_ELEM_F4, 21, 3, m->joints);
    out[i++] = array_item("handVertContact", LT_ELEM_BOOL, n, 0, p->contact.contact);
    out[i++] = array_item("handVertDist", LT_ELEM_F4, n, 0, p->contact.distance);
    out[i++] = array_item("handVertIntersec", LT_ELEM_BOOL, n, 0, p->contact.inside);
    out[i++] = array_item("handVertObjSurfProj", LT_ELEM_F4, n, 3, m->nearest);
}

static lt_status write_meta(lt_arena *arena, const synth_picture *p, const char *path)
{
    meta_numbers *m = lt_arena_alloc(arena, sizeof(*m));
    lt_pwrite item[COMMON_KEYS + TRAIN_KEYS], cameras[MAX_CAMERAS], corner[4];

    if (!m)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    fill_numbers(p, m);
    common_items(p, m, cameras, item);
    if (!p->evaluation) {
        train_items(p, m, item + COMMON_KEYS);
        return lt_pickle_write_dict(path, item, COMMON_KEYS + TRAIN_KEYS);
    }
    for (int i = 0; i < 4; i++)
        corner[i] = (lt_pwrite){ .kind = LT_PW_FLOAT, .number = m->hand_box[i] };
    item[COMMON_KEYS] = array_item("handJoints3D", LT_ELEM_F4, 3, 0, m->joints[0]);
    item[COMMON_KEYS + 1] = (lt_pwrite){ .key = "handBoundingBox", .kind = LT_PW_LIST, .item = corner,
                                         .n_items = 4 };
    return lt_pickle_write_dict(path, item, COMMON_KEYS + EVALUATION_KEYS);
}

/* ---- a frame ---- */

static lt_status write_file(lt_arena *arena, const char *root, const synth_picture *p, int kind, bool png,
                            int quality, synth_file *out)
{
    static const char *const folder[SYNTH_FRAME_FILES] = { "rgb", "depth", "seg", "meta" };
    const char *const ending[SYNTH_FRAME_FILES] = { png ? "png" : "jpg", "png", png ? "jpg" : "png", "pkl" };
    const char *path = lt_arena_printf(arena, "%s/%s/%s/%04d.%s", split_name(p->evaluation), p->sequence,
                                       folder[kind], p->frame, ending[kind]);
    const char *full = path ? lt_path_join(arena, root, path) : NULL;
    lt_status st;

    if (!full)
        return lt_error(LT_ENOMEM, "%s: no memory", p->sequence);
    switch (kind) {
    case 0: st = write_rgb(p, full, png, quality); break;
    case 1: st = write_depth(arena, p, full); break;
    case 2: st = write_seg(arena, p, full, png); break;
    default: st = write_meta(arena, p, full); break;
    }
    return st ? st : synth_describe_file(root, path, out);
}

lt_status synth_write_picture(const char *root, const synth_picture *p, bool png, int quality,
                              synth_file *files)
{
    lt_arena *arena = lt_arena_new();
    lt_status st = arena ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", p->sequence);

    for (int kind = 0; !st && kind < SYNTH_FRAME_FILES; kind++)
        st = write_file(arena, root, p, kind, png, quality, &files[kind]);
    lt_arena_free(arena);
    return st;
}
