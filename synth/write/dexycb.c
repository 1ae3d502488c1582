/* SPDX-License-Identifier: Apache-2.0 */
/* A DexYCB tree, file by file: pictures, labels, what is said of a sequence, calibration. */
#include "synth/write/dexycb.h"

#include "data/mirror.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/array/npz.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "libtensor/io/text/number.h"
#include "synth/write/calibration.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { W = SYNTH_WIDTH, H = SYNTH_HEIGHT, O = SYNTH_DEXYCB_OBJECTS };

const char *const synth_dexycb_serial[SYNTH_DEXYCB_CAMERAS] = {
    "836212060125", "839512060362", "840412060917", "841412060263",
    "932122060857", "932122060861", "932122061900", "932122062010",
};

/* ---- the mirror ---- */

void synth_dexycb_mirror(synth_picture *p, uint8_t *rgb, float *depth, uint8_t *label)
{
    mirror_plane(rgb, W, H, 3);
    mirror_plane(depth, W, H, sizeof(*depth));
    mirror_plane(label, W, H, 1);
    mirror_camera(&p->camera, W);
    for (int j = 0; j < LT_HAND_JOINTS; j++)
        lt_mirror_axis_angle(p->pose + 3 * j);
    p->trans[0] = -p->trans[0];
    p->rest_wrist[0] = -p->rest_wrist[0];
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++)
        p->joints[i][0] = -p->joints[i][0];
    for (int i = 0; i < LT_HAND_VERTICES; i++) {
        p->vertices[i][0] = -p->vertices[i][0];
        p->contact.nearest[i][0] = -p->contact.nearest[i][0];
    }
    mirror_pose(p->R, p->t);
}

/* ---- a frame ---- */

typedef struct {
    float pose_m[51], pose_y[O][12], joints[LT_HAND_KEYPOINTS][3], joints2d[LT_HAND_KEYPOINTS][2];
} numbers;

void synth_dexycb_pose(const synth_dexycb_frame *f, float pose[51])
{
    const synth_picture *p = f->picture;
    double delta[LT_HAND_PCA];

    /* a left hand's components are the mirrored right ones, so its coefficients are the mirrored pose's */
    for (int i = 0; i < LT_HAND_PCA; i++)
        delta[i] = (f->sequence->left && i % 3 ? -p->pose[3 + i] : p->pose[3 + i]) - f->hand->hands_mean[i];
    for (int k = 0; k < LT_HAND_PCA; k++) {
        double c = 0;
        for (int i = 0; i < LT_HAND_PCA; i++)
            c += delta[i] * f->hand->hands_components[k][i];
        pose[3 + k] = (float)c;
    }
    for (int i = 0; i < 3; i++) {
        pose[i] = (float)p->pose[i];
        pose[48 + i] = (float)p->trans[i];
    }
}

/* The 16 joints and manopth's tips, whose middle finger is another vertex on the left. */
static void fill_joints(const synth_dexycb_frame *f, numbers *n)
{
    const synth_picture *p = f->picture;

    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        const int mano = lt_mano_to_simple[i];
        const double *x = p->joints[mano];
        double uv[2];
        if (mano >= LT_HAND_JOINTS) {
            const int finger = i / 4 - 1;
            x = p->vertices[lt_hand_tips_dexycb[finger] + (f->sequence->left && finger == 2)];
        }
        lt_camera_project(&p->camera, x, uv);
        for (int k = 0; k < 3; k++)
            n->joints[i][k] = (float)x[k];
        n->joints2d[i][0] = (float)uv[0];
        n->joints2d[i][1] = (float)uv[1];
    }
}

static void fill(const synth_dexycb_frame *f, numbers *n)
{
    synth_dexycb_pose(f, n->pose_m);
    fill_joints(f, n);
    for (int o = 0; o < f->sequence->n_objects; o++)
        for (int i = 0; i < 12; i++)
            n->pose_y[o][i] = (float)(i % 4 < 3 ? f->R[o][3 * (i / 4) + i % 4] : f->t[o][i / 4]);
}

static lt_status write_labels(const synth_dexycb_frame *f, const char *path)
{
    const int64_t seg[2] = { H, W }, y[3] = { f->sequence->n_objects, 3, 4 }, m[2] = { 1, 51 },
                  j3[3] = { 1, LT_HAND_KEYPOINTS, 3 }, j2[3] = { 1, LT_HAND_KEYPOINTS, 2 };
    numbers n;
    const lt_named_array a[] = {
        { "seg", lt_array_make(LT_ELEM_U1, 2, seg, f->picture->label) },
        { "pose_y", lt_array_make(LT_ELEM_F4, 3, y, n.pose_y) },
        { "pose_m", lt_array_make(LT_ELEM_F4, 2, m, n.pose_m) },
        { "joint_3d", lt_array_make(LT_ELEM_F4, 3, j3, n.joints) },
        { "joint_2d", lt_array_make(LT_ELEM_F4, 3, j2, n.joints2d) },
    };

    fill(f, &n);
    return lt_npz_write(path, a, LT_COUNT(a), true);
}

