/* SPDX-License-Identifier: Apache-2.0 */
/* The HO3D reader on small trees made here: orders, axes, both versions, and every way a tree is broken. */
#include "data/ho3d/ho3d.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "libtensor/io/mesh/obj.h"
#include "libtensor/io/pickle/pickle.h"
#include "tests/scratch.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { W = 640, H = 480 };

/* ---- a tree ---- */

static void text_file(const char *path, const char *text)
{
    check_ok(lt_write_file(at(path), text, strlen(text)));
}

static void picture(const char *path, bool jpg, int width, int height)
{
    lt_image img;

    check_ok(lt_image_init(arena, width, height, 3, 8, &img));
    for (size_t i = 0; i < lt_image_bytes(&img); i++)
        img.data[i] = (uint8_t)(i / 3 % 251);
    check_ok(jpg ? lt_jpeg_write(at(path), &img, 95) : lt_png_write(at(path), &img));
}

static void depth_picture(const char *path)
{
    lt_image img;

    check_ok(lt_image_init(arena, W, H, 3, 8, &img));
    img.data[0] = 0x10;
    img.data[1] = 0x27;
    check_ok(lt_png_write(at(path), &img));
}

/* The annotation. Joint i of the file's order lies i mm to the right of the wrist. */
static const float K[9] = { 614.627f, 0, 320.262f, 0, 614.101f, 238.469f, 0, 0, 1 };
static const float obj_rot[3] = { 0.1f, -0.2f, 0.3f }, obj_trans[3] = { 0.02f, 0.01f, -0.5f };
static float pose[48] = { 0.1f, -0.2f, 0.3f, 0.1f, 0, 0 }, beta[10] = { 0.5f, -1 };
static const float trans[3] = { 0.02f, -0.03f, -0.6f };
static float joints[21][3];
static const float wrist[3] = { 0.05f, -0.02f, -0.6f };
static const lt_pwrite corner[4] = {
    { .kind = LT_PW_FLOAT, .number = 300.5 }, { .kind = LT_PW_INT, .integer = 200 },
    { .kind = LT_PW_FLOAT, .number = 400 }, { .kind = LT_PW_FLOAT, .number = 310 },
};

static lt_pwrite array_of(const char *key, const float *data, int rows, int columns)
{
    const int64_t shape[2] = { rows, columns };

    return (lt_pwrite){ .key = key, .kind = LT_PW_ARRAY,
                        .array = lt_array_make(LT_ELEM_F4, columns ? 2 : 1, shape, data) };
}

enum { KEYS = 9 };

static void set_items(lt_pwrite item[KEYS], bool evaluation)
{
    for (int i = 0; i < 21; i++)
        for (int k = 0; k < 3; k++)
            joints[i][k] = wrist[k] + (k == 0 ? 0.001f * (float)i : 0);
    item[0] = array_of("camMat", K, 3, 3);
    item[1] = (lt_pwrite){ .key = "objName", .kind = LT_PW_STR, .text = "006_mustard_bottle" };
    item[2] = array_of("objRot", obj_rot, 3, 1);
    item[3] = array_of("objTrans", obj_trans, 3, 0);
    item[4] = array_of("handPose", pose, 48, 0);
    item[5] = array_of("handBeta", beta, 10, 0);
    item[6] = array_of("handTrans", trans, 3, 0);
    item[7] = evaluation ? array_of("handJoints3D", joints[0], 3, 0)
                         : array_of("handJoints3D", joints[0], 21, 3);
    item[8] = (lt_pwrite){ .key = "handBoundingBox", .kind = LT_PW_LIST, .item = corner, .n_items = 4 };
}

/* Write the meta file; change, when not NULL, takes the place of the item with its key. */
static void meta(const char *path, bool evaluation, const lt_pwrite *change)
{
    lt_pwrite item[KEYS];

    set_items(item, evaluation);
    for (int i = 0; change && i < KEYS; i++)
        if (!strcmp(item[i].key, change->key))
            item[i] = *change;
    check_ok(lt_pickle_write_dict(at(path), item, KEYS));
}

/* Its mesh and its points, each in a unit of its own. */
static void model_in(const char *name, float unit, float points_unit)
{
    const float u = unit, p = points_unit;
    float vertex[4][3] = { { 0, 0, 0 }, { .04f * u, 0, 0 }, { 0, .06f * u, 0 }, { 0, 0, .1f * u } };
    float point[4][3] = { { 0, 0, 0 }, { .04f * p, 0, 0 }, { 0, .06f * p, 0 }, { 0, 0, .1f * p } };
    int32_t face[4][3] = { { 0, 2, 1 }, { 0, 1, 3 }, { 0, 3, 2 }, { 1, 2, 3 } };
    const lt_mesh mesh = { .n_vertices = 4, .n_faces = 4, .vertex = vertex, .face = face };

    check_ok(lt_make_dirs(at(lt_arena_printf(arena, "models/%s", name))));
    check_ok(lt_obj_write(at(lt_arena_printf(arena, "models/%s/textured_simple.obj", name)), &mesh, NULL));
    check_ok(lt_xyz_write(at(lt_arena_printf(arena, "models/%s/points.xyz", name)), (const float (*)[3])point, 4));
}

static void model(const char *name)
{
    model_in(name, 1, 1);
}

