/* SPDX-License-Identifier: Apache-2.0 */
/* The DexYCB reader on trees made here: the official lists, both hands, filters, and every way a tree is broken. */
#include "assets/hand/hand.h"
#include "assets/ycb/ycb.h"
#include "data/dexycb/dexycb.h"
#include "data/mirror.h"
#include "eval/scorers/bop_score.h"
#include "eval/scorers/dexycb_files.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/array/npz.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "libtensor/io/mesh/obj.h"
#include "libtensor/io/text/json.h"
#include "tests/scratch.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { W = 640, H = 480 };

static lt_hand_model *right, *left;

static const char *const serial[8] = {
    "836212060125", "839512060362", "840412060917", "841412060263",
    "932122060857", "932122060861", "932122061900", "932122062010",
};

static void text_file(const char *path, const char *text)
{
    check_ok(lt_write_file(at(path), text, strlen(text)));
}

/* ---- calibration and folders ---- */

static void calibration(int subjects, int cameras)
{
    check_ok(lt_make_dirs(at("calibration/intrinsics")));
    for (int c = 0; c < cameras; c++)
        text_file(lt_arena_printf(arena, "calibration/intrinsics/%s_640x480.yml", serial[c]),
                  "color:\n  fx: 613.0762\n  fy: 611.9990\n  ppx: 313.0280\n  ppy: 245.0087\ndepth: {fx: 1}\n");
    for (int s = 0; s < subjects; s++) {
        check_ok(lt_make_dirs(at(lt_arena_printf(arena, "calibration/mano_subject-%02d", s + 1))));
        text_file(lt_arena_printf(arena, "calibration/mano_subject-%02d/mano.yml", s + 1),
                  "betas:\n- 0.5\n- -1\n- 0.25\n- 0\n- 0\n- 0\n- 0\n- 0\n- 0\n- 0.125\n");
    }
}

/* "2020070S-subject-0S/20200709_1000QQ" */
static const char *sequence_folder(int subject, int sequence)
{
    return lt_arena_printf(arena, "202007%02d-subject-%02d/20200709_10%04d", subject + 1, subject + 1, sequence);
}

static void meta(int subject, int sequence, int cameras, int frames, bool is_left)
{
    const char *folder = sequence_folder(subject, sequence);
    char text[1024], *p = text;

    check_ok(lt_make_dirs(at(folder)));
    p += sprintf(p, "extrinsics: '20200702_151821'\nmano_calib:\n- subject-%02d\nmano_sides:\n- %s\nnum_frames: %d\n"
                 "serials:\n", subject + 1, is_left ? "left" : "right", frames);
    for (int c = 0; c < cameras; c++)
        p += sprintf(p, "- '%s'\n", serial[c]);
    sprintf(p, "ycb_grasp_ind: 1\nycb_ids:\n- 2\n- 5\n");
    text_file(lt_arena_printf(arena, "%s/meta.yml", folder), text);
}

static void setup(void)
{
    open_scratch();
    check_ok(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &right));
    left = lt_arena_alloc(arena, sizeof(*left));
    synth_hand_mirror(right, left);
}

/* ---- the lists of the splits ---- */

static dataset *open_list(const char *s, const char *split)
{
    const dexycb_options o = { .root = scratch_folder, .setup = s, .split = split, .filter = DEXYCB_EVERY,
                               .hand = right, .no_objects = true };
    dataset *d = NULL;

    check_ok(dexycb_open(&o, &d));
    return d;
}

/* All of DexYCB's folders, each sequence with 72 frames; no image in them. */
static void full_tree(void)
{
    calibration(10, 8);
    for (int s = 0; s < 10; s++)
        for (int q = 0; q < 100; q++)
            meta(s, q, 8, 72, false);
}

static const struct { const char *setup, *split; int subjects, sequences, cameras; } counts[] = {
    { "s0", "train", 10, 80, 8 }, { "s0", "val", 2, 20, 8 }, { "s0", "test", 8, 20, 8 },
    { "s1", "train", 7, 100, 8 }, { "s1", "val", 1, 100, 8 }, { "s1", "test", 2, 100, 8 },
    { "s2", "train", 10, 100, 6 }, { "s2", "val", 10, 100, 1 }, { "s2", "test", 10, 100, 1 },
    { "s3", "train", 10, 75, 8 }, { "s3", "val", 10, 10, 8 }, { "s3", "test", 10, 15, 8 },
};

START_TEST(official_lists)
{
    full_tree();
    for (size_t i = 0; i < LT_COUNT(counts); i++) {
        dataset *d = open_list(counts[i].setup, counts[i].split);
        ck_assert_int_eq(d->count, (int64_t)counts[i].subjects * counts[i].sequences * counts[i].cameras * 72);
        dataset_free(d);
    }
}
END_TEST

/* Number k of s0's training list, counted by the toolkit's loops. */
START_TEST(order_of_the_list)
{
    dataset *d;
    int64_t k = 0;

    full_tree();
    d = open_list("s0", "train");
    ck_assert_str_eq(d->title, "DexYCB s0");
    ck_assert_int_eq(d->count, 460800);
    for (int s = 0, scene = 0; s < 10; s++)
        for (int q = 0; q < 100; q++) {
            if (q % 5 == 4)
                continue;
            for (int c = 0; c < 8; c++, scene++)
                for (int f = 0; f < 72; f++, k++) {
                    char want[128];
                    dexycb_place p;
                    if (f % 35 != 0)
                        continue;
                    p = dexycb_place_of(d, k);
                    snprintf(want, sizeof(want), "202007%02d-subject-%02d/20200709_10%04d/%s/%06d", s + 1, s + 1, q,
                             serial[c], f);
                    ck_assert_str_eq(dataset_name(d, k), want);
                    ck_assert_int_eq(p.index, k);
                    ck_assert_int_eq(p.scene, scene);
                    ck_assert_int_eq(p.image, f);
                    ck_assert_int_eq(p.keyframe, f % 4 == 0);
                    ck_assert_int_eq(p.target[p.grasped], 5);
                }
        }
    ck_assert_int_eq(k, d->count);
    dataset_free(d);
}
END_TEST

/* ---- a small tree with everything in it ---- */

static float coefficient[45];
static const float root_aa[3] = { 0.3f, -0.4f, 0.2f }, trans[3] = { 0.03f, -0.05f, 0.7f };
static const float beta[10] = { 0.5f, -1, 0.25f, 0, 0, 0, 0, 0, 0, 0.125f };

typedef struct {
    float pose[51], joints[21][3], joints2d[21][2], object[2][3][4];
    double vertices[LT_HAND_VERTICES][3];
} label;

