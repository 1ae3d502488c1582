/* SPDX-License-Identifier: Apache-2.0 */
/* Initial poses: every format says the same poses in its own way; and what is refused. */
#include "assets/hand/hand.h"
#include "data/hand_pose.h"
#include "data/poses/initial_poses.h"
#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/file.h"
#include "tests/scratch.h"

#include <math.h>
#include <stdarg.h>

enum { FRAMES = 20 };

/* ---- a dataset without files: names as HO3D has them, or DexYCB ---------------------------------------------- */

static lt_hand_model *hand;
static bool of_dexycb;

static const char *name_of(const dataset *d, int64_t index)
{
    (void)d;
    return of_dexycb ? lt_arena_printf(arena, "20200709-subject-01/20200709_141754/836212060125/%06d", (int)index)
                     : lt_arena_printf(arena, "ABF12/%04d", (int)index);
}

/* The wrist of frame i; its hand is flat, its object 5 cm to the right. */
static void wrist_of(int64_t i, double out[3])
{
    out[0] = 0.01 * (double)i;
    out[1] = -0.02;
    out[2] = 0.6;
}

static lt_status annotation(const dataset *d, int64_t index, lt_arena *memory, dataset_sample *s)
{
    double w[3];

    (void)memory;
    *s = (dataset_sample){ .name = name_of(d, index), .object = 1,
                           .flags = SAMPLE_HAND_POSE | SAMPLE_ROOT | SAMPLE_OBJECT | SAMPLE_JOINTS };
    wrist_of(index, w);
    for (int k = 0; k < 3; k++) {
        s->root[k] = (float)w[k];
        s->t[k] = (float)w[k] + 0.05f * (k == 0);
        s->R[4 * k] = 1;
    }
    for (int j = 0; j < LT_HAND_JOINTS; j++)
        s->rotation[j][0] = s->rotation[j][4] = s->rotation[j][8] = 1;
    return LT_OK;
}

static const dataset_object objects[2] = { { .name = "006_mustard_bottle", .ycb_id = 5 },
                                           { .name = "021_bleach_cleanser", .ycb_id = 12 } };
static const dataset_ops ops = { .annotation = annotation, .name = name_of };
static const dataset frames = { .ops = &ops, .root = "made up", .split = "train", .count = FRAMES, .objects = objects,
                                .n_objects = 2 };

static void setup(void)
{
    open_scratch();
    of_dexycb = false;
    check_ok(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand));
}

/* ---- files ----------------------------------------------------------------------------------------------- */

typedef struct { FILE *f; const char *path; } growing;

static growing begin(const char *path)
{
    const growing g = { fopen(at(path), "w"), at(path) };

    ck_assert_ptr_nonnull(g.f);
    return g;
}

static const char *end(growing *g)
{
    fclose(g->f);
    return g->path;
}

static void print(growing *g, const char *key, const double *x, int n)
{
    fprintf(g->f, "\"%s\": [", key);
    for (int i = 0; i < n; i++)
        fprintf(g->f, "%s%.17g", i ? ", " : "", x[i]);
    fprintf(g->f, "]");
}

static void add(growing *g, const char *fmt, ...)
{
    va_list args;

    va_start(args, fmt);
    vfprintf(g->f, fmt, args);
    va_end(args);
}

/* What all formats below say of frame i. */
typedef struct { double pose[48], beta[10], trans[3], wrist[3], R[9], t[3]; } truth;

static truth truth_of(int i)
{
    truth p;
    double J0[3];
    const double turn[3] = { 0.1, -0.2, 0.3 + 0.01 * i };

    for (int k = 0; k < 48; k++)
        p.pose[k] = 0.3 * sin(k + 1 + 0.1 * i);
    for (int k = 0; k < 10; k++)
        p.beta[k] = 0.4 * cos(k + i);
    lt_hand_rest_wrist(hand, p.beta, J0);
    wrist_of(i, p.wrist);
    lt_rot_from_axis_angle(turn, p.R);
    for (int k = 0; k < 3; k++) {
        p.trans[k] = p.wrist[k] - J0[k];
        p.t[k] = p.wrist[k] + 0.05 + 0.001 * k;
    }
    return p;
}

static lt_status read_for(const char *path, const char *list, initial_poses **out)
{
    const initial_poses_options o = { .path = path, .list = list, .data = &frames, .hand = hand, .seed = 3 };

    return initial_poses_read(&o, out);
}