static void make_split(const char *split, bool jpg)
{
    static const char *const folder[] = { "rgb", "depth", "meta" };

    for (int i = 0; i < 3; i++)
        check_ok(lt_make_dirs(lt_arena_printf(arena, "%s/%s/ABF10/%s", scratch_folder, split, folder[i])));
    picture(lt_arena_printf(arena, "%s/ABF10/rgb/0123.%s", split, jpg ? "jpg" : "png"), jpg, W, H);
    depth_picture(lt_arena_printf(arena, "%s/ABF10/depth/0123.png", split));
    meta(lt_arena_printf(arena, "%s/ABF10/meta/0123.pkl", split), !strcmp(split, "evaluation"), NULL);
    text_file(lt_arena_printf(arena, "%s.txt", split), "ABF10/0123\n");
}

static void setup(void)
{
    open_scratch();
    model("006_mustard_bottle");
    make_split("train", true);
    make_split("evaluation", false);
}

static dataset *open_split(const char *split)
{
    const ho3d_options o = { .root = scratch_folder, .split = split, .vertices = true };
    dataset *d = NULL;

    check_ok(ho3d_open(&o, &d));
    return d;
}

static void near(const float *got, const double *want, int n, double tolerance)
{
    for (int i = 0; i < n; i++)
        ck_assert_double_eq_tol(got[i], want[i], tolerance);
}

/* ---- what is read ---- */

START_TEST(train_sample)
{
    const double first[2] = { 371.480917, 258.939033 };         /* the projection of the wrist */
    const double aa[3] = { -2.992752, 0.454224, 0.302816 };     /* F times the rotation of (.1, -.2, .3) */
    const double t[3] = { 0.02, -0.01, 0.5 };
    dataset *d = open_split("train");
    dataset_sample s;
    double R[9];

    ck_assert_str_eq(d->title, "HO3D v3");
    ck_assert_int_eq(d->count, 1);
    ck_assert(!d->synthetic);
    check_ok(dataset_read(d, 0, SAMPLE_OBJECT | SAMPLE_DEPTH, arena, &s));
    ck_assert_str_eq(s.name, "ABF10/0123");
    ck_assert_int_eq(s.flags, SAMPLE_HAND_POSE | SAMPLE_JOINTS | SAMPLE_ROOT | SAMPLE_OBJECT | SAMPLE_DEPTH);
    near(s.joints2d[0], first, 2, 1e-4);
    lt_rot_from_axis_angle(aa, R);
    near(s.rotation[0], R, 9, 2e-6);
    near(s.R, R, 9, 2e-6);
    near(s.t, t, 3, 1e-7);
    near(s.root, (const double[]){ .05, .02, .6 }, 3, 1e-7);
    lt_rot_from_axis_angle((const double[]){ 0.1, 0, 0 }, R);
    near(s.rotation[1], R, 9, 1e-6);                            /* only the wrist changes axes */
    for (int i = 0; i < 21; i++)
        ck_assert_float_eq_tol(s.joints[i][0] - s.root[0], 0.001f * (float)lt_mano_to_simple[i], 1e-7);
    ck_assert_float_eq_tol(s.depth[0], 1.249866f, 1e-6);
    ck_assert_float_eq(s.depth[1], 0);
    dataset_free(d);
}
END_TEST

START_TEST(object)
{
    dataset *d = open_split("train");
    dataset_sample s;
    const dataset_object *o;
    double p[3], R[9], uv[2];
    int area = 0;

    check_ok(dataset_read(d, 0, SAMPLE_OBJECT, arena, &s));
    ck_assert_ptr_null(s.depth);
    ck_assert_int_eq(s.object, 0);
    o = &d->objects[0];
    ck_assert_int_eq(o->ycb_id, 5);
    ck_assert_int_eq(dataset_find_object(d, "syn_006_mustard_bottle"), 0);
    ck_assert_int_eq(dataset_find_object(d, "007_tuna_fish_can"), -1);
    ck_assert_float_eq_tol(o->diagonal, sqrtf(.04f * .04f + .06f * .06f + .1f * .1f), 1e-6);
    ck_assert_float_eq_tol(o->diameter, sqrtf(.06f * .06f + .1f * .1f), 1e-6);
    near(o->control[20], (const double[]){ .02, .03, .05 }, 3, 1e-7);
    for (int i = 0; i < 9; i++)
        R[i] = s.R[i];
    for (int k = 0; k < 3; k++)
        p[k] = R[3 * k] * .02 + R[3 * k + 1] * .03 + R[3 * k + 2] * .05 + s.t[k];
    lt_camera_project(&s.camera, p, uv);
    near(s.control2d[20], uv, 2, 1e-3);
    for (int i = 0; i < W * H; i++)
        area += s.silhouette[i];
    ck_assert_int_gt(area, 500);
    dataset_free(d);
}
END_TEST

START_TEST(evaluation_sample)
{
    dataset *d = open_split("evaluation");
    dataset_sample s;

    ck_assert_str_eq(d->title, "HO3D v2");
    check_ok(dataset_read(d, 0, 0, arena, &s));
    ck_assert_int_eq(s.flags, SAMPLE_ROOT | SAMPLE_HAND_BOX | SAMPLE_OBJECT);
    ck_assert_ptr_null(s.silhouette);
    near(s.hand_box, (const double[]){ 300.5, 200, 400, 310 }, 4, 1e-5);
    near(s.root, (const double[]){ .05, .02, .6 }, 3, 1e-7);
    ck_assert_int_eq(s.rgb[3 * 7], 7);
    dataset_free(d);
}
END_TEST