/* Joints of the side's own model in the stored pose, as the toolkit's labels are made. */
static void pose_label(bool is_left, label *l)
{
    const lt_hand_model *m = is_left ? left : right;
    double R[16 * 9], b[10], t[3], joints[16][3], keypoints[21][3], aa[3];
    static const int tips_left[5] = { 745, 317, 445, 556, 673 };

    memcpy(l->pose, root_aa, sizeof(root_aa));
    memcpy(l->pose + 3, coefficient, sizeof(coefficient));
    memcpy(l->pose + 48, trans, sizeof(trans));
    for (int j = 0; j < 16; j++) {
        for (int k = 0; k < 3; k++) {
            aa[k] = root_aa[k];
            if (j)
                aa[k] = m->hands_mean[3 * (j - 1) + k];
            for (int i = 0; j && i < 45; i++)
                aa[k] += (double)coefficient[i] * m->hands_components[i][3 * (j - 1) + k];
        }
        lt_rot_from_axis_angle(aa, R + 9 * j);
    }
    for (int i = 0; i < 10; i++)
        b[i] = beta[i];
    for (int i = 0; i < 3; i++)
        t[i] = trans[i];
    lt_hand_pose(m, R, b, t, l->vertices[0], joints[0]);
    lt_hand_keypoints(l->vertices[0], joints[0], is_left ? tips_left : lt_hand_tips_dexycb, LT_HAND_SIMPLE_ORDER,
                      keypoints[0]);
    for (int i = 0; i < 21; i++) {
        const lt_camera cam = { 613.0762, 611.9990, 313.0280, 245.0087 };
        double uv[2];
        lt_camera_project(&cam, keypoints[i], uv);
        for (int k = 0; k < 3; k++)
            l->joints[i][k] = (float)keypoints[i][k];
        l->joints2d[i][0] = (float)uv[0];
        l->joints2d[i][1] = (float)uv[1];
    }
}

/* The object in the hand has a vertex, its model's origin, exactly distance away from vertex 0 of the hand. */
static void pose_object(label *l, float distance)
{
    double R[9];

    lt_rot_from_axis_angle((const double[]){ 0.2, 0.5, -0.9 }, R);
    memset(l->object, 0, sizeof(l->object));
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++)
            l->object[1][i][k] = (float)R[3 * i + k];
        l->object[1][i][3] = (float)l->vertices[0][i];
    }
    l->object[1][0][3] += distance;
}

/* The hand in the first column, the object in it in the second, the other one in the third, background after. */
static uint8_t *segmentation(void)
{
    static const uint8_t column[4] = { 255, 5, 2, 0 };
    uint8_t *s = lt_arena_alloc(arena, W * H);

    for (int i = 0; i < W * H; i++)
        s[i] = column[i % W < 3 ? i % W : 3];
    return s;
}

static void write_label(const char *path, const label *l)
{
    const int64_t pose[2] = { 1, 51 }, j3[3] = { 1, 21, 3 }, j2[3] = { 1, 21, 2 }, y[3] = { 2, 3, 4 },
        seg[2] = { H, W };
    uint8_t *s = segmentation();
    const lt_named_array a[] = {
        { "seg", lt_array_make(LT_ELEM_U1, 2, seg, s) }, { "pose_y", lt_array_make(LT_ELEM_F4, 3, y, l->object) },
        { "pose_m", lt_array_make(LT_ELEM_F4, 2, pose, l->pose) },
        { "joint_3d", lt_array_make(LT_ELEM_F4, 3, j3, l->joints) },
        { "joint_2d", lt_array_make(LT_ELEM_F4, 3, j2, l->joints2d) },
    };

    check_ok(lt_npz_write(at(path), a, LT_COUNT(a), true));
}

static label no_hand(label l)
{
    memset(l.pose, 0, sizeof(l.pose));
    for (int i = 0; i < 21; i++)
        for (int k = 0; k < 3; k++) {
            l.joints[i][k] = -1;
            l.joints2d[i][k / 2] = -1;
        }
    return l;
}

static const char *frame(int sequence, const char *what, int number, const char *ending)
{
    return lt_arena_printf(arena, "%s/%s/%s_%06d.%s", sequence_folder(0, sequence), serial[0], what, number, ending);
}

/* Columns get brighter to the right; depth in mm is the column, but for a hole. */
static void write_pictures(int sequence, int number)
{
    lt_image rgb, depth;

    check_ok(lt_image_init(arena, W, H, 3, 8, &rgb));
    check_ok(lt_image_init(arena, W, H, 1, 16, &depth));
    for (int i = 0; i < W * H; i++) {
        memset(rgb.data + 3 * i, i % W / 3, 3);
        ((uint16_t *)(void *)depth.data)[i] = (uint16_t)(i % W == 7 ? 0 : 1000 + i % W);
    }
    check_ok(lt_jpeg_write(at(frame(sequence, "color", number, "jpg")), &rgb, 95));
    check_ok(lt_png_write(at(frame(sequence, "aligned_depth_to_color", number, "png")), &depth));
}

static void model(const char *name)
{
    float vertex[4][3] = { { 0, 0, 0 }, { .04f, 0, 0 }, { 0, .06f, 0 }, { 0, 0, .1f } };
    int32_t face[4][3] = { { 0, 2, 1 }, { 0, 1, 3 }, { 0, 3, 2 }, { 1, 2, 3 } };
    const lt_mesh mesh = { .n_vertices = 4, .n_faces = 4, .vertex = vertex, .face = face };
    const char *folder = lt_arena_printf(arena, "models/%s", name);

    check_ok(lt_make_dirs(at(folder)));
    check_ok(lt_obj_write(at(lt_arena_printf(arena, "%s/textured_simple.obj", folder)), &mesh, NULL));
    check_ok(lt_xyz_write(at(lt_arena_printf(arena, "%s/points.xyz", folder)), (const float (*)[3])vertex, 4));
}

static bool is_left_sequence(int q)
{
    return q == 1 || q >= 3;
}

static label label_of(int q, int f)
{
    label l;

    pose_label(is_left_sequence(q), &l);
    pose_object(&l, q == 0 && f == 5 ? 0.02f : 0.004f);
    return q == 2 ? no_hand(l) : l;
}

/* One subject with five sequences of six frames: right, left, right without hands, left, left. The hand of
 * sequence 0 touches the object in frames 0 to 4 and is 2 cm away in frame 5. */
static void small_tree(void)
{
    lt_rng rng = lt_rng_make(3, 1);

    for (int i = 0; i < 45; i++)
        coefficient[i] = (float)lt_rng_range(&rng, -0.4, 0.4);
    text_file("synthetic.json", "{\"subjects\": 1, \"sequences\": 5}\n");
    calibration(1, 1);
    model("006_mustard_bottle");
    for (int q = 0; q < 5; q++) {
        meta(0, q, 1, 6, is_left_sequence(q));
        check_ok(lt_make_dirs(at(lt_arena_printf(arena, "%s/%s", sequence_folder(0, q), serial[0]))));
        for (int f = 0; f < 6; f++) {
            const label l = label_of(q, f);
            write_label(frame(q, "labels", f, "npz"), &l);
            write_pictures(q, f);
        }
    }
}