static void near(const double *got, const double *want, int n, double tolerance)
{
    for (int i = 0; i < n; i++)
        ck_assert_double_eq_tol(got[i], want[i], tolerance);
}

/* Rotations alone are compared: an axis-angle has a twin beyond pi. */
static void same_pose(const initial_pose *p, const truth *want, double tolerance)
{
    double a[9], b[9];

    ck_assert_ptr_nonnull(p);
    ck_assert(p->has_hand && p->has_object);
    for (int j = 0; j < LT_HAND_JOINTS; j++) {
        lt_rot_from_axis_angle(p->pose + 3 * j, a);
        lt_rot_from_axis_angle(want->pose + 3 * j, b);
        near(a, b, 9, tolerance);
    }
    near(p->beta, want->beta, 10, tolerance);
    near(p->trans, want->trans, 3, tolerance);
    near(p->wrist, want->wrist, 3, tolerance);
    near(p->R, want->R, 9, tolerance);
    near(p->t, want->t, 3, tolerance);
    ck_assert_int_eq(p->object, 1);
}

static void all_same(const char *path, const char *list, const char *how, double tolerance)
{
    initial_poses *p;

    check_ok(read_for(path, list, &p));
    for (int i = 0; i < FRAMES; i++) {
        const truth want = truth_of(i);
        same_pose(initial_poses_at(p, i), &want, tolerance);
    }
    ck_assert_ptr_null(initial_poses_at(p, -1));
    ck_assert_ptr_null(initial_poses_at(p, FRAMES));
    ck_assert_int_eq(initial_poses_count(p).matched, FRAMES);
    ck_assert_str_eq(initial_poses_how(p), how);
    initial_poses_free(p);
}

/* ---- palmar.poses/1 in all its conventions --------------------------------------------------------------- */

typedef struct { bool opengl, mm, pca, mean, late; const char *rotation; } form;

static const form forms[] = {
    { .rotation = NULL }, { .rotation = "axis-angle", .late = true }, { .rotation = "matrix", .opengl = true },
    { .rotation = "quaternion-xyzw", .mm = true }, { .rotation = "quaternion-wxyz", .pca = true },
    { .rotation = "matrix", .pca = true, .mean = true, .opengl = true, .mm = true }, { .rotation = NULL, .mean = true },
};

static void print_rotation(growing *g, const double R[9], const char *rotation)
{
    double aa[3], q[5];

    if (rotation && strcmp(rotation, "matrix") == 0) {
        print(g, "R", R, 9);
        return;
    }
    if (rotation && *rotation == 'q') {
        lt_rot_to_quat(R, q);
        q[4] = q[0];
        print(g, "R", strcmp(rotation, "quaternion-xyzw") == 0 ? q + 1 : q, 4);
        return;
    }
    lt_rot_to_axis_angle(R, aa);
    print(g, "R", aa, 3);
}

/* The inverse of what the reader does: components are orthonormal rows. */
static void print_pose(growing *g, const double pose[48], const form *f)
{
    double x[48];

    memcpy(x, pose, sizeof(x));
    for (int i = 0; i < 45 && f->mean; i++)
        x[3 + i] -= hand->hands_mean[i];
    if (f->pca) {
        double c[45] = { 0 };
        for (int k = 0; k < 45; k++)
            for (int i = 0; i < 45; i++)
                c[k] += hand->hands_components[k][i] * x[3 + i];
        memcpy(x + 3, c, sizeof(c));
    }
    print(g, "pose", x, 48);
}

static void print_frame(growing *g, const char *name, truth p, const form *f)
{
    const double unit = f->mm ? 1000 : 1;
    double J0[3];

    if (f->opengl) {
        lt_hand_rest_wrist(hand, p.beta, J0);
        lt_flip_yz_mano(p.pose, p.trans, J0);           /* F is its own inverse */
        lt_flip_yz_pose(p.R, p.t);
    }
    for (int k = 0; k < 3; k++) {
        p.trans[k] *= unit;
        p.t[k] *= unit;
    }
    add(g, "\"%s\": {\"hand\": {\"side\": \"right\", ", name);
    print_pose(g, p.pose, f);
    add(g, ", ");
    print(g, "shape", p.beta, 10);
    add(g, ", ");
    print(g, "trans", p.trans, 3);
    add(g, "}, \"object\": {\"id\": 12, ");
    print_rotation(g, p.R, f->rotation);
    add(g, ", ");
    print(g, "t", p.t, 3);
    add(g, "}, \"score\": 0.9}");
}