static lt_status write_depth(lt_arena *arena, const synth_picture *p, const char *path)
{
    lt_image img;
    const lt_status st = lt_image_init(arena, W, H, 1, 16, &img);

    for (size_t i = 0; !st && i < (size_t)W * H; i++)
        ((uint16_t *)(void *)img.data)[i] = (uint16_t)lrint(fmin(1000.0 * p->depth[i], 65535));
    return st ? st : lt_png_write_fast(path, &img);
}

static lt_status write_file(lt_arena *arena, const char *root, const synth_dexycb_frame *f, int kind, int quality,
                            synth_file *out)
{
    static const char *const what[] = { "color", "aligned_depth_to_color", "labels" },
        *const ending[] = { "jpg", "png", "npz" };
    const char *within = lt_arena_printf(arena, "%s/%s/%s_%06d.%s", f->sequence->folder, synth_dexycb_serial[f->camera],
                                         what[kind], f->picture->frame, ending[kind]);
    const char *path = within ? lt_path_join(arena, root, within) : NULL;
    const lt_image rgb = { W, H, 3, 8, (uint8_t *)f->picture->rgb };
    lt_status st;

    if (!path)
        return lt_error(LT_ENOMEM, "%s: no memory", f->sequence->folder);
    switch (kind) {
    case 0: st = lt_jpeg_write(path, &rgb, quality); break;
    case 1: st = write_depth(arena, f->picture, path); break;
    default: st = write_labels(f, path); break;
    }
    return st ? st : synth_describe_file(root, within, out);
}

lt_status synth_dexycb_write_frame(const char *root, const synth_dexycb_frame *f, int quality, synth_file *files)
{
    lt_arena *arena = lt_arena_new();
    lt_status st = arena ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", f->sequence->folder);

    for (int kind = 0; !st && kind < SYNTH_DEXYCB_FILES; kind++)
        st = write_file(arena, root, f, kind, quality, &files[kind]);
    lt_arena_free(arena);
    return st;
}

/* ---- a sequence ---- */

lt_status synth_dexycb_make_folders(const char *root, const synth_dexycb_sequence *q)
{
    lt_arena *arena = lt_arena_new();
    lt_status st = arena ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", q->folder);

    for (int c = 0; !st && c < q->cameras; c++) {
        const char *path = lt_arena_printf(arena, "%s/%s/%s", root, q->folder, synth_dexycb_serial[c]);
        st = path ? lt_make_dirs(path) : lt_error(LT_ENOMEM, "%s: no memory", q->folder);
    }
    lt_arena_free(arena);
    return st;
}

static lt_status write_meta(lt_arena *arena, const char *root, const synth_dexycb_sequence *q, synth_manifest *manifest)
{
    const char *serials = "", *ids = "", *within = lt_arena_printf(arena, "%s/meta.yml", q->folder), *text;

    for (int c = 0; serials && c < q->cameras; c++)
        serials = lt_arena_printf(arena, "%s- '%s'\n", serials, synth_dexycb_serial[c]);
    for (int o = 0; ids && o < q->n_objects; o++)
        ids = lt_arena_printf(arena, "%s- %d\n", ids, q->id[o]);
    text = serials && ids ? lt_arena_printf(arena, "extrinsics: %s\nmano_calib:\n- %s\nmano_sides:\n- %s\n"
                                            "num_frames: %d\nserials:\n%sycb_grasp_ind: %d\nycb_ids:\n%s",
                                            q->extrinsics, q->mano, q->left ? "left" : "right", q->frames, serials,
                                            q->grasped, ids) : NULL;
    if (!within || !text)
        return lt_error(LT_ENOMEM, "%s: no memory", q->folder);
    return synth_manifest_text(manifest, root, within, text);
}

static lt_status write_poses(lt_arena *arena, const char *root, const synth_dexycb_sequence *q, const float *pose_m,
                             const float *pose_y, synth_manifest *manifest)
{
    const int64_t y[3] = { q->frames, q->n_objects, 7 }, m[3] = { q->frames, 1, 51 };
    const lt_named_array a[] = { { "pose_y", lt_array_make(LT_ELEM_F4, 3, y, pose_y) },
                                 { "pose_m", lt_array_make(LT_ELEM_F4, 3, m, pose_m) } };
    const char *within = lt_arena_printf(arena, "%s/pose.npz", q->folder);
    const char *path = within ? lt_path_join(arena, root, within) : NULL;
    const lt_status st = path ? lt_npz_write(path, a, LT_COUNT(a), true)
                              : lt_error(LT_ENOMEM, "%s: no memory", q->folder);

    return st ? st : synth_manifest_file(manifest, root, within);
}