/* From the annotated wrist on along x, `off` metres too far. */
static void truth_at(double off, const char *file, int frames, int points)
{
    FILE *f = fopen(at(file), "w");

    for (int i = 0; i < frames; i++) {
        fprintf(f, i ? ", [" : "[[");
        for (int k = 0; k < points; k++)
            fprintf(f, "%s[%g, -0.02, -6e-1]", k ? ", " : "", 0.05 + off + 0.001 * k);
        fprintf(f, "]");
    }
    fprintf(f, "]\n");
    fclose(f);
}

static void truth(const char *file, int frames, int points)
{
    truth_at(0, file, frames, points);
}

START_TEST(evaluation_truth)
{
    dataset *d;
    dataset_sample s;

    truth("evaluation_xyz.json", 1, 21);
    truth("evaluation_verts.json", 1, 778);
    d = open_split("evaluation");
    check_ok(dataset_read(d, 0, 0, arena, &s));
    ck_assert(s.flags & SAMPLE_JOINTS && s.flags & SAMPLE_VERTICES);
    near(s.joints[4], (const double[]){ .066, .02, .6 }, 3, 1e-7);      /* the thumb's tip is MANO's 16 */
    near(s.vertices[777], (const double[]){ .827, .02, .6 }, 3, 1e-6);
    near(s.root, (const double[]){ .05, .02, .6 }, 3, 1e-7);            /* from the annotation */
    dataset_free(d);
}
END_TEST

/* Truth of another frame, or in another unit, is not this one's. */
START_TEST(truth_of_another_frame)
{
    const char *meta_path = at("evaluation/ABF10/meta/0123.pkl");
    dataset *d;
    dataset_sample s;

    truth_at(0.005, "evaluation_xyz.json", 1, 21);
    d = open_split("evaluation");
    check_ok(dataset_read(d, 0, 0, arena, &s));
    near(s.root, (const double[]){ .05, .02, .6 }, 3, 1e-7);            /* from the annotation */
    dataset_free(d);
    truth_at(0.05, "evaluation_xyz.json", 1, 21);
    d = open_split("evaluation");
    ck_assert_int_eq(dataset_read(d, 0, 0, arena, &s), LT_EFORMAT);
    ck_assert_str_eq(lt_last_error(), lt_arena_printf(arena, "%s: its wrist is 0.05 m from that of evaluation_xyz.json "
                                                      "at 0, expected the same place; is the truth in the order of "
                                                      "evaluation.txt, in metres?", meta_path));
    dataset_free(d);
}
END_TEST

START_TEST(hand_only)
{
    const ho3d_options o = { .root = scratch_folder, .split = "train", .no_objects = true };
    dataset *d;
    dataset_sample s;

    check_ok(ho3d_open(&o, &d));
    check_ok(dataset_read(d, 0, SAMPLE_OBJECT, arena, &s));
    ck_assert_int_eq(s.object, -1);
    ck_assert(!(s.flags & SAMPLE_OBJECT));
    dataset_free(d);
}
END_TEST

/* ---- what is refused ---- */

static void open_fails(const char *split, const char *line)
{
    const ho3d_options o = { .root = scratch_folder, .split = split, .vertices = true };
    dataset *d;

    ck_assert_int_ne(ho3d_open(&o, &d), LT_OK);
    ck_assert_msg(!strcmp(lt_last_error(), line), "got  %s\nwant %s", lt_last_error(), line);
}

static void read_fails(const char *split, const char *line)
{
    dataset *d = open_split(split);
    dataset_sample s;

    ck_assert_int_ne(dataset_read(d, 0, SAMPLE_OBJECT | SAMPLE_DEPTH, arena, &s), LT_OK);
    ck_assert_msg(!strcmp(lt_last_error(), line), "got  %s\nwant %s", lt_last_error(), line);
    dataset_free(d);
}

START_TEST(folders_missing)
{
    const ho3d_options o = { .root = "/nonexistent/HO3D", .split = "train" };
    const ho3d_options other = { .root = scratch_folder, .split = "test" };
    dataset *d;

    ck_assert_int_eq(ho3d_open(&o, &d), LT_EIO);
    ck_assert_str_eq(lt_last_error(), "/nonexistent/HO3D: no such folder; give the HO3D folder that holds "
                                      "train.txt, or make a synthetic one with `palmar synth`");
    ck_assert_int_eq(ho3d_open(&other, &d), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "HO3D has no split \"test\": \"train\" or \"evaluation\"");
    unlink(at("train.txt"));
    open_fails("train", lt_arena_printf(arena, "%s: no such file; the folder of HO3D v2 or v3 holds "
                                        "train.txt and evaluation.txt", at("train.txt")));
}
END_TEST

START_TEST(lists_broken)
{
    text_file("train.txt", "");
    open_fails("train", lt_arena_printf(arena, "%s: lists no frame", at("train.txt")));
    text_file("train.txt", "ABF10/0123\r\n../../etc/passwd\n");
    open_fails("train", lt_arena_printf(arena, "%s: entry 2 is \"../../etc/passwd\", expected "
                                        "SEQUENCE/FRAME, such as ABF10/0123", at("train.txt")));
    text_file("train.txt", "0123\n");
    open_fails("train", lt_arena_printf(arena, "%s: entry 1 is \"0123\", expected SEQUENCE/FRAME, such as "
                                        "ABF10/0123", at("train.txt")));
}
END_TEST