static const char *poses_file(const form *f)
{
    growing g = begin("poses.json");
    const char *header = lt_arena_printf(arena, "\"format\": \"palmar.poses/1\"%s%s%s%s",
                                         f->opengl ? ", \"axes\": \"opengl\"" : "", f->mm ? ", \"unit\": \"mm\"" : "",
                                         f->pca ? ", \"hand_pose\": \"pca45\"" : "",
                                         f->mean ? ", \"flat_hand_mean\": false" : "");

    if (f->rotation)
        header = lt_arena_printf(arena, "%s, \"rotation\": \"%s\"", header, f->rotation);
    add(&g, "\xef\xbb\xbf{%s%s\"frames\": {\n", f->late ? "" : header, f->late ? "" : ", ");
    for (int i = 0; i < FRAMES; i++) {
        print_frame(&g, i == 3 ? "ABF12\\/0003" : name_of(&frames, i), truth_of(i), f);
        add(&g, i + 1 < FRAMES ? ",\n" : "\n");
    }
    add(&g, "}%s%s}\n", f->late ? ", " : "", f->late ? header : "");
    return end(&g);
}

START_TEST(palmar_poses)
{
    all_same(poses_file(&forms[_i]), NULL, "palmar.poses/1 (poses.json)", 2e-6);
}
END_TEST

/* As labels are posed: with the wrist where it is. */
START_TEST(poses_a_hand)
{
    double vertices[LT_HAND_VERTICES][3], want[LT_HAND_VERTICES][3], R[LT_HAND_JOINTS * 9];
    float rotation[LT_HAND_JOINTS][9], beta[10], root[3];
    const truth t = truth_of(4);
    initial_poses *p;

    check_ok(read_for(poses_file(&forms[0]), NULL, &p));
    initial_pose_rotations(initial_poses_at(p, 4), rotation);
    for (int i = 0; i < 10; i++)
        beta[i] = (float)initial_poses_at(p, 4)->beta[i];
    for (int k = 0; k < 3; k++)
        root[k] = (float)initial_poses_at(p, 4)->wrist[k];
    hand_pose_at(hand, rotation[0], beta, root, vertices);
    for (int j = 0; j < LT_HAND_JOINTS; j++)
        lt_rot_from_axis_angle(t.pose + 3 * j, R + 9 * j);
    lt_hand_pose(hand, R, t.beta, t.trans, want[0], NULL);
    near(vertices[0], want[0], 3 * LT_HAND_VERTICES, 1e-6);
    initial_poses_free(p);
}
END_TEST

/* ---- other formats --------------------------------------------------------------------------------------- */

static void print_predicted_hand(growing *g, const char *side, const truth *p, double agreement, bool trusted)
{
    add(g, "{\"side\": \"%s\", \"position\": \"solved\", \"trusted\": %s, \"agreement_px\": %g, ", side,
        trusted ? "true" : "false", agreement);
    add(g, "\"joints3d_m\": [[%.17g, %.17g, %.17g], [0, 0, 0]], ", p->wrist[0], p->wrist[1], p->wrist[2]);
    print(g, "theta_rad", p->pose, 48);
    add(g, ", ");
    print(g, "beta", p->beta, 10);
    add(g, "}");
}

static void print_predicted_object(growing *g, const truth *p, double confidence, bool found)
{
    add(g, "{\"name\": \"021_bleach_cleanser\", \"found\": %s, \"confidence\": %g, \"trusted\": true, ",
        found ? "true" : "false", confidence);
    print(g, "R", p->R, 9);
    add(g, ", ");
    print(g, "t_m", p->t, 3);
    add(g, "}");
}

