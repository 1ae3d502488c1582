/* SPDX-License-Identifier: Apache-2.0 */
/* Meshes drawn over pictures: what is nearer, how it is lit, and what is left out. */
#include "tests/suite.h"
#include "vision/drawing/draw.h"

#include <math.h>
#include <string.h>

enum { SIDE = 9, MIDDLE = 4 };

static const lt_camera camera = { .fx = 4, .fy = 4, .cx = MIDDLE, .cy = MIDDLE };
static float nearness[SIDE * SIDE];
static draw_canvas canvas;
static lt_arena *arena;

static void clear(void)
{
    memset(canvas.rgb, 0, SIDE * SIDE * sizeof(*canvas.rgb));
    memset(nearness, 0, sizeof(nearness));
}

static void start(void)
{
    arena = lt_arena_new();
    canvas = draw_canvas_new(arena, SIDE, SIDE, (draw_color){ 0, 0, 0 });
    clear();
}

static void stop(void)
{
    lt_arena_free(arena);
}

/* A square with corners one metre beside the axis, at these distances on its left and right side, in one colour */
static void draw_square(float left, float right, float red, float green)
{
    float vertex[4][3] = { { -1, -1, left }, { 1, -1, right }, { 1, 1, right }, { -1, 1, left } };
    float color[4][3];
    int32_t face[2][3] = { { 0, 1, 2 }, { 0, 2, 3 } };
    const lt_mesh m = { .vertex = vertex, .face = face, .color = color, .n_vertices = 4, .n_faces = 2 };

    for (int i = 0; i < 4; i++)
        color[i][0] = red, color[i][1] = green, color[i][2] = 0;
    draw_mesh(&canvas, nearness, &camera, &m);
}

static const uint8_t *at(int x, int y)
{
    return canvas.rgb[y * SIDE + x];
}

/* At distance 2 a metre is two pixels; a face that is seen from the front has the whole light in the middle. */
START_TEST(a_square)
{
    draw_square(2, 2, 1, 0);
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++)
            ck_assert_int_eq(at(x, y)[0] > 0, x >= 2 && x <= 6 && y >= 2 && y <= 6);
    ck_assert_int_eq(at(MIDDLE, MIDDLE)[1], 0);
    ck_assert_float_eq_tol(nearness[MIDDLE * SIDE + MIDDLE], 0.5f, 1e-6f);
}
END_TEST

/* What is nearer stays, in whichever order they are drawn; the other one is seen around it. */
START_TEST(the_nearer_one)
{
    for (int order = 0; order < 2; order++) {
        clear();
        for (int k = 0; k < 2; k++)
            k == order ? draw_square(1, 1, 1, 0) : draw_square(4, 4, 0, 1);
        ck_assert(at(MIDDLE, MIDDLE)[0] > 0 && at(MIDDLE, MIDDLE)[1] == 0);
    }
    clear();
    draw_square(4, 4, 0, 1);
    draw_square(8, 1, 1, 0);                    /* through the other one */
    ck_assert(at(3, MIDDLE)[1] > 0 && at(3, MIDDLE)[0] == 0);
    ck_assert(at(5, MIDDLE)[0] > 0 && at(5, MIDDLE)[1] == 0);
}
END_TEST

START_TEST(left_out)
{
    static const float bad[] = { 0, -1, NAN, INFINITY };

    for (size_t i = 0; i < LT_COUNT(bad); i++)
        draw_square(2, bad[i], 1, 1);
    for (int i = 0; i < SIDE * SIDE; i++)
        ck_assert_int_eq(canvas.rgb[i][0], 0);
    draw_square(1e-30f, 1e-30f, 1, 1);          /* corners far outside of any picture */
    ck_assert_int_gt(at(0, 0)[0], 0);
    ck_assert_int_gt(at(SIDE - 1, SIDE - 1)[0], 0);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_checked_fixture(c, start, stop);
    tcase_add_test(c, a_square);
    tcase_add_test(c, the_nearer_one);
    tcase_add_test(c, left_out);
}

int main(void)
{
    return run_suite("draw", add_tests);
}