START_TEST(list_with_a_byte_0)
{
    FILE *f = fopen(at("train.txt"), "wb");

    fwrite("ABF10/0123\n\0ABF10/0124\n", 1, 23, f);
    fclose(f);
    open_fails("train", lt_arena_printf(arena, "%s: a byte 0 in the list, expected lines SEQUENCE/FRAME",
                                        at("train.txt")));
}
END_TEST

START_TEST(models_missing)
{
    ck_assert_int_eq(rename(at("models"), at("elsewhere")), 0);
    open_fails("train", lt_arena_printf(arena, "%s/models: no such folder, nor %s/../models; put the YCB "
                                        "models there (HO3D's page links them), or name their folder", scratch_folder,
                                        scratch_folder));
    check_ok(lt_make_dirs(at("models")));
    open_fails("train", lt_arena_printf(arena, "%s/models: has none of the object models (such as "
                                        "002_master_chef_can); they are the YCB models of PoseCNN, to be had from "
                                        "the DexYCB and HO3D pages", scratch_folder));
}
END_TEST

/* Synthetic data in HO3D's layout may hold any of the 21. */
START_TEST(models_beyond_ho3d)
{
    dataset *d;

    model("syn_036_wood_block");
    d = open_split("train");
    ck_assert_int_eq(d->n_objects, 2);
    ck_assert_int_ge(dataset_find_object(d, "036_wood_block"), 0);
    dataset_free(d);
}
END_TEST

/* Objects of the user's own stand behind the 21; a folder without a mesh is none. */
START_TEST(models_of_ones_own)
{
    dataset *d;

    model("syn_036_wood_block");
    model("teapot");
    model("syn_jug");
    check_ok(lt_make_dirs(at("models/notes")));
    d = open_split("train");
    ck_assert_int_eq(d->n_objects, 4);
    ck_assert_str_eq(d->objects[2].name, "syn_jug");
    ck_assert_int_eq(dataset_find_object(d, "jug"), 2);
    ck_assert_int_eq(dataset_find_object(d, "teapot"), 3);
    ck_assert_int_eq(d->objects[3].ycb_id, 0);
    ck_assert_int_eq(dataset_find_object(d, "notes"), -1);
    dataset_free(d);
    model("jug");                                       /* the stand-in and its model are one object */
    d = open_split("train");
    ck_assert_int_eq(d->n_objects, 4);
    ck_assert_str_eq(d->objects[2].name, "jug");
    dataset_free(d);
}
END_TEST

START_TEST(model_incomplete)
{
    const char *path = at("models/006_mustard_bottle/points.xyz");

    unlink(path);
    open_fails("train", lt_arena_printf(arena, "%s: No such file or directory", path));
}
END_TEST

/* What stands in a model's place where the real file was not fetched is text too, and has no triangles. */
START_TEST(model_is_no_mesh)
{
    static const struct {
        const char *text, *reason;
    } cases[] = {
        { "", "0 vertices and 0 triangles, expected a mesh; is it a git-lfs pointer or a failed download?" },
        { "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 1234\n",
          "a git-lfs pointer in the place of a file, want a mesh in OBJ; \"git lfs pull\" fetches it" },
        { "<!DOCTYPE html>\n",
          "an HTML page in the place of a file, want a mesh in OBJ; download it again, or with a browser" },
    };
    const char *path = "models/006_mustard_bottle/textured_simple.obj";

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        text_file(path, cases[i].text);
        open_fails("train", lt_arena_printf(arena, "%s: %s", at(path), cases[i].reason));
    }
}
END_TEST

static const struct { float unit, points; const char *line; } sizes[] = {
    { 1000, 1000, "%s: 117 m across, expected a thing that a hand can hold, in metres; it looks as if the model is in "
      "millimetres, not metres" },
    { 100, 100, "%s: 11.7 m across, expected a thing that a hand can hold, in metres; it looks as if the model is in "
      "centimetres, not metres" },
    { 0.001f, 0.001f, "%s: 0.000117 m across, expected a thing that a hand can hold, in metres; it looks as if the "
      "model is 1000 times too small" },
    { 0, 0, "%s: 0 m across, expected a thing that a hand can hold, in metres" },
    { 1, 1000, "%s: 123 m across, and textured_simple.obj 0.117 m: one of them is in another unit than metres" },
};

START_TEST(model_in_another_unit)
{
    model_in("006_mustard_bottle", sizes[_i].unit, sizes[_i].points);
    open_fails("train", lt_arena_printf(arena, sizes[_i].line, at(sizes[_i].points > sizes[_i].unit
               ? "models/006_mustard_bottle/points.xyz" : "models/006_mustard_bottle/textured_simple.obj")));
}
END_TEST

START_TEST(truth_broken)
{
    const char *path = at("evaluation_xyz.json");

    truth("evaluation_xyz.json", 2, 21);
    open_fails("evaluation", lt_arena_printf(arena, "%s: frame 1, point 0: found one more frame, expected the "
                                             "end: evaluation.txt lists no more", path));
    text_file("evaluation_xyz.json", "[]");
    open_fails("evaluation", lt_arena_printf(arena, "%s: has 0 frames, evaluation.txt lists 1", path));
    truth("evaluation_xyz.json", 1, 20);
    open_fails("evaluation", lt_arena_printf(arena, "%s: frame 0, point 20: found the end of the frame, "
                                             "expected 21 points", path));
    text_file("evaluation_xyz.json", "[[[1, 2]]]");
    open_fails("evaluation", lt_arena_printf(arena, "%s: frame 0, point 0: found the end of the point, "
                                             "expected three numbers", path));
    text_file("evaluation_xyz.json", "[[[1, null, 3]]]");
    open_fails("evaluation", lt_arena_printf(arena, "%s: frame 0, point 0: found null, expected numbers",
                                             path));
    text_file("evaluation_xyz.json", "[[[1, 1e9, 3]]]");
    open_fails("evaluation", lt_arena_printf(arena, "%s: frame 0, joint 0, y: found 1e9, expected a "
                                             "coordinate in metres", path));
    text_file("evaluation_xyz.json", "{\"xyz\": 1}");
    open_fails("evaluation", lt_arena_printf(arena, "%s: frame 0, point 0: found an object, expected a list",
                                             path));
}
END_TEST