/* Of several hands and objects the best; a record of nothing at all. */
START_TEST(predicted_frames)
{
    growing g = begin("out.ndjson");
    initial_poses *p;

    for (int i = 0; i < FRAMES; i++) {
        const truth t = truth_of(i), other = truth_of(i + 1);
        add(&g, "%s{\"schema\": \"palmar.frame/1\", \"image\": \"/HO3D_v3/train/ABF12/rgb/%04d.jpg\", \"hands\": [",
            i == 5 ? "\r\n" : "", i);
        print_predicted_hand(&g, "left", &other, 30, false);
        add(&g, ", ");
        print_predicted_hand(&g, "right", &t, 3, true);
        add(&g, "], \"objects\": [");
        print_predicted_object(&g, &other, 9, false);
        add(&g, ", ");
        print_predicted_object(&g, &t, 0.5, true);
        add(&g, ", ");
        print_predicted_object(&g, &other, 0.4, true);
        add(&g, "], \"notes\": []}\n");
    }
    all_same(end(&g), NULL, "palmar.frame/1 (out.ndjson)", 1e-9);
    g = begin("out.ndjson");
    add(&g, "{\"schema\": \"palmar.frame/1\", \"image\": \"rgb/ABF12/0001.png\", \"hands\": [], \"objects\": []}");
    check_ok(read_for(end(&g), NULL, &p));
    ck_assert(!initial_poses_at(p, 1)->has_hand && !initial_poses_at(p, 1)->has_object);
    ck_assert_ptr_null(initial_poses_at(p, 0));
    ck_assert_int_eq(initial_poses_count(p).missed, FRAMES - 1);
    initial_poses_free(p);
}
END_TEST

/* NumPy's (1, 3) is a list in a list. */
static void print_hoisdf(growing *g, const char *key, const truth *p)
{
    const double centre[3] = { 0.01, 0.02, 0.3 };
    double aa[3], rest[3];

    lt_rot_to_axis_angle(p->R, aa);
    for (int k = 0; k < 3; k++)
        rest[k] = p->t[k] - centre[k];
    add(g, "\"%s\": {", key);
    print(g, "mano_pose6d", p->pose, 48);
    add(g, ", ");
    print(g, "mano_shape", p->beta, 10);
    add(g, ", ");
    print(g, "obj_rot", aa, 3);
    add(g, ", \"obj_trans\": [[%.17g, %.17g, %.17g]], ", rest[0], rest[1], rest[2]);
    print(g, "obj_center_cam", centre, 3);
    add(g, "}");
}

static const char *hoisdf_file(bool by_path)
{
    growing g = begin("pred_ho_pose.json");

    add(&g, "{");
    for (int i = 0; i < FRAMES; i++) {
        const truth t = truth_of(i);
        const char *key = by_path ? lt_arena_printf(arena, "/mnt/HO3D_v3/train/ABF12/rgb/%04d.jpg", i)
                                  : lt_arena_printf(arena, "cut%d", 100 + i);
        add(&g, i ? ", " : "");
        print_hoisdf(&g, key, &t);
    }
    add(&g, "}");
    return end(&g);
}

START_TEST(hoisdf_of_ho3d)
{
    all_same(hoisdf_file(true), NULL, "HOISDF (pred_ho_pose.json), wrists from the annotation", 1e-7);
}
END_TEST

START_TEST(hoisdf_of_dexycb)
{
    const char *path = hoisdf_file(false), *list;
    growing g = begin("list.json");
    initial_poses *p;

    of_dexycb = true;
    add(&g, "{\"cut99\": {\"label_file\": \"nowhere/labels_000000.npz\"}");
    for (int i = 0; i < FRAMES; i++)
        add(&g, ", \"cut%d\": {\"color_file\": \"x\", \"label_file\": \"20200709-subject-01/20200709_141754/"
            "836212060125/labels_%06d.npz\"}", 100 + i, i);
    add(&g, "}");
    list = end(&g);
    all_same(path, list, "HOISDF (pred_ho_pose.json), wrists from the annotation", 1e-7);
    check_error(read_for(path, NULL, &p), LT_EFORMAT, "pred_ho_pose.json, \"cut100\": is no path of an image, and no "
                "annotation list was named; want the annotation list that HOISDF was run on");
    of_dexycb = false;
}
END_TEST

/* ---- the truth ------------------------------------------------------------------------------------------- */