lt_status synth_dexycb_write_sequence(const char *root, const synth_dexycb_sequence *q, const float *pose_m,
                                      const float *pose_y, synth_manifest *manifest)
{
    lt_arena *arena = lt_arena_new();
    lt_status st = arena ? write_meta(arena, root, q, manifest) : lt_error(LT_ENOMEM, "%s: no memory", q->folder);

    if (!st)
        st = write_poses(arena, root, q, pose_m, pose_y, manifest);
    lt_arena_free(arena);
    return st;
}

/* ---- calibration ---- */

/* root/calibration/folder/name, its folder made. */
static lt_status write_calibration(lt_arena *arena, const char *root, const char *folder, const char *name,
                                   const char *text, synth_manifest *manifest)
{
    const char *within = lt_arena_printf(arena, "calibration/%s/%s", folder, name);
    const char *path = lt_arena_printf(arena, "%s/calibration/%s", root, folder);
    const lt_status st = within && path && text ? lt_make_dirs(path) : lt_error(LT_ENOMEM, "%s: no memory", folder);

    return st ? st : synth_manifest_text(manifest, root, within, text);
}

lt_status synth_dexycb_write_intrinsics(const char *root, const synth_camera *camera, int n, synth_manifest *manifest)
{
    lt_arena *arena = lt_arena_new();
    lt_status st = arena ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", root);

    for (int i = 0; !st && i < n; i++) {
        char x[4][LT_NUMBER_TEXT], name[64];
        const char *text = lt_arena_printf(arena, "color:\n  fx: %s\n  fy: %s\n  ppx: %s\n  ppy: %s\n",
                                           lt_print_double(camera[i].fx, x[0]), lt_print_double(camera[i].fy, x[1]),
                                           lt_print_double(camera[i].cx, x[2]), lt_print_double(camera[i].cy, x[3]));
        snprintf(name, sizeof(name), "%s_640x480.yml", synth_dexycb_serial[i]);
        st = write_calibration(arena, root, "intrinsics", name, text, manifest);
    }
    lt_arena_free(arena);
    return st;
}

/* A list of numbers under a key, one a line. */
static const char *list_text(lt_arena *arena, const char *before, const char *key, const char *indent, const double *x,
                             int n)
{
    const char *text = before ? lt_arena_printf(arena, "%s%s%s:\n", before, indent, key) : NULL;
    char number[LT_NUMBER_TEXT];

    for (int i = 0; text && i < n; i++)
        text = lt_arena_printf(arena, "%s%s- %s\n", text, indent, lt_print_double(x[i], number));
    return text;
}

static void matrix_of(const double R[9], const double t[3], double out[12])
{
    for (int i = 0; i < 12; i++)
        out[i] = i % 4 < 3 ? R[3 * (i / 4) + i % 4] : t[i / 4];
}

lt_status synth_dexycb_write_extrinsics(const char *root, const char *id, const synth_camera *camera, int n,
                                        synth_manifest *manifest)
{
    lt_arena *arena = lt_arena_new();
    const char *text = "extrinsics:\n", *folder;
    double R[9], t[3], m[12];
    char key[32];
    lt_status st;

    if (!arena)
        return lt_error(LT_ENOMEM, "%s: no memory", id);
    for (int i = 0; i < n; i++) {
        synth_camera_to_first(&camera[0], &camera[i], R, t);
        matrix_of(R, t, m);
        snprintf(key, sizeof(key), "'%s'", synth_dexycb_serial[i]);
        text = list_text(arena, text, key, "  ", m, 12);
    }
    matrix_of(camera[0].R_cam_world, camera[0].t_cam_world, m);
    text = list_text(arena, text, "apriltag", "  ", m, 12);
    text = text ? lt_arena_printf(arena, "%smaster: '%s'\n", text, synth_dexycb_serial[0]) : NULL;
    folder = lt_arena_printf(arena, "extrinsics_%s", id);
    st = folder ? write_calibration(arena, root, folder, "extrinsics.yml", text, manifest)
                : lt_error(LT_ENOMEM, "%s: no memory", id);
    lt_arena_free(arena);
    return st;
}

lt_status synth_dexycb_write_mano(const char *root, const char *id, const double beta[LT_HAND_BETAS],
                                  synth_manifest *manifest)
{
    lt_arena *arena = lt_arena_new();
    const char *folder = arena ? lt_arena_printf(arena, "mano_%s", id) : NULL;
    const lt_status st = folder ? write_calibration(arena, root, folder, "mano.yml",
                                                    list_text(arena, "", "betas", "", beta, LT_HAND_BETAS), manifest)
                                : lt_error(LT_ENOMEM, "%s: no memory", id);

    lt_arena_free(arena);
    return st;
}