static dataset *open_small(dexycb_filter filter)
{
    const dexycb_options o = { .root = scratch_folder, .setup = "s0", .split = "train", .filter = filter,
                               .hand = right };
    dataset *d = NULL;

    check_ok(dexycb_open(&o, &d));
    return d;
}

/* The mesh that a sample's rotations and shape make of the right hand, at its root. */
static void pose_sample(const dataset_sample *s, double keypoints[21][3])
{
    double R[16 * 9], b[10], vertices[LT_HAND_VERTICES][3], joints[16][3];

    for (int i = 0; i < 16 * 9; i++)
        R[i] = s->rotation[i / 9][i % 9];
    for (int i = 0; i < 10; i++)
        b[i] = s->beta[i];
    lt_hand_pose(right, R, b, NULL, vertices[0], joints[0]);
    lt_hand_keypoints(vertices[0], joints[0], lt_hand_tips_dexycb, LT_HAND_SIMPLE_ORDER, keypoints[0]);
    for (int i = 20; i >= 0; i--)
        for (int k = 0; k < 3; k++)
            keypoints[i][k] += s->root[k] - keypoints[0][k];
}

START_TEST(right_hand)
{
    dataset *d;
    dataset_sample s;
    double k[21][3];
    label l;

    small_tree();
    d = open_small(DEXYCB_EVERY);
    ck_assert_int_eq(d->count, 24);
    ck_assert(d->synthetic);
    check_ok(dataset_read(d, 2, SAMPLE_OBJECT | SAMPLE_DEPTH, arena, &s));
    ck_assert_int_eq(s.flags, SAMPLE_HAND_POSE | SAMPLE_JOINTS | SAMPLE_ROOT | SAMPLE_OBJECT | SAMPLE_DEPTH);
    pose_label(false, &l);
    pose_sample(&s, k);
    for (int i = 0; i < 21; i++)
        for (int c = 0; c < 3; c++) {
            ck_assert_float_eq(s.joints[i][c], l.joints[i][c]);
            ck_assert_double_eq_tol(k[i][c], l.joints[i][c], 1e-6);
            if (c < 2)
                ck_assert_float_eq_tol(s.joints2d[i][c], l.joints2d[i][c], 1e-3f);
        }
    ck_assert_float_eq_tol(s.depth[100], 1.1f, 1e-6f);
    ck_assert_float_eq(s.depth[7], 0);
    ck_assert_int_eq(s.rgb[3 * 600], 200);
    ck_assert_double_eq(s.camera.cy, 245.0087);
    ck_assert_str_eq(d->objects[s.object].name, "006_mustard_bottle");
    check_ok(dataset_read(d, 2, 0, arena, &s));
    ck_assert_ptr_null(s.depth);
    dataset_free(d);
}
END_TEST

START_TEST(other_endings)
{
    static const char *const ending[] = { "JPG", "jpeg", "PNG" };
    dataset *d;
    dataset_sample s;

    small_tree();
    d = open_small(DEXYCB_EVERY);
    for (size_t i = 0; i < LT_COUNT(ending); i++) {
        ck_assert_int_eq(rename(at(frame(0, "color", 2, i ? ending[i - 1] : "jpg")),
                                at(frame(0, "color", 2, ending[i]))), 0);
        ck_assert_ptr_null(d->ops->missing(d, 2, arena));
        check_ok(dataset_read(d, 2, 0, arena, &s));
    }
    unlink(at(frame(0, "color", 2, "PNG")));
    ck_assert_str_eq(d->ops->missing(d, 2, arena), at(frame(0, "color", 2, "jpg")));
    dataset_free(d);
}
END_TEST

/* A left hand is a right hand in the mirror: image, depth, pose, object. */
START_TEST(left_hand)
{
    dataset *d;
    dataset_sample s;
    double k[21][3], uv[2], p[3] = { 0 };
    label l;
    float A[9];

    small_tree();
    d = open_small(DEXYCB_VALID);
    ck_assert_int_eq(d->count, 18);
    check_ok(dataset_read(d, 6, SAMPLE_OBJECT | SAMPLE_DEPTH, arena, &s));
    ck_assert(s.flags & SAMPLE_MIRRORED);
    pose_label(true, &l);
    pose_object(&l, 0.004f);
    pose_sample(&s, k);
    for (int i = 0; i < 21; i++) {
        const double tolerance = i == 12 ? 1e-2 : 1e-6;         /* the toolkit's left middle tip is another vertex */
        ck_assert_float_eq(s.joints[i][0], -l.joints[i][0]);
        for (int c = 0; c < 3; c++)
            ck_assert_double_eq_tol(k[i][c], c ? l.joints[i][c] : -l.joints[i][c], tolerance);
        ck_assert_float_eq_tol(s.joints2d[i][0], W - 1 - l.joints2d[i][0], 1e-3f);
        ck_assert_float_eq_tol(s.joints2d[i][1], l.joints2d[i][1], 1e-3f);
    }
    ck_assert_float_eq_tol(s.depth[0], 1.639f, 1e-6f);
    ck_assert_int_eq(s.rgb[0], 213);
    ck_assert_double_eq_tol(s.camera.cx, W - 1 - 313.0280, 1e-9);
    dataset_model_to_camera(&s, A);                             /* the model's vertex (0, 0, 0.1) */
    for (int c = 0; c < 3; c++)
        p[c] = 0.1 * A[3 * c + 2] + s.t[c];
    ck_assert_float_eq_tol((float)p[0], -(0.1f * l.object[1][0][2] + l.object[1][0][3]), 1e-6f);
    ck_assert_float_eq_tol((float)p[2], 0.1f * l.object[1][2][2] + l.object[1][2][3], 1e-6f);
    for (int c = 0; c < 3; c++)                                 /* a point within it */
        p[c] = .01 * A[3 * c] + .015 * A[3 * c + 1] + .025 * A[3 * c + 2] + s.t[c];
    lt_camera_project(&s.camera, p, uv);
    ck_assert_int_eq(s.silhouette[lrint(uv[1]) * W + lrint(uv[0])], 1);
    dataset_free(d);
}
END_TEST

