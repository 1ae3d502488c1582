/* SPDX-License-Identifier: Apache-2.0 */
/* Samples in the mirror: what is projected there is the picture of before, turned over. */
#include "data/mirror.h"
#include "libtensor/geometry/rotation.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

enum { W = 64, H = 48 };

static float vertex[4][3] = { { 0, 0, 0 }, { .08f, 0, 0 }, { 0, .06f, 0 }, { 0, 0, .1f } };
static int32_t face[4][3] = { { 0, 2, 1 }, { 0, 1, 3 }, { 0, 3, 2 }, { 1, 2, 3 } };

static uint8_t rgb[H][W][3];
static float depth[H][W];

/* A sample with numbers of no symmetry, and a dataset of one object. */
static dataset_sample sample(dataset_object *o, dataset *d)
{
    dataset_sample s = { .name = "a/0", .flags = SAMPLE_HAND_POSE | SAMPLE_JOINTS | SAMPLE_ROOT | SAMPLE_HAND_BOX |
                                                 SAMPLE_OBJECT | SAMPLE_DEPTH,
                         .width = W, .height = H, .rgb = &rgb[0][0][0], .depth = &depth[0][0],
                         .camera = { 60, 61, 30.5, 22 }, .t = { .02f, -.01f, .5f }, .hand_box = { 3, 5, 40, 30 },
                         .root = { .1f, .2f, .6f } };
    double R[9];

    *o = (dataset_object){ .mesh = { .n_vertices = 4, .n_faces = 4, .vertex = vertex, .face = face } };
    *d = (dataset){ .objects = o, .n_objects = 1 };
    for (int i = 0; i < 21; i++)
        for (int k = 0; k < 3; k++) {
            o->control[i][k] = .01f * (float)((7 * i + 3 * k) % 9);
            s.joints[i][k] = (k == 2 ? .6f : 0) + .003f * (float)((5 * i + k) % 11);
        }
    lt_rot_from_axis_angle((const double[]){ .3, -.7, 1.1 }, R);
    for (int i = 0; i < 9; i++)
        s.R[i] = s.rotation[0][i] = s.rotation[7][i] = (float)R[i];
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            rgb[y][x][0] = (uint8_t)x;
            rgb[y][x][1] = (uint8_t)y;
            rgb[y][x][2] = (uint8_t)(x + y);
            depth[y][x] = (float)(x + 100 * y);
        }
    ck_assert_int_eq(dataset_project(d, &s), LT_OK);
    return s;
}

START_TEST(projects_to_the_mirrored_pixels)
{
    dataset_object o;
    dataset d;
    dataset_sample before = sample(&o, &d), s = before, again;

    mirror_sample(&s, rgb[0][0], depth[0], NULL);
    ck_assert(s.flags & SAMPLE_MIRRORED);
    again = s;
    ck_assert_int_eq(dataset_project(&d, &again), LT_OK);
    for (int i = 0; i < 21; i++) {
        ck_assert_float_eq_tol(s.joints2d[i][0], W - 1 - before.joints2d[i][0], 1e-4f);
        ck_assert_float_eq_tol(again.joints2d[i][0], s.joints2d[i][0], 1e-4f);
        ck_assert_float_eq_tol(again.joints2d[i][1], before.joints2d[i][1], 1e-4f);
        ck_assert_float_eq_tol(again.control2d[i][0], s.control2d[i][0], 1e-4f);
        ck_assert_float_eq_tol(again.control2d[i][1], before.control2d[i][1], 1e-4f);
    }
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            ck_assert_int_eq(rgb[y][x][0], W - 1 - x);
            ck_assert_int_eq(rgb[y][x][2], W - 1 - x + y);
            ck_assert_float_eq(depth[y][x], (float)(W - 1 - x + 100 * y));
        }
    ck_assert_float_eq(s.hand_box[0], W - 1 - 40);
    ck_assert_float_eq(s.hand_box[2], W - 1 - 3);
    ck_assert_float_eq(s.root[0], -.1f);
}
END_TEST

/* (a, b, c) -> (a, -b, -c), and still a rotation. */
START_TEST(turns_rotations_as_axis_angles)
{
    double aa[3] = { .3, -.7, 1.1 }, want[9];
    dataset_object o;
    dataset d;
    dataset_sample s = sample(&o, &d);

    mirror_sample(&s, NULL, NULL, NULL);
    lt_mirror_axis_angle(aa);
    lt_rot_from_axis_angle(aa, want);
    for (int i = 0; i < 9; i++) {
        ck_assert_float_eq_tol(s.R[i], (float)want[i], 1e-6f);
        ck_assert_float_eq_tol(s.rotation[7][i], (float)want[i], 1e-6f);
    }
}
END_TEST

START_TEST(silhouette_turns_over)
{
    dataset_object o;
    dataset d;
    lt_arena *arena = lt_arena_new();
    dataset_sample s = sample(&o, &d);
    const uint8_t *before;
    int covered = 0;

    ck_assert_int_eq(dataset_draw_silhouette(&d, arena, &s), LT_OK);
    before = s.silhouette;
    mirror_sample(&s, NULL, NULL, NULL);
    ck_assert_int_eq(dataset_draw_silhouette(&d, arena, &s), LT_OK);
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            ck_assert_int_eq(s.silhouette[y * W + x], before[y * W + W - 1 - x]);
            covered += before[y * W + x];
        }
    ck_assert_int_gt(covered, 20);
    lt_arena_free(arena);
}
END_TEST

START_TEST(twice_is_nothing)
{
    dataset_object o;
    dataset d;
    dataset_sample before = sample(&o, &d), s = before;
    uint8_t pixels[H][W][3];

    memcpy(pixels, rgb, sizeof(pixels));
    mirror_sample(&s, rgb[0][0], depth[0], NULL);
    mirror_sample(&s, rgb[0][0], depth[0], NULL);
    ck_assert_mem_eq(pixels, rgb, sizeof(pixels));
    ck_assert_int_eq(s.flags, before.flags);
    ck_assert_mem_eq(s.joints, before.joints, sizeof(s.joints));
    ck_assert_mem_eq(s.R, before.R, sizeof(s.R));
    ck_assert_mem_eq(s.rotation, before.rotation, sizeof(s.rotation));
    ck_assert_double_eq(s.camera.cx, before.camera.cx);
    for (int i = 0; i < 21; i++)
        ck_assert_float_eq_tol(s.joints2d[i][0], before.joints2d[i][0], 1e-5f);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_test(c, projects_to_the_mirrored_pixels);
    tcase_add_test(c, turns_rotations_as_axis_angles);
    tcase_add_test(c, silhouette_turns_over);
    tcase_add_test(c, twice_is_nothing);
}

int main(void)
{
    return run_suite("mirror", add_tests);
}
