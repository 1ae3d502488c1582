/* SPDX-License-Identifier: Apache-2.0 */
/* The window about a person, and a network for whole bodies at work in it: where it puts what it sees. */
#include "estimate/body/estimator.h"
#include "libtensor/base/parallel.h"
#include "libtensor/base/rng.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/file.h"
#include "tests/estimate/body_run.h"
#include "tests/scratch.h"
#include "vision/person_window.h"

enum { WIDTH = 320, HEIGHT = 200, W = 192, H = 256 };

static const lt_camera camera = { 400, 390, 150, 105 };
static uint8_t rgb[3 * WIDTH * HEIGHT];

/* One run for all tests */
static void setup(void)
{
    lt_rng r = lt_rng_make(5, 0);

    open_scratch();
    write_body_run(at("osx.safetensors"), "embedded", 0);
    for (size_t i = 0; i < sizeof(rgb); i++)
        rgb[i] = (uint8_t)lt_rng_below(&r, 256);
}

/* ---- the window ---- */

/* 3:4 and larger by a quarter about the same middle, whichever side is too short */
START_TEST(window_around)
{
    const double high[4] = { 100, 20, 140, 180 }, wide[4] = { 0, 0, 240, 10 };
    person_window w = person_window_around(high, W, H);

    ck_assert_double_eq_tol(w.scale, H / (160 * 1.25), 1e-12);
    ck_assert_double_eq_tol(w.scale * 120 + w.shift[0], W / 2.0, 1e-9);
    ck_assert_double_eq_tol(w.scale * 100 + w.shift[1], H / 2.0, 1e-9);
    w = person_window_around(wide, W, H);
    ck_assert_double_eq_tol(w.scale, W / (240 * 1.25), 1e-12);
    ck_assert_double_eq_tol(w.scale * 5 + w.shift[1], H / 2.0, 1e-9);
}
END_TEST

/* A picture that stays as it is, one that is moved by half a pixel, one that becomes a quarter as large */
START_TEST(window_cut)
{
    static float out[3 * W * H];
    const lt_image picture = { WIDTH, HEIGHT, 3, 8, rgb };
    const size_t plane = (size_t)W * H;
    double sum = 0;

    person_window_cut(&(person_window){ .scale = 1, .shift = { -7, 3 } }, &picture, W, H, out);
    ck_assert_float_eq(out[plane + 20 * W + 5], rgb[3 * (17 * WIDTH + 12) + 1] / 255.0f);
    ck_assert_float_eq(out[2 * W + 5], 0);                              /* above the picture */
    person_window_cut(&(person_window){ .scale = 1, .shift = { -0.5, 0 } }, &picture, W, H, out);
    ck_assert_float_eq_tol(out[0], (rgb[0] + rgb[3]) / 2.0f / 255, 1e-6f);
    person_window_cut(&(person_window){ .scale = 0.25, .shift = { -0.375, -0.375 } }, &picture, W, H, out);
    for (int i = 0; i < 16; i++)
        sum += rgb[3 * (i / 4 * WIDTH + i % 4)] / 16.0 / 255;
    ck_assert_double_eq_tol(out[0], sum, 1e-6);
    person_window_cut(&(person_window){ .scale = 1, .shift = { 1e300, 1e300 } }, &picture, W, H, out);
    ck_assert_float_eq(out[0], 0);
}
END_TEST

/* ---- the network ---- */

static void look(body_estimator *e, const float box[4], body_estimate *out)
{
    check_ok(body_estimator_run(e, rgb, WIDTH, HEIGHT, box, &camera, out));
}