/* Hand and the object in it, as the picture is turned; not the other things on the table. */
START_TEST(segments)
{
    const bool is_left = _i;
    dataset *d;
    dataset_sample s;

    small_tree();
    d = open_small(DEXYCB_VALID);
    check_ok(dataset_read(d, is_left ? 6 : 0, 0, arena, &s));
    ck_assert_ptr_null(s.segments);
    check_ok(dataset_read(d, is_left ? 6 : 0, SAMPLE_SEGMENTS, arena, &s));
    ck_assert(s.flags & SAMPLE_SEGMENTS);
    ck_assert_int_eq(!!(s.flags & SAMPLE_MIRRORED), is_left);
    ck_assert_int_eq(s.segments_width, W);
    ck_assert_int_eq(s.segments_height, H);
    for (int i = 0; i < W * H; i++) {
        const int x = is_left ? W - 1 - i % W : i % W;
        ck_assert_int_eq(s.segments[i], x == 0 ? SEGMENT_HAND : x == 1 ? SEGMENT_OBJECT : 0);
    }
    dataset_free(d);
}
END_TEST

START_TEST(segments_are_broken)
{
    const int64_t shape[2] = { H / 4, W / 4 };
    const char *path = at(frame(0, "labels", 0, "npz"));
    dataset *d;
    dataset_sample s;
    lt_npz npz;
    lt_named_array a[5];

    small_tree();
    check_ok(lt_npz_read(arena, path, &npz));
    for (int i = 0; i < 5; i++)
        a[i] = npz.entry[i];
    ck_assert_str_eq(a[0].name, "seg");
    a[0].array = lt_array_make(LT_ELEM_U1, 2, shape, segmentation());
    check_ok(lt_npz_write(path, a, 5, true));
    d = open_small(DEXYCB_VALID);
    check_ok(dataset_read(d, 0, 0, arena, &s));
    ck_assert_int_eq(dataset_read(d, 0, SAMPLE_SEGMENTS, arena, &s), LT_EFORMAT);
    ck_assert_str_eq(lt_last_error(),
                     lt_arena_printf(arena, "%s: seg is (120, 160), expected bytes of shape (480, 640)", path));
    dataset_free(d);
}
END_TEST

/* A left model of its own is used for the components. */
START_TEST(left_model)
{
    dexycb_options o = { .root = scratch_folder, .setup = "s0", .split = "train", .hand = right };
    dataset *with, *without;
    dataset_sample a, b;

    small_tree();
    check_ok(dexycb_open(&o, &without));
    o.left = left;
    check_ok(dexycb_open(&o, &with));
    check_ok(dataset_annotation(with, 6, arena, &a));
    check_ok(dataset_annotation(without, 6, arena, &b));
    for (int i = 0; i < 16 * 9; i++)
        ck_assert_float_eq_tol(a.rotation[i / 9][i % 9], b.rotation[i / 9][i % 9], 1e-6f);
    for (int k = 0; k < 45; k++)
        for (int i = 0; i < 45; i++)
            left->hands_components[k][i] *= 2;
    dataset_free(with);
    check_ok(dexycb_open(&o, &with));
    check_ok(dataset_annotation(with, 6, arena, &a));
    ck_assert_float_eq(a.rotation[0][1], b.rotation[0][1]);
    ck_assert_float_gt(fabsf(a.rotation[1][1] - b.rotation[1][1]), 1e-3f);
    dataset_free(with);
    dataset_free(without);
}
END_TEST

START_TEST(tips_of_the_toolkit)
{
    dataset *d;
    double rms;

    small_tree();
    d = open_small(DEXYCB_VALID);
    check_ok(dataset_check_tips(d, right, &rms));
    ck_assert_double_lt(rms, 1e-3);
    ck_assert_mem_eq(d->tips, lt_hand_tips_dexycb, sizeof(lt_hand_tips_dexycb));
    dataset_free(d);
}
END_TEST

/* ---- result files ---- */

/* What the labels say, as the results of a perfect estimator; the object's score is a half. */
static void write_results(const dataset *d, const char *path)
{
    dexycb_results *f;

    check_ok(dexycb_results_open(path, &f));
    for (int64_t i = 0; i < d->count; i++) {
        dexycb_result r = { .place = dexycb_place_of(d, i), .width = W, .seconds = -1, .has_object = true,
                            .score = 0.5 };
        dataset_sample s;
        check_ok(dataset_annotation(d, i, arena, &s));
        r.mirrored = s.flags & SAMPLE_MIRRORED;
        r.camera = s.camera;
        r.joints = (const float (*)[3])s.joints;
        for (int k = 0; k < 9; k++)
            r.object.R[k] = s.R[k];
        for (int k = 0; k < 3; k++)
            r.object.t[k] = s.t[k];
        dexycb_results_add(f, &r);
    }
    check_ok(dexycb_results_close(f));
}

static char *text_of(const char *path)
{
    static uint8_t *bytes;
    size_t n;

    check_ok(lt_read_file(arena, path, 1 << 20, &bytes, &n));
    return (char *)bytes;
}

/* Hand joints: 18 lines with the toolkit's indices, left hands on their own side; scored they are perfect. */
START_TEST(hpe_file)
{
    double scores[DEXYCB_SCORES], x;
    dataset *d;
    char *text;
    label l;

    small_tree();
    d = open_small(DEXYCB_VALID);
    write_results(d, at("hpe.txt"));
    text = text_of(at("hpe.txt"));
    pose_label(true, &l);
    ck_assert_ptr_eq(strstr(text, "0,"), text);
    ck_assert_int_eq(sscanf(strstr(text, "\n6,") + 3, "%lf", &x), 1);
    ck_assert_double_eq_tol(x, 1000 * l.joints[0][0], 1e-3);        /* sample 6 is a left hand */
    ck_assert_ptr_null(strstr(text, "\n12,"));                     /* and 12 to 17 have none */
    check_ok(dexycb_score_hpe(d, at("hpe.txt"), scores, NULL));
    for (int i = 0; i < DEXYCB_SCORES; i++)
        ck_assert_double_eq_tol(scores[i], i % 2, i % 2 ? 0.01 : 1e-3);     /* no distance is 0 but by chance */
    text_file("bad.txt", "0,1,2,3\n");
    ck_assert_int_eq(dexycb_score_hpe(d, at("bad.txt"), scores, NULL), LT_EFORMAT);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "bad.txt:1: 3 numbers after the index, expected 63, all finite"));
    text_file("bad.txt", "x\n");
    ck_assert_int_eq(dexycb_score_hpe(d, at("bad.txt"), scores, NULL), LT_EFORMAT);
    *strchr(text, '\n') = 0;
    check_ok(lt_write_file(at("bad.txt"), text, strlen(text) + 1));
    ck_assert_int_eq(dexycb_score_hpe(d, at("bad.txt"), scores, NULL), LT_EFORMAT);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "bad.txt: found a NUL byte, expected text"));
    text_file("bad.txt", text);
    ck_assert_int_eq(dexycb_score_hpe(d, at("bad.txt"), scores, NULL), LT_EFORMAT);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "has no line for sample 1, "));
    dataset_free(d);
}
END_TEST