/* Whatever the text is, there is an answer. */
START_TEST(truth_cut_anywhere)
{
    static const char whole[] = "[[[1,2,3],[4,5,6]]]";
    float *out;

    for (size_t n = 0; n < sizeof(whole) - 1; n++) {
        check_ok(lt_write_file(at("cut.json"), whole, n));
        ck_assert_int_eq(ho3d_read_truth(arena, at("cut.json"), 1, 2, &out), LT_EFORMAT);
    }
    text_file("cut.json", whole);
    check_ok(ho3d_read_truth(arena, at("cut.json"), 1, 2, &out));
    ck_assert_float_eq(out[5], 6);
}
END_TEST

START_TEST(images_missing_or_broken)
{
    const char *jpg = at("train/ABF10/rgb/0123.jpg"), *png = at("train/ABF10/rgb/0123.png");

    picture("train/ABF10/rgb/0123.jpg", true, 320, 240);
    read_fails("train", lt_arena_printf(arena, "%s: image of 320 x 240, expected 640 x 480", jpg));
    ck_assert_int_eq(truncate(jpg, 1500), 0);
    {
        dataset *d = open_split("train");
        dataset_sample s;
        ck_assert_int_eq(dataset_read(d, 0, 0, arena, &s), LT_EFORMAT);
        ck_assert_ptr_nonnull(strstr(lt_last_error(), jpg));
        dataset_free(d);
    }
    unlink(jpg);
    read_fails("train", lt_arena_printf(arena, "%s: no such file, nor 0123.jpg", png));
}
END_TEST

START_TEST(depth_missing)
{
    const char *path = at("train/ABF10/depth/0123.png");

    unlink(path);
    read_fails("train", lt_arena_printf(arena, "%s: No such file or directory", path));
}
END_TEST

/* A photograph in its place is none, with or without colours. */
START_TEST(depth_is_a_picture)
{
    const char *path = at("train/ABF10/depth/0123.png");

    picture("train/ABF10/depth/0123.png", false, 640, 480);
    read_fails("train", lt_arena_printf(arena, "%s: 3 channels of 8 bits, a picture, expected one of 16, depth in "
                                        "millimetres, or HO3D's 3 of 8, of which blue is 0", path));
}
END_TEST

/* The channels of hand, object and arm; -1: not in the picture. */
typedef struct { int hand, object, arm; } colours;

static const colours version_3 = { 2, 1, -1 };

/* Hand in the upper left corner, object beside it, an arm below in neither's colour. */
static void mask(const char *path, bool jpg, int width, int height, colours c)
{
    lt_image img;

    check_ok(lt_make_dirs(at("train/ABF10/seg")));
    check_ok(lt_image_init(arena, width, height, 3, 8, &img));
    for (int y = 0; y < height / 2; y++)
        for (int x = 0; x < width / 2; x++) {
            const int channel = y >= height / 4 ? c.arm : x < width / 4 ? c.hand : c.object;
            if (channel >= 0)
                img.data[3 * (y * width + x) + channel] = 255;
        }
    check_ok(jpg ? lt_jpeg_write(at(path), &img, 95) : lt_png_write(at(path), &img));
}

/* Version 2's JPEG and the same saved anew; version 3's PNG; and either with the hand hidden, with nothing red. */
static const struct { const char *path; bool jpg; int width, height; colours c; } masks[] = {
    { "train/ABF10/seg/0123.jpg", true, 160, 120, { 0, 2, 1 } },
    { "train/ABF10/seg/0123.png", false, 160, 120, { 0, 2, 1 } },
    { "train/ABF10/seg/0123.png", false, 640, 480, { 0, 2, 1 } },
    { "train/ABF10/seg/0123.png", false, 160, 120, { 2, 1, -1 } },
    { "train/ABF10/seg/0123.jpg", true, 160, 120, { 2, 1, -1 } },
    { "train/ABF10/seg/0123.png", false, 160, 120, { -1, 1, -1 } },
    { "train/ABF10/seg/0123.jpg", true, 160, 120, { -1, 2, -1 } },
};

START_TEST(segments)
{
    const int w = masks[_i].width, h = masks[_i].height, left = masks[_i].c.hand < 0 ? w / 4 : 0;
    dataset *d = open_split("train");
    dataset_sample s;

    mask(masks[_i].path, masks[_i].jpg, w, h, masks[_i].c);
    check_ok(dataset_read(d, 0, 0, arena, &s));
    ck_assert_ptr_null(s.segments);
    check_ok(dataset_read(d, 0, SAMPLE_SEGMENTS, arena, &s));
    ck_assert(s.flags & SAMPLE_SEGMENTS);
    ck_assert_int_eq(s.segments_width, w);
    ck_assert_int_eq(s.segments_height, h);
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++)
            if (!masks[_i].jpg || (x % (w / 4) > 1 && x % (w / 4) < w / 4 - 2 && y != h / 4))
                ck_assert_int_eq(s.segments[y * w + x], x < left || x >= w / 2 || y >= h / 4 ? 0
                                                        : x < w / 4 ? SEGMENT_HAND : SEGMENT_OBJECT);
    dataset_free(d);
}
END_TEST

