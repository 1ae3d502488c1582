/* SPDX-License-Identifier: Apache-2.0 */
/* Photos with cameras: conventions, splits, masks, the turntable that we write, and what cannot be. */
#include "data/transforms/transforms.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "synth/generate.h"
#include "tests/suite.h"

#define MATRIX "\"transform_matrix\": [[1,0,0,0.1],[0,1,0,0.2],[0,0,1,1.5],[0,0,0,1]]"
#define LENS "\"fl_x\": 500, \"cx\": 4, \"cy\": 3, "

static lt_arena *arena;
static transforms_set set;

static void setup(void)
{
    make_scratch_folder();
    arena = lt_arena_new();
}

static void teardown(void)
{
    lt_arena_free(arena);
    remove_scratch_folder();
}

static void put_image(const char *name, int channels, uint8_t value)
{
    uint8_t data[8 * 6 * 4];
    const lt_image im = { 8, 6, channels, 8, data };

    memset(data, value, sizeof(data));
    check_ok(lt_png_write(in_folder(name), &im));
}

static lt_status open_text(const char *text)
{
    const char *at = in_folder("transforms.json");

    put_file(at, text, strlen(text));
    return transforms_open(arena, lt_path_folder(arena, at), 8, &set);
}

/* The vector of the specification: a point, in the camera and on its picture. */
START_TEST(conventions)
{
    const double world[3] = { 0.2, 0.3, -0.5 };
    transforms_picture p;
    double c[3], uv[2];

    put_image("a.png", 3, 10);
    put_image("b.png", 3, 20);
    check_ok(open_text("{\"fl_x\": 500, \"frames\": [{\"file_path\": \"./a\", \"cx\": 4.5, " MATRIX "},"
                       "{\"file_path\": \"b.png\", " MATRIX "}]}"));
    ck_assert_int_eq(set.n, 2);
    for (int k = 0; k < 3; k++) {
        const double *R = set.view[0].R_cam_world + 3 * k;

        c[k] = R[0] * world[0] + R[1] * world[1] + R[2] * world[2] + set.view[0].t_cam_world[k];
    }
    ck_assert_double_eq_tol(c[0], 0.1, 1e-12);
    ck_assert_double_eq_tol(c[1], -0.1, 1e-12);
    ck_assert_double_eq_tol(c[2], 2, 1e-12);
    check_ok(transforms_read(arena, &set.view[0], 1, false, &p));
    lt_camera_project(&p.camera, c, uv);
    ck_assert_double_eq_tol(uv[0], 4.5 - 0.5 + 25, 1e-9);
    ck_assert_double_eq_tol(uv[1], 3 - 0.5 - 25, 1e-9);
    ck_assert(p.width == 8 && p.height == 6 && p.rgb[0] == 10 && !p.mask);
    ck_assert(set.view[0].held_out && !set.view[1].held_out && set.n_held_out == 1);
    check_ok(transforms_read(arena, &set.view[1], 2, false, &p));
    ck_assert(p.width == 4 && p.height == 3 && p.rgb[0] == 20);
    ck_assert_double_eq_tol(p.camera.fx, 250, 1e-9);
    ck_assert_double_eq_tol(p.camera.cx, 2 - 0.5, 1e-9);
}
END_TEST

/* Blender's: an angle in place of a focal length, alpha in place of a mask, and a file for each split */
START_TEST(blender)
{
    const char *one = "{\"camera_angle_x\": 1.5707963267948966, \"frames\": [{\"file_path\": \"a\", " MATRIX "}]}";
    const char *at = in_folder("transforms_train.json");
    transforms_picture p;

    put_image("a.png", 4, 0);
    put_file(at, one, strlen(one));
    put_file(in_folder("transforms_test.json"), one, strlen(one));
    check_ok(transforms_open(arena, lt_path_folder(arena, in_folder("x")), 8, &set));
    ck_assert(set.n == 2 && set.n_held_out == 1 && set.view[1].held_out);
    check_ok(transforms_read(arena, &set.view[0], 1, true, &p));
    ck_assert_double_eq_tol(p.camera.fx, 4, 1e-9);
    ck_assert(p.rgb[0] == 255 && p.mask && p.mask[0] == 0);
}
END_TEST