/* Object poses of key frames, as the labels have them: metres, the model's own frame, unmirrored. */
START_TEST(bop_file)
{
    dataset *d;
    char *text, *line, *rest = NULL;
    int lines = 0;
    label l;

    small_tree();
    d = open_small(DEXYCB_VALID);
    write_results(d, at("bop.csv"));
    text = text_of(at("bop.csv"));
    line = strtok_r(text, "\n", &rest);
    ck_assert_str_eq(line, "scene_id,im_id,obj_id,score,R,t,time");
    while ((line = strtok_r(NULL, "\n", &rest))) {
        double R[9], t[3], score, time;
        int scene, image, object;
        ck_assert_int_eq(sscanf(line, "%d,%d,%d,%lf,%lf %lf %lf %lf %lf %lf %lf %lf %lf,%lf %lf %lf,%lf", &scene,
                                &image, &object, &score, &R[0], &R[1], &R[2], &R[3], &R[4], &R[5], &R[6], &R[7], &R[8],
                                &t[0], &t[1], &t[2], &time), 17);
        ck_assert(scene >= 0 && scene <= 3 && scene != 2 && image % 4 == 0 && object == 5);
        ck_assert(score == 0.5 && time == -1);
        pose_label(scene == 1 || scene == 3, &l);
        pose_object(&l, 0.004f);
        for (int i = 0; i < 9; i++)
            ck_assert_double_eq_tol(R[i], l.object[1][i / 3][i % 3], 1e-7);
        for (int i = 0; i < 3; i++)
            ck_assert_double_eq_tol(t[i], l.object[1][i][3], 1e-7);
        lines++;
    }
    ck_assert_int_eq(lines, 6);
    dataset_free(d);
}
END_TEST

static bop_recalls recalls(const dataset *d, const char *name)
{
    bop_recalls r;

    check_ok(bop_score(d, at(name), NULL, NULL, NULL, NULL, &r));
    return r;
}

/* Nothing but the object in the hand is annotated: both scores are of the same targets. */
static bop_recall recall(const dataset *d, const char *name)
{
    const bop_recalls r = recalls(d, name);

    ck_assert_int_eq(r.all.targets, r.grasped.targets);
    ck_assert_double_eq(r.all.ar, r.grasped.ar);
    return r.grasped;
}

static void refuse(const dataset *d, const char *text, const char *why)
{
    bop_recalls r;

    text_file("bad.csv", text);
    ck_assert_int_eq(bop_score(d, at("bad.csv"), NULL, NULL, NULL, NULL, &r), LT_EFORMAT);
    ck_assert_msg(strstr(lt_last_error(), why) != NULL, "%s", lt_last_error());
}

/* What the labels say is right everywhere; an estimate that is missing, or no rigid pose, never is; and of two the
 * better score counts. */
START_TEST(bop_grasped)
{
    static const char first[] = "scene_id,im_id,obj_id,score,R,t,time\n";
    char *text, *line, *worse;
    bop_recall r;
    dataset *d;
    double n;

    small_tree();
    d = open_small(DEXYCB_EVERY);
    write_results(d, at("bop.csv"));
    r = recall(d, "bop.csv");
    n = (double)r.targets;
    ck_assert_int_gt(r.targets, 1);
    ck_assert_int_eq(r.estimated, r.targets);
    ck_assert(r.vsd == 1 && r.mssd == 1 && r.mspd == 1 && r.ar == 1);
    text = text_of(at("bop.csv"));
    line = strchr(text, '\n') + 1;
    worse = lt_arena_printf(arena, "%s%d,%d,5,0.1,1 0 0 0 1 0 0 0 1,9 9 9,-1\n", text, atoi(line),
                            atoi(strchr(line, ',') + 1));
    text_file("worse.csv", worse);
    ck_assert_double_eq(recall(d, "worse.csv").ar, 1);
    text_file("one_less.csv", lt_arena_printf(arena, "%s%s", first, strchr(line, '\n') + 1));
    r = recall(d, "one_less.csv");
    ck_assert_int_eq(r.estimated, r.targets - 1);
    ck_assert_double_eq_tol(r.ar, (n - 1) / n, 1e-12);
    text_file("no_pose.csv", lt_arena_printf(arena, "%s%d,%d,5,1,0 0 0 0 0 0 0 0 0,0 0 1,-1\n%s", first, atoi(line),
                                             atoi(strchr(line, ',') + 1), strchr(line, '\n') + 1));
    r = recall(d, "no_pose.csv");
    ck_assert_int_eq(r.estimated, r.targets);
    ck_assert_double_eq_tol(r.mssd, (n - 1) / n, 1e-12);
    refuse(d, "", "bad.csv: expected \"scene_id");
    refuse(d, "index,x\n", "bad.csv: expected \"scene_id");
    refuse(d, lt_arena_printf(arena, "%s0,0,5,1,1 0 0 0 1 0 0 0 1,0 0 1\n", first), "bad.csv:2: expected ");
    refuse(d, lt_arena_printf(arena, "%s0.5,0,5,1,1 0 0 0 1 0 0 0 1,0 0 1,-1\n", first), "bad.csv:2: expected ");
    refuse(d, lt_arena_printf(arena, "%s\n\n0,0,5\n", first), "bad.csv:4: expected ");
    refuse(d, lt_arena_printf(arena, "%s0,0,5,nan,1 0 0 0 1 0 0 0 1,0 0 1,-1\n", first), "bad.csv:2: expected ");
    dataset_free(d);
}
END_TEST

/* The cracker box stands beside the hand. */
static label with_box(int q, int f)
{
    label l = label_of(q, f);

    for (int i = 0; i < 3; i++) {
        l.object[0][i][(i + 1) % 3] = 1;
        l.object[0][i][3] = l.object[1][i][3];
    }
    l.object[0][0][3] += 0.15f;
    return l;
}

static char *csv_line(char *text, int scene, int image, int object, const float pose[3][4], float shift)
{
    text = lt_arena_printf(arena, "%s%d,%d,%d,1,", text, scene, image, object);
    for (int i = 0; i < 9; i++)
        text = lt_arena_printf(arena, "%s%.9g%s", text, (double)pose[i / 3][i % 3], i < 8 ? " " : ",");
    return lt_arena_printf(arena, "%s%.9g %.9g %.9g,-1\n", text, (double)(pose[0][3] + shift), (double)pose[1][3],
                           (double)pose[2][3]);
}