START_TEST(the_truth)
{
    initial_poses *p;

    check_ok(read_for("truth", NULL, &p));
    for (int i = 0; i < FRAMES; i++) {
        const initial_pose *q = initial_poses_at(p, i);
        dataset_sample s;
        float rotation[LT_HAND_JOINTS][9];
        double J0[3];

        check_ok(annotation(&frames, i, arena, &s));
        initial_pose_rotations(q, rotation);
        for (int k = 0; k < 9 * LT_HAND_JOINTS; k++)
            ck_assert_float_eq_tol(rotation[k / 9][k % 9], s.rotation[k / 9][k % 9], 1e-6f);
        lt_hand_rest_wrist(hand, q->beta, J0);
        for (int k = 0; k < 3; k++) {
            ck_assert_double_eq(q->wrist[k], s.root[k]);
            ck_assert_double_eq_tol(q->trans[k] + J0[k], s.root[k], 1e-12);
            ck_assert_double_eq(q->t[k], s.t[k]);
        }
        ck_assert_int_eq(q->object, 1);
    }
    ck_assert_str_eq(initial_poses_how(p), "the truth");
    initial_poses_free(p);
}
END_TEST

/* Noise turns and moves the object, and turns the hand about a wrist that stays; the same seed gives the same. */
START_TEST(noise_on_the_truth)
{
    static const char *const paths[] = { "truth+independent", "truth+correlated" };
    initial_poses *p, *again;
    double shift[3] = { 0 }, spread = 0;

    check_ok(read_for(paths[_i], NULL, &p));
    check_ok(read_for(paths[_i], NULL, &again));
    for (int i = 0; i < FRAMES; i++) {
        const initial_pose *q = initial_poses_at(p, i);
        double wrist[3], flat = 0, moved[3];

        wrist_of(i, wrist);
        near(q->wrist, wrist, 3, 1e-7);
        ck_assert_mem_eq(q->pose, initial_poses_at(again, i)->pose, sizeof(q->pose));
        ck_assert_mem_eq(q->R, initial_poses_at(again, i)->R, sizeof(q->R));
        ck_assert_mem_eq(q->t, initial_poses_at(again, i)->t, sizeof(q->t));
        for (int k = 0; k < 48; k++)
            flat += fabs(q->pose[k]);
        ck_assert_double_gt(flat, 0.5);
        for (int k = 0; k < 3; k++)
            moved[k] = q->t[k] - wrist[k] - 0.05 * (k == 0);
        ck_assert_double_gt(fabs(moved[0]) + fabs(moved[1]) + fabs(moved[2]), 1e-4);
        if (i)
            for (int k = 0; k < 3; k++)
                spread = fmax(spread, fabs(moved[k] - shift[k]));
        else
            memcpy(shift, moved, sizeof(shift));
    }
    ck_assert(_i == 0 ? spread > 0.01 : spread < 0.01);         /* a tenth of 14.4 mm, or of 8.6 */
    initial_poses_free(p);
    initial_poses_free(again);
    check_error(read_for("truth+some", NULL, &p), LT_EINVAL, "truth+some: no such truth; want truth, "
                "truth+independent or truth+correlated");
}
END_TEST

/* ---- what is refused ------------------------------------------------------------------------------------- */

static const char *text_file(const char *text)
{
    growing g = begin("poses.json");

    add(&g, "%s", text);
    return end(&g);
}

#define HEAD "{\"format\": \"palmar.poses/1\", "
#define ONE(frame) HEAD "\"frames\": {\"ABF12/0000\": " frame "}}"
#define TEN "[0,0,0,0,0,0,0,0,0,0]"
#define POSE "[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0]"
#define HAND(side, trans) \
    "\"hand\": {\"side\": \"" side "\", \"pose\": " POSE ", \"shape\": " TEN ", \"trans\": " trans "}"
#define OBJECT(R, t) "\"object\": {\"id\": 5, \"R\": " R ", \"t\": " t "}"