static const struct { const char *text, *reason; } wrong[] = {
    { "{\"frames\": [{\"file_path\": \"a\", ", "transforms.json" },
    { "{}", "\"frames\": found 0" },
    { "{\"frames\": []}", "want a list of 1" },
    { "{\"frames\": [{\"file_path\": \"none\", " LENS MATRIX "}]}", "frame 1: file_path: there is no" },
    { "{\"frames\": [{\"file_path\": \"../a\", " LENS MATRIX "}]}", "want a file inside the folder" },
    { "{\"frames\": [{\"file_path\": 3, " LENS MATRIX "}]}", "file_path: no text" },
    { "{\"frames\": [{\"file_path\": \"a\", " MATRIX "}]}", "no focal length" },
    { "{\"frames\": [{\"file_path\": \"a\", \"fl_x\": \"x\", " MATRIX "}]}", "fl_x is no positive number" },
    { "{\"camera_model\": \"OPENCV_FISHEYE\", \"frames\": [{\"file_path\": \"a\", " LENS MATRIX "}]}",
      "OPENCV_FISHEYE" },
    { "{\"frames\": [{\"file_path\": \"a\", " LENS "\"transform_matrix\": [[1,0],[0,1]]}]}", "found 2 rows" },
    { "{\"frames\": [{\"file_path\": \"a\", " LENS "\"transform_matrix\": [[1,0,0,0],[0,1,0],[0,0,1,0]]}]}",
      "row 2 has no 4 finite numbers" },
    { "{\"frames\": [{\"file_path\": \"a\", " LENS "\"transform_matrix\": [[2,0,0,0],[0,2,0,0],[0,0,2,0]]}]}",
      "no rotation" },
    { "{\"frames\": [{\"file_path\": \"a\", \"mask_path\": \"a.png\", " LENS MATRIX "}, "
      "{\"file_path\": \"b\", " LENS MATRIX "}]}", "1 of 2 frames have a mask_path" },
    { "{\"frames\": [{\"file_path\": \"a\", " LENS MATRIX "}]}", "none to learn from" },
    { "{\"ply_file_path\": \"/etc/x.ply\", \"frames\": [{\"file_path\": \"a\", " LENS MATRIX "}, "
      "{\"file_path\": \"b\", " LENS MATRIX "}]}", "no file inside the folder" },
};

START_TEST(refused)
{
    put_image("a.png", 3, 1);
    put_image("b.png", 3, 1);
    check_error(open_text(wrong[_i].text), LT_EFORMAT, wrong[_i].reason);
}
END_TEST

START_TEST(another_shape)
{
    transforms_picture p;

    put_image("a.png", 3, 1);
    put_image("b.png", 3, 1);
    check_ok(open_text("{\"w\": 16, \"h\": 16, \"frames\": [{\"file_path\": \"a\", " LENS MATRIX "},"
                       "{\"file_path\": \"b\", " LENS MATRIX "}]}"));
    check_error(transforms_read(arena, &set.view[1], 1, false, &p), LT_EFORMAT, "another shape");
    check_error(transforms_read(arena, &set.view[1], 7, false, &p), LT_EFORMAT, "too small");
}
END_TEST

static char *make_turntable(const char *name)
{
    int n;
    char *path = lt_arena_strdup(arena, in_folder(name));

    check_ok(synth_generate(&(synth_options){ .preset = SYNTH_TURNTABLE, .out = path, .seed = 3, .frames = 8 },
                            (synth_figure[SYNTH_FIGURES]){ { 0 } }, &n));
    return path;
}

/* What we write reads back: points lie inside the masks of every view, and twice gives the same bytes. */
START_TEST(turntable)
{
    const char *a = make_turntable("a"), *b = make_turntable("b");
    int inside = 0;

    same_files(lt_path_join(arena, a, "manifest.json"), lt_path_join(arena, b, "manifest.json"));
    check_ok(transforms_open(arena, a, 8, &set));
    ck_assert(set.n == 8 && set.n_held_out == 1 && set.synthetic && set.n_points > 500 && set.colour);
    for (int v = 0; v < set.n; v++) {
        const transforms_view *view = &set.view[v];
        transforms_picture p;

        check_ok(transforms_read(arena, view, 1, false, &p));
        ck_assert(p.width == 400 && p.height == 400 && p.mask);
        for (int i = 0; i < set.n_points; i++) {
            double c[3], uv[2];

            for (int k = 0; k < 3; k++)
                c[k] = view->R_cam_world[3 * k] * (double)set.point[i][0] + view->t_cam_world[k]
                     + view->R_cam_world[3 * k + 1] * (double)set.point[i][1]
                     + view->R_cam_world[3 * k + 2] * (double)set.point[i][2];
            ck_assert(lt_camera_project(&p.camera, c, uv));
            ck_assert(uv[0] > 0 && uv[0] < 399 && uv[1] > 0 && uv[1] < 399);
            inside += p.mask[(int)(uv[1] + 0.5) * 400 + (int)(uv[0] + 0.5)] != 0;
        }
    }
    ck_assert_int_gt(inside, 9 * set.n * set.n_points / 10);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, setup, teardown);
    tcase_set_timeout(tc, 60);
    tcase_add_test(tc, conventions);
    tcase_add_test(tc, blender);
    tcase_add_loop_test(tc, refused, 0, (int)(sizeof(wrong) / sizeof(wrong[0])));
    tcase_add_test(tc, another_shape);
    tcase_add_test(tc, turntable);
}

int main(void)
{
    return run_suite("transforms", add_tests);
}