/* Blue alone is the hand in version 3 and the object in version 2: the tree's other masks tell. */
START_TEST(blue_is_of_the_version)
{
    const bool second = _i;
    dataset *d;
    dataset_sample s;

    meta("train/ABF10/meta/0124.pkl", false, NULL);
    picture("train/ABF10/rgb/0124.jpg", true, W, H);
    text_file("train.txt", "ABF10/0123\nABF10/0124\n");
    mask("train/ABF10/seg/0123.png", false, 160, 120, (colours){ second ? -1 : 2, second ? 2 : -1, -1 });
    mask("train/ABF10/seg/0124.png", false, 160, 120, second ? (colours){ 0, 2, 1 } : version_3);
    d = open_split("train");
    check_ok(dataset_read(d, 0, SAMPLE_SEGMENTS, arena, &s));
    ck_assert_int_eq(s.segments[0], second ? 0 : SEGMENT_HAND);
    ck_assert_int_eq(s.segments[45], second ? SEGMENT_OBJECT : 0);
    dataset_free(d);
}
END_TEST

/* Blue and red as a program that takes colours the other way round would save version 2: the hand is blue, the object
 * red. The joints, which lie from (371, 259) on to the right, are on the object then. */
START_TEST(colours_mean_something_else)
{
    dataset *d = open_split("train");
    dataset_sample s;
    lt_image img;

    check_ok(lt_make_dirs(at("train/ABF10/seg")));
    check_ok(lt_image_init(arena, 160, 120, 3, 8, &img));
    for (int y = 60; y < 70; y++)
        for (int x = 80; x < 110; x++)
            img.data[3 * (y * 160 + x) + 2] = 255;
    check_ok(lt_png_write(at("train/ABF10/seg/0123.png"), &img));
    check_ok(dataset_read(d, 0, SAMPLE_SEGMENTS, arena, &s));
    dataset_free(d);
    img.data[0] = 255;
    check_ok(lt_png_write(at("train/ABF10/seg/0123.png"), &img));
    d = open_split("train");
    ck_assert_int_eq(dataset_read(d, 0, SAMPLE_SEGMENTS, arena, &s), LT_EFORMAT);
    ck_assert_str_eq(lt_last_error(), lt_arena_printf(arena, "%s/train: the masks in SEQUENCE/seg have 21 joints of "
                     "hands on the object and 0 on the hand, expected the hand red and the object blue, as HO3D v2 has "
                     "them, or the hand blue and the object green, as v3", scratch_folder));
    check_ok(dataset_read(d, 0, 0, arena, &s));
    dataset_free(d);
}
END_TEST

/* As cameras, cards and people name them. */
static const struct { const char *rgb, *depth, *seg, *kind; } endings[] = {
    { "JPG", "PNG", "PNG", "HO3D v3" }, { "jpeg", "png", "png", "HO3D v3" }, { "JPEG", "png", "JPG", "HO3D v3" },
    { "PNG", "PNG", "jpeg", "HO3D v2" },
};

static void name_anew(const char *kind, const char *from, const char *to)
{
    const char *old = at(lt_arena_printf(arena, "train/ABF10/%s/0123.%s", kind, from));

    ck_assert_int_eq(rename(old, at(lt_arena_printf(arena, "train/ABF10/%s/0123.%s", kind, to))), 0);
}

START_TEST(other_endings)
{
    dataset *d;
    dataset_sample s;

    if (!strcmp(endings[_i].rgb, "PNG")) {
        unlink(at("train/ABF10/rgb/0123.jpg"));
        picture("train/ABF10/rgb/0123.jpg", false, W, H);
    }
    mask("train/ABF10/seg/0123.png", false, 160, 120, version_3);
    name_anew("rgb", "jpg", endings[_i].rgb);
    name_anew("depth", "png", endings[_i].depth);
    name_anew("seg", "png", endings[_i].seg);
    d = open_split("train");
    ck_assert_str_eq(d->title, endings[_i].kind);
    ck_assert_ptr_null(d->ops->missing(d, 0, arena));
    check_ok(dataset_read(d, 0, SAMPLE_DEPTH | SAMPLE_SEGMENTS, arena, &s));
    ck_assert_int_eq(s.flags & (SAMPLE_DEPTH | SAMPLE_SEGMENTS), SAMPLE_DEPTH | SAMPLE_SEGMENTS);
    unlink(at(lt_arena_printf(arena, "train/ABF10/rgb/0123.%s", endings[_i].rgb)));
    ck_assert_str_eq(d->ops->missing(d, 0, arena), at(strcmp(endings[_i].rgb, "PNG") ? "train/ABF10/rgb/0123.jpg"
                                                                                    : "train/ABF10/rgb/0123.png"));
    dataset_free(d);
}
END_TEST