/* A box in the key frames of all sequences of the split but the last; its estimates are off by shift along x. */
static int64_t put_boxes(const char *csv, float shift)
{
    char *text = lt_arena_strdup(arena, "scene_id,im_id,obj_id,score,R,t,time\n");
    int64_t boxes = 0;

    for (int q = 0; q < 4; q++)
        for (int f = 0; f < 6; f += 4) {
            const label l = q < 3 ? with_box(q, f) : label_of(q, f);
            write_label(frame(q, "labels", f, "npz"), &l);
            text = csv_line(text, q, f, 5, (const float (*)[4])l.object[1], 0);
            if (q == 3)
                continue;
            text = csv_line(text, q, f, 2, (const float (*)[4])l.object[0], shift);
            boxes++;
        }
    text_file(csv, text);
    return boxes;
}

/* What is on the table counts in "all" alone; what is not annotated, in neither. */
START_TEST(bop_all)
{
    bop_recalls r;
    int64_t boxes;
    dataset *d;

    small_tree();
    model("003_cracker_box");
    boxes = put_boxes("all.csv", 0);
    put_boxes("off.csv", 0.05f);
    d = open_small(DEXYCB_EVERY);
    r = recalls(d, "all.csv");
    ck_assert_int_eq(r.all.targets, r.grasped.targets + boxes);
    ck_assert_int_eq(r.all.estimated, r.all.targets);
    ck_assert(r.grasped.ar == 1 && r.all.vsd == 1 && r.all.mssd == 1 && r.all.mspd == 1);
    write_results(d, at("grasped.csv"));
    r = recalls(d, "grasped.csv");
    ck_assert_double_eq(r.grasped.ar, 1);
    ck_assert_int_eq(r.all.estimated, r.grasped.targets);
    ck_assert_double_eq_tol(r.all.ar, (double)r.grasped.targets / (double)r.all.targets, 1e-12);
    r = recalls(d, "off.csv");
    ck_assert_double_eq(r.grasped.ar, 1);
    ck_assert_double_lt(r.all.mssd, 1);
    ck_assert_double_lt(r.all.vsd, 1);
    ck_assert_double_gt(r.all.mssd, (double)r.grasped.targets / (double)r.all.targets);
    dataset_free(d);
}
END_TEST

/* What is in the hand, turned halfway about the z axis of BOP's frame or off by shift along x */
static void put_bottles(const char *csv, bool turned, float shift)
{
    const double *c = ycb_find(5)->centre;
    char *text = lt_arena_strdup(arena, "scene_id,im_id,obj_id,score,R,t,time\n");

    for (int q = 0; q < 4; q++)
        for (int f = 0; f < 6; f += 4) {
            label l = label_of(q, f);
            for (int i = 0; turned && i < 3; i++) {
                float *p = l.object[1][i];
                p[3] += (float)(2 * (p[0] * c[0] + p[1] * c[1]));
                p[0] = -p[0];
                p[1] = -p[1];
            }
            text = csv_line(text, q, f, 5, (const float (*)[4])l.object[1], shift);
        }
    text_file(csv, text);
}

/* BOP's own file is looked for in the toolkit's place and among the models; what it says holds: the bottle turned
 * halfway is right for MSSD and MSPD, and a larger diameter forgives more. */
START_TEST(bop_models_info)
{
    static const char info[] = "{\"5\": {\"diameter\": %d, \"symmetries_discrete\": [[-1,0,0,0, 0,-1,0,0, 0,0,1,0, "
                               "0,0,0,1]]}}";
    const char *path;
    bop_recalls r;
    dataset *d;

    small_tree();
    put_bottles("turned.csv", true, 0);
    d = open_small(DEXYCB_EVERY);
    check_ok(dexycb_models_info(d, arena, &path));
    ck_assert_ptr_null(path);
    ck_assert_double_lt(recall(d, "turned.csv").mssd, 0.5);

    check_ok(lt_make_dirs(at("models/bop")));
    text_file("models/bop/models_info.json", lt_arena_printf(arena, info, 117));
    check_ok(dexycb_models_info(d, arena, &path));
    ck_assert_str_eq(path, at("models/bop/models_info.json"));
    check_ok(bop_score(d, at("turned.csv"), path, NULL, NULL, NULL, &r));
    ck_assert(r.grasped.mssd == 1 && r.grasped.mspd == 1);
    ck_assert_double_lt(r.grasped.vsd, 1);

    check_ok(lt_make_dirs(at("bop/s0/models_eval")));
    text_file("bop/s0/models_eval/models_info.json", lt_arena_printf(arena, info, 900));
    check_ok(dexycb_models_info(d, arena, &path));
    ck_assert_str_eq(path, at("bop/s0/models_eval/models_info.json"));
    put_bottles("off.csv", false, 0.04f);
    ck_assert_double_lt(recall(d, "off.csv").mssd, 0.5);
    check_ok(bop_score(d, at("off.csv"), path, NULL, NULL, NULL, &r));
    ck_assert_double_eq(r.grasped.mssd, 1);

    text_file("bop/s0/models_eval/models_info.json", "{\"2\": {\"diameter\": 269}}");
    ck_assert_int_eq(bop_score(d, at("off.csv"), path, NULL, NULL, NULL, &r), LT_EFORMAT);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "models_info.json: has no object 5, 006_mustard_bottle"));
    dataset_free(d);
}
END_TEST

/* A box on the table has to have its model, and a pose that is one. */
START_TEST(bop_bad_table)
{
    label l = with_box(0, 0);
    bop_recalls r;
    dataset *d;

    small_tree();
    put_boxes("all.csv", 0);
    d = open_small(DEXYCB_EVERY);
    ck_assert_int_eq(bop_score(d, at("all.csv"), NULL, NULL, NULL, NULL, &r), LT_EIO);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "the object is 003_cracker_box, which is not in "));
    l.object[0][0][0] = 7;
    write_label(frame(0, "labels", 0, "npz"), &l);
    ck_assert_int_eq(bop_score(d, at("all.csv"), NULL, NULL, NULL, NULL, &r), LT_EFORMAT);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "labels_000000.npz: pose_y: object 0: expected a rotation"));
    dataset_free(d);
}
END_TEST

START_TEST(coco_file)
{
    const cJSON *item, *box;
    struct cJSON *list;
    dexycb_results *f;
    dataset *d;
    label l;

    small_tree();
    d = open_small(DEXYCB_VALID);
    write_results(d, at("coco.json"));
    check_ok(lt_json_read(at("coco.json"), &list));
    ck_assert_int_eq(cJSON_GetArraySize(list), 18);
    item = cJSON_GetArrayItem(list, 7);
    ck_assert_int_eq(cJSON_GetObjectItem(item, "image_id")->valueint, 7);
    ck_assert_int_eq(cJSON_GetObjectItem(item, "category_id")->valueint, 22);
    pose_label(true, &l);
    for (int i = 0; i < 63; i++) {
        const double x = cJSON_GetArrayItem(cJSON_GetObjectItem(item, "keypoints"), i)->valuedouble;
        ck_assert_double_eq_tol(x, i % 3 < 2 ? l.joints2d[i / 3][i % 3] : 2, 1e-3);
    }
    box = cJSON_GetObjectItem(item, "bbox");
    ck_assert_double_gt(cJSON_GetArrayItem(box, 2)->valuedouble, 10);
    cJSON_Delete(list);
    ck_assert_int_eq(dexycb_results_open(at("x.zip"), &f), LT_EINVAL);
    dataset_free(d);
}
END_TEST