static const struct { const char *text, *line; } wrong[] = {
    { "", "poses.json: ends early, want {, the beginning of an object" },
    { "[]", "poses.json:1: byte 0 is 0x5b, want {, the beginning of an object" },
    { "{}", "poses.json: nothing says what it is, want initial poses: \"format\": \"palmar.poses/1\", what `palmar "
      "predict --json` prints, or HOISDF's pred_ho_pose.json" },
    { "{\"format\": \"palmar.poses/2\"}", "poses.json: format is \"palmar.poses/2\", want initial poses" },
    { HEAD "\"unit\": \"cm\", \"frames\": {}}", "poses.json: unit: want one of \"m\", \"mm\"" },
    { HEAD "\"axis\": \"opengl\", \"frames\": {}}", "poses.json: no such key \"axis\"; did you mean \"axes\"?" },
    { HEAD "\"flat_hand_mean\": 1, \"frames\": {}}", "poses.json: flat_hand_mean: want true or false" },
    { HEAD "\"unit\": \"m\"}", "poses.json: no key \"frames\"" },
    { HEAD "\"frames\": []}", "poses.json:1: byte 0 is 0x5b, want {, the beginning of an object" },
    { HEAD "\"frames\": {}", "poses.json: ends early, want a comma or }" },
    { HEAD "\"frames\": {}} x", "byte 43 is 0x78, want the end of the file" },
    { HEAD "\"frames\": {}}", "poses.json: no pose is of a frame of made up, split train" },
    { ONE("[]"), "poses.json, \"ABF12/0000\": want an object of hand and object" },
    { ONE("{" HAND("left", "[0,0,1]") "}"),
      "\"ABF12/0000\": hand.side is not \"right\": initial poses are of right hands" },
    { ONE("{\"hand\": {\"pose\": [0,0,0]}}"), "\"ABF12/0000\": hand.pose has 3 numbers, want 48" },
    { ONE("{\"hand\": {}}"), "\"ABF12/0000\": hand.pose is missing, want 48 numbers" },
    { ONE("{" HAND("right", "[0,0,\"1\"]") "}"), "hand.trans: want 3 numbers below 10000, and nothing else" },
    { ONE("{" HAND("right", "[0,0,NaN]") "}"), "hand.trans: want 3 numbers below 10000, and nothing else" },
    { ONE("{" OBJECT("[0,0,0,1]", "[0,0,1]") "}"), "object.R has 4 numbers, want 3" },
    { ONE("{\"object\": {\"id\": 1.5}}"), "object.id: want a whole number" },
    { ONE("{\"object\": {\"id\": 7, \"R\": [0,0,0], \"t\": [0,0,1]}}"),
      "\"ABF12/0000\": object.id is 7, 008_pudding_box, which is none of made up's" },
    { ONE("{\"object\": {\"id\": 77, \"R\": [0,0,0], \"t\": [0,0,1]}}"), "object.id is 77, no YCB object, which" },
    { HEAD "\"rotation\": \"matrix\", \"frames\": {\"ABF12/0000\": {" OBJECT("[1,0,0,0,1,0,0,0,-1]", "[0,0,1]") "}}}",
      "object.R has the determinant -1, want 1: a mirror image is no rotation" },
    { HEAD "\"rotation\": \"matrix\", \"frames\": {\"ABF12/0000\": {" OBJECT("[1,0.1,0,0,1,0,0,0,1]", "[0,0,1]") "}}}",
      "object.R is no rotation to 0.01" },
    { HEAD "\"rotation\": \"quaternion-wxyz\", \"frames\": {\"ABF12/0000\": {" OBJECT("[2,0,0,0]", "[0,0,1]") "}}}",
      "object.R, a quaternion, has the length 2, want 1" },
    { HEAD "\"frames\": {\"ABF12/0000\": {}, \"train/ABF12/rgb/0000.jpg\": {}}}",
      "train/ABF12/rgb/0000.jpg: the frame has a pose already; want one for each frame" },
    { HEAD "\"frames\": {\"ABF12/0000\": {}, \"ABF13/0000\": {}}}",
      "poses.json: 1 of 2 frames are unknown to made up, \"ABF13/0000\" first; want names like \"ABF12/0000\"" },
    { ONE("{" OBJECT("[0,0,0]", "[0,0,600]") "," HAND("right", "[0,0,640]") "}"),
      "hand and object are more than 0.5 m apart in 1 of 1 frames; they look as if they were in millimetres: "
      "\"unit\": \"mm\"" },
    { ONE("{" OBJECT("[0,0,0]", "[0,0,-0.6]") "," HAND("right", "[0,0,-0.6]") "}"),
      "2 of 2 hands and objects are not in front of the camera (z > 0.05 m); they look as if they had OpenGL's axes: "
      "\"axes\": \"opengl\"" },
    { ONE("{" OBJECT("[0,0,0]", "[0,0,0.6]") "," HAND("right", "[0,0,0]") "}"),
      "1 of 2 hands and objects are not in front of the camera (z > 0.05 m); hand.trans looks as if it were counted "
      "from the wrist, want the camera's frame" },
    { ONE("{" OBJECT("[0,0,0]", "[0.05,0,0]") "," HAND("right", "[0,0,0.6]") "}"),
      "object.t looks as if it were counted from the wrist, want the camera's frame" },
    { ONE("{" OBJECT("[0,0,0]", "[0,1,1]") "," HAND("right", "[0,0,1]") "}"),
      "apart in 1 of 1 frames; want metres in the camera's frame, x right, y down, z forward" },
    { "{\"schema\": \"palmar.frame/1\", \"image\": \"ABF12/0000\"}\n{\"schema\": \"palmar.frame/1\"}\n",
      "poses.json:2: want \"schema\": \"palmar.frame/1\" and an \"image\"" },
    { "{\"schema\": \"palmar.frame/1\", \"image\": \"ABF12/0000\", \"hands\": [{\"side\": \"left\"}]}",
      "poses.json:1: the best of hands is not \"right\": initial poses are of right hands alone" },
    { "{\"a/rgb/0.jpg\": {\"mano_pose6d\": 1}}", "poses.json, \"a/rgb/0.jpg\": mano_pose6d has 1 numbers, want 48" },
};

