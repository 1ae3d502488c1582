/* SPDX-License-Identifier: Apache-2.0 */
/* Views turned by quarters: pixels, boxes, camera and depth go together, and results come back. */
#include "pipeline/internal.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "tests/suite.h"

#include <stdlib.h>

enum { WIDTH = 90, HEIGHT = 70, POINTS = LT_HAND_KEYPOINTS };

static uint8_t rgb[3 * WIDTH * HEIGHT];
static float depth[WIDTH * HEIGHT];
static lt_arena *arena;
static predict_result *found, *turned;
static const predict_view view = {
    .path = "a picture", .rgb = rgb, .depth = depth, .width = WIDTH, .height = HEIGHT, .camera = { 80, 82, 44, 33 },
    .hand_box = { 40, 30, 50, 45 }, .object_box = { 38, 32, 52, 44 },
};

/* What the hand's 2D and 3D points are upright, all in the box */
static void find(predict_result *r)
{
    for (int i = 0; i < POINTS; i++) {
        const double p[3] = { 0.01 * (i % 5) - 0.02, 0.012 * (i / 5) - 0.01, 0.6 + 0.01 * i };
        double uv[2];

        lt_camera_project(&view.camera, p, uv);
        for (int d = 0; d < 3; d++)
            r->e.joints[i][d] = r->e.vertices[i][d] = (float)p[d];
        for (int d = 0; d < 2; d++)
            r->heatmap2d[i][d] = r->control2d[i][d] = (float)uv[d];
    }
}

/* A turn clockwise, seen from the camera, of what is before it */
static void turn_of(int quarters, double R[9])
{
    const double aa[3] = { 0, 0, quarters * M_PI / 2 };

    lt_rot_from_axis_angle(aa, R);
}

static void turned_point(int quarters, const float p[3], double out[3])
{
    const double from[3] = { p[0], p[1], p[2] };
    double R[9];

    turn_of(quarters, R);
    lt_mat3_mulvec(R, from, out);
}

/* Where the turned camera sees the turned point, the turned picture has the pixel and the depth that were there. */
START_TEST(picture_and_camera)
{
    predict_view out;
    predict_turn t;

    check_ok(predict_view_turn(arena, &view, _i, &out, &t));
    for (int i = 0; i < POINTS; i++) {
        const int u = (int)lroundf(found->heatmap2d[i][0]), v = (int)lroundf(found->heatmap2d[i][1]);
        const double pixel[2] = { u, v };
        double p[3], q[3], uv[2];
        int64_t at;

        lt_camera_backproject(&view.camera, pixel, 0.7, p);
        turned_point(_i, (const float[3]){ (float)p[0], (float)p[1], (float)p[2] }, q);
        lt_camera_project(&out.camera, q, uv);
        at = lrint(uv[1]) * out.width + lrint(uv[0]);
        ck_assert_double_eq_tol(uv[0], rint(uv[0]), 1e-4);
        ck_assert_mem_eq(out.rgb + 3 * at, rgb + 3 * (v * WIDTH + u), 3);
        ck_assert_float_eq(out.depth[at], depth[v * WIDTH + u]);
        ck_assert(uv[0] >= (double)out.object_box.x0 - 2 && uv[0] <= (double)out.object_box.x1 + 2);
    }
    ck_assert_float_eq(out.hand_box.x1 - out.hand_box.x0, _i % 2 ? 15 : 10);
    ck_assert_int_eq(out.width, _i % 2 ? t.height : t.width);
    ck_assert_int_le(t.width, WIDTH);
}
END_TEST

START_TEST(back)
{
    const float R[9] = { 0.36f, 0.48f, -0.8f, -0.8f, 0.6f, 0, 0.48f, 0.64f, 0.6f };
    const lt_pose object = { .R = { 0.36, 0.48, -0.8, -0.8, 0.6, 0, 0.48, 0.64, 0.6 }, .t = { 0.1, -0.2, 0.7 } };
    lt_pose turn = { .t = { 0 } };
    predict_view out;
    predict_turn t;

    check_ok(predict_view_turn(arena, &view, _i, &out, &t));
    turn_of(_i, turn.R);
    for (int i = 0; i < POINTS; i++) {
        double p[3], uv[2];

        turned_point(_i, found->e.joints[i], p);
        lt_camera_project(&out.camera, p, uv);
        for (int d = 0; d < 3; d++)
            turned->e.joints[i][d] = turned->e.vertices[i][d] = (float)p[d];
        for (int d = 0; d < 2; d++)
            turned->heatmap2d[i][d] = turned->control2d[i][d] = (float)uv[d];
    }
    for (int k = 0; k < 9; k++)
        turned->e.rotation[0][k] = R[k];
    turned->e.object = lt_pose_compose(&turn, &object);
    predict_turn_back(&t, turned);
    for (int i = 0; i < POINTS; i++) {
        for (int d = 0; d < 3; d++) {
            ck_assert_float_eq_tol(turned->e.joints[i][d], found->e.joints[i][d], 1e-6f);
            ck_assert_float_eq_tol(turned->e.vertices[i][d], found->e.vertices[i][d], 1e-6f);
        }
        for (int d = 0; d < 2; d++) {
            ck_assert_float_eq_tol(turned->heatmap2d[i][d], found->heatmap2d[i][d], 1e-4f);
            ck_assert_float_eq_tol(turned->control2d[i][d], found->control2d[i][d], 1e-4f);
        }
    }
    for (int k = 0; k < 9; k++)
        ck_assert_double_eq_tol(turned->e.object.R[k], object.R[k], 1e-9);
    for (int k = 0; k < 3; k++) {
        double undone = 0;

        for (int j = 0; j < 3; j++)
            undone += turn.R[3 * j] * (double)R[3 * j + k];
        ck_assert_double_eq_tol(turned->e.object.t[k], object.t[k], 1e-9);
        ck_assert_double_eq_tol((double)turned->e.rotation[0][k], undone, 1e-6);
    }
}
END_TEST

/* What was not turned stays, whatever it is. */
START_TEST(not_turned)
{
    const predict_turn none = { 0 };
    predict_result before = *found;

    predict_turn_back(&none, found);
    ck_assert_mem_eq(&before, found, sizeof(before));
}
END_TEST

static void setup(void)
{
    arena = lt_arena_new();
    found = calloc(1, sizeof(*found));
    turned = calloc(1, sizeof(*turned));
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        depth[i] = 0.5f + 1e-4f * (float)i;
        for (int c = 0; c < 3; c++)
            rgb[3 * i + c] = (uint8_t)(i * (7 + c) / 3);
    }
    find(found);
}

static void teardown(void)
{
    free(turned);
    free(found);
    lt_arena_free(arena);
}

static void add_tests(TCase *c)
{
    tcase_add_checked_fixture(c, setup, teardown);
    tcase_add_loop_test(c, picture_and_camera, 1, 4);
    tcase_add_loop_test(c, back, 1, 4);
    tcase_add_test(c, not_turned);
}

int main(void)
{
    return run_suite("turn", add_tests);
}