START_TEST(segments_missing_or_broken)
{
    const char *path = at("train/ABF10/seg/0123.png");
    dataset *d = open_split("train");
    dataset_sample s;

    check_ok(dataset_read(d, 0, SAMPLE_SEGMENTS, arena, &s));
    ck_assert(!(s.flags & SAMPLE_SEGMENTS));
    ck_assert_ptr_null(s.segments);
    mask("train/ABF10/seg/0123.png", false, 160, 100, version_3);
    ck_assert_int_eq(dataset_read(d, 0, SAMPLE_SEGMENTS, arena, &s), LT_EFORMAT);
    ck_assert_str_eq(lt_last_error(), lt_arena_printf(arena, "%s: mask of 160 x 100, expected 640 x 480 or a whole "
                                                      "fraction of it", path));
    ck_assert_int_eq(truncate(path, 60), 0);
    ck_assert_int_eq(dataset_read(d, 0, SAMPLE_SEGMENTS, arena, &s), LT_EFORMAT);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), path));
    check_ok(dataset_read(d, 0, 0, arena, &s));
    dataset_free(d);
}
END_TEST

/* An item of the annotation in place of the right one, and what is said of it. */
static const float zeros[64], not_a_number[3] = { 0, NAN, 0 }, near_camera[3] = { 0, 0, 0.3f };
static const float enormous[10] = { 0, 1e6f }, millimetres[63] = { 0, 0, -600 };
static const float transposed[9] = { 600, 0, 0, 0, 610, 0, 320, 240, 1 };
static const float skewed[9] = { 600, 2, 320, 0, 600, 240, 0, 0, 1 };
static const struct {
    bool evaluation;
    const char *key;
    lt_pwrite_kind kind;
    int rows, columns;
    const float *data;
    const char *text, *line;
} wrong[] = {
    { false, "handPose", LT_PW_ARRAY, 45, 0, zeros, NULL, "handPose" },
    { false, "handPose", LT_PW_NONE, 0, 0, NULL, NULL,
      ": handPose is None, expected 48 numbers: this frame is not annotated, so it should not be listed" },
    { false, "handBeta", LT_PW_ARRAY, 10, 0, enormous, NULL, ": handBeta: number 1 is 1e+06, expected less than 100" },
    { false, "handJoints3D", LT_PW_ARRAY, 21, 3, millimetres, NULL,
      ": handJoints3D: number 2 is -600, expected less than 100" },
    { false, "handJoints3D", LT_PW_ARRAY, 20, 3, zeros, NULL, "handJoints3D" },
    { false, "handJoints3D", LT_PW_ARRAY, 3, 0, wrist, NULL, "handJoints3D" },
    { false, "camMat", LT_PW_ARRAY, 3, 2, zeros, NULL, "camMat" },
    { false, "camMat", LT_PW_ARRAY, 3, 3, zeros, NULL,
      ": camMat is [0 0 0; 0 0 0; 0 0 0], expected [fx 0 cx; 0 fy cy; 0 0 1]" },
    { false, "camMat", LT_PW_ARRAY, 3, 3, skewed, NULL,
      ": camMat is [600 2 320; 0 600 240; 0 0 1], expected [fx 0 cx; 0 fy cy; 0 0 1]" },
    { false, "camMat", LT_PW_ARRAY, 3, 3, transposed, NULL,
      ": camMat is [600 0 0; 0 610 0; 320 240 1], expected [fx 0 cx; 0 fy cy; 0 0 1]; it is transposed" },
    { false, "objRot", LT_PW_ARRAY, 3, 0, not_a_number, NULL, "objRot" },
    { false, "objTrans", LT_PW_STR, 0, 0, NULL, "far away", "objTrans" },
    { false, "objName", LT_PW_INT, 0, 0, NULL, NULL,
      ": objName: expected a text, the name of a YCB model" },
    { false, "objName", LT_PW_STR, 0, 0, NULL, "025_mug", "025_mug" },
    { true, "handJoints3D", LT_PW_ARRAY, 21, 3, zeros, NULL, "handJoints3D" },
    { true, "handBoundingBox", LT_PW_NONE, 0, 0, NULL, NULL,
      ": handBoundingBox is None, expected 4 numbers: this frame is not annotated, so it should not be listed" },
};

/* The line names the file and says what wrong[i].line does: all of it, or, a bare word, at least that. */
START_TEST(annotation_wrong)
{
    const char *split = wrong[_i].evaluation ? "evaluation" : "train", *line = wrong[_i].line;
    const char *path = lt_arena_printf(arena, "%s/ABF10/meta/0123.pkl", split);
    const size_t n = strlen(at(path));
    lt_pwrite item = { .key = wrong[_i].key, .kind = wrong[_i].kind, .text = wrong[_i].text };
    dataset *d;
    dataset_sample s;

    if (item.kind == LT_PW_ARRAY)
        item = array_of(item.key, wrong[_i].data, wrong[_i].rows, wrong[_i].columns);
    meta(path, wrong[_i].evaluation, &item);
    d = open_split(split);
    ck_assert_int_ne(dataset_read(d, 0, 0, arena, &s), LT_OK);
    ck_assert_msg(!strncmp(lt_last_error(), at(path), n), "%s", lt_last_error());
    ck_assert_msg(strstr(lt_last_error(), line) != NULL, "%s", lt_last_error());
    if (line[0] == ':')
        ck_assert_str_eq(lt_last_error() + n, line);
    dataset_free(d);
}
END_TEST

START_TEST(annotation_of_other_shapes)
{
    const lt_pwrite item = array_of("handBeta", beta, 2, 5);
    dataset_sample s;
    dataset *d;

    meta("train/ABF10/meta/0123.pkl", false, &item);
    d = open_split("train");
    check_ok(dataset_read(d, 0, 0, arena, &s));
    ck_assert_mem_eq(s.beta, beta, sizeof(beta));
    dataset_free(d);
}
END_TEST