START_TEST(refused)
{
    initial_poses *p;
    const char *path = text_file(wrong[_i].text);

    ck_assert_int_ne(read_for(path, NULL, &p), LT_OK);
    ck_assert_msg(strstr(lt_last_error(), wrong[_i].line), "\"%s\" lacks \"%s\"", lt_last_error(), wrong[_i].line);
    ck_assert_ptr_null(strchr(lt_last_error(), '\n'));
}
END_TEST

/* A frame or two in a hundred may be wrong, and names of the other split are not unknown. */
START_TEST(some_may_be_wrong)
{
    dataset many = frames, other = frames;
    initial_poses_options o = { .data = &many, .hand = hand };
    growing g = begin("poses.json");
    initial_poses *p;

    many.count = 40;
    other.count = 100;
    add(&g, HEAD "\"frames\": {");
    for (int i = 0; i < 80; i++)
        add(&g, "%s\"ABF12/%04d\": {\"object\": {\"R\": [0,0,0], \"t\": [0,0,%g]}}", i ? ", " : "", i,
            i == 7 ? -1 : 0.6);
    add(&g, "}}");
    o.path = end(&g);
    check_error(initial_poses_read(&o, &p), LT_EFORMAT, "40 of 80 frames are unknown to made up, \"ABF12/0040\" first");
    o.other = &other;
    check_ok(initial_poses_read(&o, &p));
    ck_assert_int_eq(initial_poses_count(p).matched, 40);
    ck_assert_int_eq(initial_poses_count(p).other, 40);
    ck_assert_int_eq(initial_poses_count(p).unknown, 0);
    ck_assert_int_eq(initial_poses_at(p, 7)->object, -1);
    ck_assert_double_eq(initial_poses_at(p, 7)->t[2], -1);
    initial_poses_free(p);
}
END_TEST

/* Cut anywhere, it is refused with a line, and nothing is left. */
START_TEST(cut_short)
{
    initial_poses *p;
    uint8_t *bytes;
    size_t n;

    check_ok(lt_read_file(arena, poses_file(&forms[5]), LT_FILE_MAX, &bytes, &n));
    for (size_t cut = 0; cut + 2 < n; cut += cut < 3000 ? 7 : 997) {
        FILE *f = fopen(at("cut.json"), "w");
        fwrite(bytes, 1, cut, f);
        fclose(f);
        ck_assert_int_eq(read_for(at("cut.json"), NULL, &p), LT_EFORMAT);
    }
    check_error(read_for(at("none.json"), NULL, &p), LT_EIO, "none.json: No such file");
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_unchecked_fixture(c, setup, close_scratch);            /* one hand for all */
    tcase_set_timeout(c, 0);
    tcase_add_loop_test(c, palmar_poses, 0, LT_COUNT(forms));
    tcase_add_test(c, poses_a_hand);
    tcase_add_test(c, predicted_frames);
    tcase_add_test(c, hoisdf_of_ho3d);
    tcase_add_test(c, hoisdf_of_dexycb);
    tcase_add_test(c, the_truth);
    tcase_add_loop_test(c, noise_on_the_truth, 0, 2);
    tcase_add_loop_test(c, refused, 0, LT_COUNT(wrong));
    tcase_add_test(c, some_may_be_wrong);
    tcase_add_test(c, cut_short);
}

int main(void)
{
    return run_suite("initial_poses", add_tests);
}