/* ---- filters ---- */

START_TEST(filters)
{
    label l;
    dataset *d;
    dexycb_filter f;

    small_tree();
    pose_label(false, &l);                          /* frame 3 of sequence 0: all of it right of the picture */
    pose_object(&l, 0.004f);
    for (int i = 0; i < 21; i++)
        l.joints2d[i][0] += 900;
    write_label(frame(0, "labels", 3, "npz"), &l);
    d = open_small(DEXYCB_HFL);
    ck_assert_int_eq(d->count, 17);
    ck_assert_int_eq(dexycb_place_of(d, 3).image, 4);
    dataset_free(d);
    d = open_small(DEXYCB_HOISDF);                  /* frame 0; frame 5 has no contact, the rest is no fifth frame */
    ck_assert_int_eq(d->count, 1);
    ck_assert_int_eq(dexycb_place_of(d, 0).image, 0);
    dataset_free(d);
    check_ok(dexycb_parse_filter("hoisdf", &f));
    ck_assert_int_eq(f, DEXYCB_HOISDF);
    ck_assert_int_eq(dexycb_parse_filter("all", &f), LT_EINVAL);
}
END_TEST

/* In testing, HFL-Net keeps a hand out of view, with the whole picture as its box. */
START_TEST(hfl_test_box)
{
    const dexycb_options o = { .root = scratch_folder, .setup = "s0", .split = "val", .filter = DEXYCB_HFL,
                               .hand = right };
    dataset *d;
    dataset_sample s;
    label l;

    small_tree();
    pose_label(true, &l);
    pose_object(&l, 0.004f);
    for (int i = 0; i < 21; i++)
        l.joints2d[i][1] -= 2000;
    write_label(frame(4, "labels", 1, "npz"), &l);
    check_ok(dexycb_open(&o, &d));
    ck_assert_int_eq(d->count, 6);
    check_ok(dataset_annotation(d, 0, arena, &s));
    ck_assert(!(s.flags & SAMPLE_HAND_BOX));
    check_ok(dataset_annotation(d, 1, arena, &s));
    ck_assert(s.flags & SAMPLE_HAND_BOX);
    ck_assert_float_eq(s.hand_box[0], 0);
    ck_assert_float_eq(s.hand_box[2], W - 1);
    dataset_free(d);
}
END_TEST

/* ---- what is wrong with a tree ---- */

static void open_fails(const char *setup_name, const char *split, lt_status want, const char *reason)
{
    const dexycb_options o = { .root = scratch_folder, .setup = setup_name, .split = split, .hand = right };
    dataset *d;

    ck_assert_int_eq(dexycb_open(&o, &d), want);
    ck_assert_msg(strstr(lt_last_error(), reason), "\"%s\" lacks \"%s\"", lt_last_error(), reason);
}

START_TEST(no_such_split)
{
    open_fails("s4", "train", LT_EINVAL, "s0 (all seen)");
    open_fails("s0", "trian", LT_EINVAL, "train, val or test");
    open_fails("s0", "train", LT_EIO, "no folder like 20200709-subject-01");
}
END_TEST

static const struct { const char *path, *text; lt_status st; const char *reason; } broken[] = {
    { "models", NULL, LT_EIO, "models.tar.gz" },
    { "calibration/intrinsics/836212060125_640x480.yml", NULL, LT_EIO, "836212060125_640x480.yml" },
    { "calibration/intrinsics/836212060125_640x480.yml", "color: {fx: 0, fy: 1, ppx: 1, ppy: 1}\n", LT_EFORMAT,
      "focal" },
    { "calibration/intrinsics/836212060125_640x480.yml", "color: {fx: 600, ppx: 1, ppy: 1}\n", LT_EFORMAT,
      "no key \"fy\"" },
    { "calibration/mano_subject-01/mano.yml", NULL, LT_EIO, "mano.yml" },
    { "calibration/mano_subject-01/mano.yml", "betas: [1, 2]\n", LT_EFORMAT, "found a list of 2, expected 10" },
    { "synthetic.json", NULL, LT_EFORMAT, "5 sequences, expected 100" },
    { "synthetic.json", "{\"subjects\": 11, \"sequences\": 5}", LT_EFORMAT, "from 1 to 10" },
    { "20200701-subject-01/20200709_100000/meta.yml", NULL, LT_EIO, "meta.yml" },
    { "20200701-subject-01/20200709_100000/meta.yml", "a: 1\n", LT_EFORMAT, "no key \"num_frames\"" },
    { "20200701-subject-01/20200709_100000/meta.yml", "num_frames: 0\n", LT_EFORMAT, "from 1 to 10000" },
    { "20200701-subject-01/20200709_100000/meta.yml", "num_frames: 2\nycb_ids: [22]\n", LT_EFORMAT, "from 1 to 21" },
    { "20200701-subject-01/20200709_100000/meta.yml", "num_frames: 2\nycb_ids: [2]\nycb_grasp_ind: 1\n", LT_EFORMAT,
      "from 0 to 0" },
    { "20200701-subject-01/20200709_100000/meta.yml",
      "num_frames: 2\nycb_ids: [2]\nycb_grasp_ind: 0\nmano_sides: [both]\n", LT_EFORMAT, "left or right" },
    { "20200701-subject-01/20200709_100000/meta.yml",
      "num_frames: 2\nycb_ids: [2]\nycb_grasp_ind: 0\nmano_sides: [left]\nextrinsics: ../../etc\n", LT_EFORMAT,
      "the name of a calibration" },
    { "20200701-subject-01/20200709_100000/meta.yml",
      "num_frames: 2\nycb_ids: [2]\nycb_grasp_ind: 0\nmano_sides: [left]\nextrinsics: a\nmano_calib: [/etc/x]\n",
      LT_EFORMAT, "the name of a calibration" },
    { "20200701-subject-01/20200709_100001/meta.yml",
      "num_frames: 2\nycb_ids: [2]\nycb_grasp_ind: 0\nmano_sides: [left]\nextrinsics: a\nmano_calib: [subject-01]\n"
      "serials: ['1']\n", LT_EFORMAT, "camera 0 is 1, in other sequences it is 836212060125" },
};