START_TEST(annotation_missing_key)
{
    lt_pwrite item[KEYS];

    set_items(item, false);
    item[4].key = "pose";
    check_ok(lt_pickle_write_dict(at("train/ABF10/meta/0123.pkl"), item, KEYS));
    {
        dataset *d = open_split("train");
        dataset_sample s;
        ck_assert_int_eq(dataset_read(d, 0, 0, arena, &s), LT_EFORMAT);
        ck_assert_ptr_nonnull(strstr(lt_last_error(), "handPose"));
        dataset_free(d);
    }
    unlink(at("train/ABF10/meta/0123.pkl"));
    read_fails("train", lt_arena_printf(arena, "%s: No such file or directory",
                                        at("train/ABF10/meta/0123.pkl")));
}
END_TEST

/* H2O-3D's keys, of either split. */
START_TEST(two_hands)
{
    lt_pwrite item[KEYS];

    set_items(item, false);
    item[4].key = "leftHandPose";
    item[6].key = "leftHandTrans";
    item[7].key = "leftHandJoints3D";
    check_ok(lt_pickle_write_dict(at("train/ABF10/meta/0123.pkl"), item, KEYS));
    open_fails("train", lt_arena_printf(arena, "%s: H2O-3D, whose frames have two hands (leftHandJoints3D), is not "
                                        "read; HO3D v2 and v3 are", scratch_folder));
    set_items(item, true);
    item[7].key = "rightHandJoints3D";
    check_ok(lt_pickle_write_dict(at("evaluation/ABF10/meta/0123.pkl"), item, KEYS));
    open_fails("evaluation", lt_arena_printf(arena, "%s: H2O-3D, whose frames have two hands (rightHandJoints3D), is "
                                             "not read; HO3D v2 and v3 are", scratch_folder));
}
END_TEST

START_TEST(behind_the_camera)
{
    const lt_pwrite item = array_of("objTrans", near_camera, 3, 0);

    meta("train/ABF10/meta/0123.pkl", false, &item);
    read_fails("train", "ABF10/0123: object control point 0 lies behind the camera, at z = -0.3 m");
}
END_TEST

START_TEST(no_such_sample)
{
    dataset *d = open_split("train");
    dataset_sample s;

    ck_assert_int_eq(dataset_read(d, 1, 0, arena, &s), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), lt_arena_printf(arena, "%s: no sample 1, there are 1", scratch_folder));
    dataset_free(d);
    dataset_free(NULL);
}
END_TEST

/* Whichever block is refused, there is an answer and nothing is lost. */
START_TEST(without_memory)
{
    const ho3d_options o = { .root = scratch_folder, .split = "train" };
    long n = 0;
    lt_status st;

    mask("train/ABF10/seg/0123.png", false, 160, 120, version_3);
    do {
        lt_arena *scratch = lt_arena_new();
        dataset *d = NULL;
        dataset_sample s;
        lt_alloc_fail_at(++n);
        st = ho3d_open(&o, &d);
        if (!st)
            st = dataset_read(d, 0, SAMPLE_OBJECT | SAMPLE_DEPTH | SAMPLE_SEGMENTS, scratch, &s);
        lt_alloc_fail_at(0);
        ck_assert(st == LT_OK || st == LT_ENOMEM);
        dataset_free(d);
        lt_arena_free(scratch);
    } while (st && n < 1000);
    ck_assert_int_eq(st, LT_OK);
    ck_assert_int_gt(n, 3);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_checked_fixture(c, setup, close_scratch);
    tcase_set_timeout(c, 60);
    tcase_add_test(c, train_sample);
    tcase_add_test(c, object);
    tcase_add_test(c, evaluation_sample);
    tcase_add_test(c, evaluation_truth);
    tcase_add_test(c, truth_of_another_frame);
    tcase_add_test(c, hand_only);
    tcase_add_test(c, folders_missing);
    tcase_add_test(c, lists_broken);
    tcase_add_test(c, list_with_a_byte_0);
    tcase_add_test(c, models_missing);
    tcase_add_test(c, models_beyond_ho3d);
    tcase_add_test(c, models_of_ones_own);
    tcase_add_test(c, model_is_no_mesh);
    tcase_add_test(c, model_incomplete);
    tcase_add_loop_test(c, model_in_another_unit, 0, LT_COUNT(sizes));
    tcase_add_test(c, truth_broken);
    tcase_add_test(c, truth_cut_anywhere);
    tcase_add_test(c, images_missing_or_broken);
    tcase_add_test(c, depth_missing);
    tcase_add_test(c, depth_is_a_picture);
    tcase_add_loop_test(c, segments, 0, LT_COUNT(masks));
    tcase_add_loop_test(c, blue_is_of_the_version, 0, 2);
    tcase_add_test(c, colours_mean_something_else);
    tcase_add_loop_test(c, other_endings, 0, LT_COUNT(endings));
    tcase_add_test(c, segments_missing_or_broken);
    tcase_add_loop_test(c, annotation_wrong, 0, LT_COUNT(wrong));
    tcase_add_test(c, annotation_of_other_shapes);
    tcase_add_test(c, annotation_missing_key);
    tcase_add_test(c, two_hands);
    tcase_add_test(c, behind_the_camera);
    tcase_add_test(c, no_such_sample);
    tcase_add_test(c, without_memory);
}

int main(void)
{
    return run_suite("ho3d", add_tests);
}