/* The pelvis is seen where it is, as large as the virtual camera sees it; the parameters make the nodes. */
START_TEST(body_in_picture)
{
    const float box[4] = { 100, 10, 160, 190 };
    const double scale = H / (180 * 1.25);
    double R[BODY_JOINTS][9], shape[BODY_DIRECTIONS], joints[BODY_JOINTS][3], nodes[BODY_NODES][3], uv[2];
    double (*vertices)[3] = lt_arena_array(arena, BODY_VERTICES, sizeof(*vertices));
    body_estimator e;
    body_estimate b;
    lt_rig rig;

    check_ok(body_estimator_open(at("osx.safetensors"), &e));
    ck_assert(run_body_is_embedded(&e.body));
    look(&e, box, &b);
    ck_assert(lt_camera_project(&camera, b.pelvis, uv));
    for (int k = 0; k < 2; k++)
        ck_assert_double_eq_tol(uv[k], b.nodes2d[0][k], 1e-3);
    ck_assert_double_eq_tol(b.pelvis[2], sqrt(400 * 390) * scale / 5000 * compiled_output(&e.c, "camera")[2], 1e-4);
    for (int j = 0; j < BODY_JOINTS; j++)
        lt_rot_from_axis_angle(b.pose[j], R[j]);
    memcpy(shape, b.shape, sizeof(b.shape));
    memcpy(shape + BODY_SHAPES, b.expression, sizeof(b.expression));
    rig = synth_body_rig(e.body.model);
    lt_rig_pose(&rig, R[0], shape, (double[3]){ 0 }, vertices[0], joints[0]);
    body_nodes(vertices[0], joints[0], nodes);
    for (int i = 0; i < BODY_NODES; i++)
        for (int k = 0; k < 3; k++)
            ck_assert_double_eq_tol(nodes[i][k] - nodes[0][k], b.nodes[i][k], 1e-4);
    body_estimator_close(&e);
}
END_TEST

/* The same bits whatever was looked at before, and on any number of threads */
START_TEST(same_bits)
{
    const float box[4] = { -40, 10, 90, 210 }, other[4] = { 100, 10, 160, 190 };
    body_estimate a, b;
    body_estimator e;

    memset(&a, 0, sizeof(a));
    memset(&b, 0, sizeof(b));
    lt_set_threads(1);
    check_ok(body_estimator_open(at("osx.safetensors"), &e));
    look(&e, box, &a);
    look(&e, other, &b);
    ck_assert(memcmp(&a, &b, sizeof(a)) != 0);
    lt_set_threads(3);
    look(&e, box, &b);
    ck_assert(memcmp(&a, &b, sizeof(a)) == 0);
    body_estimator_close(&e);
}
END_TEST

static void expect_none(const char *path, lt_status st, const char *line)
{
    body_estimator e;

    check_error(body_estimator_open(path, &e), st, line);
    body_estimator_close(&e);
}

START_TEST(refused)
{
    const float none[4] = { 10, 10, 10, 40 }, lost[4] = { 10, 10, NAN, 40 };
    const float box[4] = { 100, 10, 160, 190 };
    body_estimator e;
    body_estimate b;

    write_body_run(at("far.safetensors"), "/none/SMPLX_NEUTRAL.npz", 0);
    write_body_run(at("damaged.safetensors"), "embedded", 3e38f);
    put_file(at("text"), "not a model", 11);
    expect_none(at("none"), LT_EIO, "none: No such file");
    expect_none(at("text"), LT_EFORMAT, "text: ");
    expect_none(at("far.safetensors"), LT_EIO, "/none/SMPLX_NEUTRAL.npz: no such file");
    check_ok(body_estimator_open(at("damaged.safetensors"), &e));
    check_error(body_estimator_run(&e, rgb, WIDTH, HEIGHT, box, &camera, &b), LT_ENUMERIC,
                "damaged.safetensors: the model's answer is not finite");
    check_error(body_estimator_run(&e, rgb, WIDTH, HEIGHT, none, &camera, &b), LT_EINVAL,
                "the person's box 10,10,10,40 is empty");
    check_error(body_estimator_run(&e, rgb, WIDTH, HEIGHT, lost, &camera, &b), LT_EINVAL, "is empty");
    body_estimator_close(&e);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_set_timeout(t, 120);
    tcase_add_unchecked_fixture(t, setup, close_scratch);
    tcase_add_test(t, window_around);
    tcase_add_test(t, window_cut);
    tcase_add_test(t, body_in_picture);
    tcase_add_test(t, same_bits);
    tcase_add_test(t, refused);
}

int main(void)
{
    return run_suite("body_estimator", add_tests);
}