START_TEST(tree_is_broken)
{
    char command[256];

    small_tree();
    if (broken[_i].text) {
        text_file(broken[_i].path, broken[_i].text);
    } else {
        snprintf(command, sizeof(command), "rm -r %s/%s", scratch_folder, broken[_i].path);
        ck_assert_int_eq(system(command), 0);
    }
    open_fails("s0", "train", broken[_i].st, broken[_i].reason);
}
END_TEST

START_TEST(empty_split)
{
    small_tree();
    open_fails("s1", "val", LT_EINVAL, "has no samples: the dataset has 1 subjects of 5 sequences");
}
END_TEST

/* Subjects 3 and 10 of DexYCB's ten: the splits are of these, by the rules that all have, or there is none. */
static void two_subjects(void)
{
    calibration(10, 8);
    for (int q = 0; q < 100; q++) {
        meta(2, q, 8, 72, false);
        meta(9, q, 8, 72, false);
    }
}

START_TEST(some_subjects)
{
    dexycb_folders list;
    dataset *d;

    two_subjects();
    d = open_list("s0", "train");
    ck_assert_int_eq(d->count, 2 * 80 * 8 * 72);
    ck_assert_str_eq(d->title, "DexYCB s0 (part)");
    ck_assert_str_eq(d->partial, "split train of s0 is of subjects 3, 10 alone: there is no folder of 1, 2, 4, 5, 6, "
                     "7, 8, 9; what is scored is a part of the split, and result files count the samples of that part");
    ck_assert_ptr_eq(strstr(dataset_name(d, 0), "20200703-subject-03/20200709_100000/"), dataset_name(d, 0));
    dataset_free(d);
    d = open_list("s1", "train");
    ck_assert_int_eq(d->count, 100 * 8 * 72 * 2);
    dataset_free(d);
    open_fails("s0", "val", LT_EIO, ": split val of s0 is of subjects 1, 2, and no folder like ########-subject-01 is "
               "there");
    open_fails("s1", "test", LT_EIO, ": split test of s1 is of subjects 8, 9, and no folder");
    check_ok(dexycb_list_subjects(arena, scratch_folder, &list));
    ck_assert_int_eq(list.n, 2);
    ck_assert_int_eq(dexycb_subject_number(list.name[1]), 9);
    check_ok(dexycb_list_sequences(arena, scratch_folder, list.name[1], &list));
    ck_assert_int_eq(list.n, 100);
}
END_TEST

/* Of the generator's, the marker says how many there were; a whole split is not called a part. */
START_TEST(some_synthetic_subjects)
{
    dataset *d;

    small_tree();
    d = open_list("s0", "train");
    ck_assert_str_eq(d->title, "DexYCB s0");
    ck_assert_ptr_null(d->partial);
    dataset_free(d);
    text_file("synthetic.json", "{\"subjects\": 2, \"sequences\": 5}");
    d = open_list("s0", "train");
    ck_assert_int_eq(d->count, 24);
    ck_assert_ptr_nonnull(strstr(d->partial, "of subject 1 alone: there is no folder of 2;"));
    dataset_free(d);
}
END_TEST

/* A bad label passes the filter, and says what is wrong when it is read; the others keep their places. */
static void read_fails(int index, const char *reason)
{
    dataset *d = open_small(DEXYCB_VALID);
    dataset_sample s;

    ck_assert_int_eq(d->count, 18);
    check_ok(dataset_read(d, index + 1, SAMPLE_OBJECT | SAMPLE_DEPTH, arena, &s));
    ck_assert_int_ne(dataset_read(d, index, SAMPLE_OBJECT | SAMPLE_DEPTH, arena, &s), LT_OK);
    ck_assert_msg(strstr(lt_last_error(), reason), "\"%s\" lacks \"%s\"", lt_last_error(), reason);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "000002"));
    dataset_free(d);
}

START_TEST(sample_is_broken)
{
    label l;

    small_tree();
    pose_label(false, &l);
    pose_object(&l, 0);
    l.object[1][0][0] = 3;
    write_label(frame(0, "labels", 2, "npz"), &l);
    read_fails(2, "expected a rotation matrix");
    pose_object(&l, 0);
    l.joints[4][1] = NAN;
    write_label(frame(0, "labels", 2, "npz"), &l);
    read_fails(2, "joint_3d: number 13 is nan, expected less than 100");
    l.joints[4][1] = 110;                               /* millimetres */
    write_label(frame(0, "labels", 2, "npz"), &l);
    read_fails(2, "joint_3d: number 13 is 110, expected less than 100");
    text_file(frame(0, "labels", 2, "npz"), "PK");
    read_fails(2, "labels_000002.npz");
    ck_assert_int_eq(unlink(at(frame(0, "labels", 2, "npz"))), 0);
    read_fails(2, "labels_000002.npz");
}
END_TEST

START_TEST(pictures_are_broken)
{
    lt_image small;

    small_tree();
    check_ok(lt_image_init(arena, 320, 240, 3, 8, &small));
    check_ok(lt_png_write(at(frame(0, "aligned_depth_to_color", 2, "png")), &small));
    read_fails(2, "image of 320 x 240, expected 640 x 480");
    check_ok(lt_image_init(arena, W, H, 1, 8, &small));
    check_ok(lt_png_write(at(frame(0, "aligned_depth_to_color", 2, "png")), &small));
    read_fails(2, "1 channels of 8 bits, expected one of 16");
    text_file(frame(0, "color", 2, "jpg"), "");
    read_fails(2, "color_000002.jpg");
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_set_timeout(c, 0);
    tcase_add_checked_fixture(c, setup, close_scratch);
    tcase_add_test(c, official_lists);
    tcase_add_test(c, order_of_the_list);
    tcase_add_test(c, right_hand);
    tcase_add_test(c, other_endings);
    tcase_add_test(c, left_hand);
    tcase_add_loop_test(c, segments, 0, 2);
    tcase_add_test(c, segments_are_broken);
    tcase_add_test(c, left_model);
    tcase_add_test(c, tips_of_the_toolkit);
    tcase_add_test(c, hpe_file);
    tcase_add_test(c, bop_file);
    tcase_add_test(c, bop_grasped);
    tcase_add_test(c, bop_all);
    tcase_add_test(c, bop_models_info);
    tcase_add_test(c, bop_bad_table);
    tcase_add_test(c, coco_file);
    tcase_add_test(c, filters);
    tcase_add_test(c, hfl_test_box);
    tcase_add_test(c, no_such_split);
    tcase_add_loop_test(c, tree_is_broken, 0, LT_COUNT(broken));
    tcase_add_test(c, empty_split);
    tcase_add_test(c, some_subjects);
    tcase_add_test(c, some_synthetic_subjects);
    tcase_add_test(c, sample_is_broken);
    tcase_add_test(c, pictures_are_broken);
}

int main(void)
{
    return run_suite("dexycb", add_tests);
}
