/* SPDX-License-Identifier: Apache-2.0 */
/* A frame as Gaussians draw it: turned once around, beside the truth, and its surfaces. */
#include "estimate/posed/turntable.h"
#include "libtensor/base/arena.h"
#include "tests/suite.h"

#include <math.h>

enum { SIDE = 64, VIEWS = 4, MIDDLE = 32, OFF = 16 };

/* Red at the left and blue at the right, a metre away, 16 pixels off the middle: a hand of one Gaussian, an object */
static void make_frame(lt_splat splat[2], posed_frame *f)
{
    for (int i = 0; i < 2; i++) {
        const float side = i ? 1 : -1;

        splat[i] = (lt_splat){ .x = { 0.16f * side, 0, 1 }, .dc = { -1.77f * side, -1.77f, 1.77f * side }, .opacity = 9,
                               .scale = { logf(0.03f), logf(0.03f), logf(0.03f) }, .rotation = { 1 } };
    }
    *f = (posed_frame){ .name = "seen/0001", .part = { "hand-01", "object-05" }, .width = SIDE, .height = SIDE,
                        .camera = { 100, 100, MIDDLE, MIDDLE }, .near = 0.2, .splat = splat, .n = { 1, 1 } };
}

typedef struct {
    uint8_t rgb[VIEWS][SIDE][SIDE][3];
    int n, stop_at;
} album;

static lt_status keep(void *ctx, const uint8_t *rgb)
{
    album *a = ctx;

    if (a->n == a->stop_at)
        return lt_error(LT_ESTOPPED, "stopped");
    memcpy(a->rgb[a->n++], rgb, sizeof(a->rgb[0]));
    return LT_OK;
}

static void expect_colour(const uint8_t rgb[3], bool red, bool blue)
{
    ck_assert_int_eq(rgb[0] > 200, red);
    ck_assert_int_eq(rgb[2] > 200, blue);
    ck_assert_int_lt(rgb[1], 60);
}

/* As the camera sees it; the blue one in front of the red one; the other way round; the red one in front. */
START_TEST(turned)
{
    lt_splat splat[2];
    posed_frame f;
    album *a = calloc(1, sizeof(*a));

    a->stop_at = -1;
    make_frame(splat, &f);
    check_ok(turntable_draw(&f, VIEWS, keep, a));
    ck_assert_int_eq(a->n, VIEWS);
    for (int i = 0; i < VIEWS; i += 2) {
        expect_colour(a->rgb[i][MIDDLE][MIDDLE - OFF], i == 0, i != 0);
        expect_colour(a->rgb[i][MIDDLE][MIDDLE + OFF], i != 0, i == 0);
        expect_colour(a->rgb[i][MIDDLE][MIDDLE], false, false);
    }
    expect_colour(a->rgb[1][MIDDLE][MIDDLE], false, true);
    expect_colour(a->rgb[3][MIDDLE][MIDDLE], true, false);
    free(a);
}
END_TEST

/* Whoever looks can stop it. */
START_TEST(stopped)
{
    lt_splat splat[2];
    posed_frame f;
    album *a = calloc(1, sizeof(*a));

    a->stop_at = 1;
    make_frame(splat, &f);
    check_error(turntable_draw(&f, VIEWS, keep, a), LT_ESTOPPED, "stopped");
    ck_assert_int_eq(a->n, 1);
    free(a);
}
END_TEST

START_TEST(beside)
{
    const uint8_t truth[2][2][3] = { { { 1 }, { 2 } }, { { 3 }, { 4 } } };
    const uint8_t drawn[2][2][3] = { { { 5 }, { 6 } }, { { 7 }, { 8 } } };
    const posed_frame f = { .width = 2, .height = 2, .truth = truth[0][0], .drawn = drawn[0][0] };
    static const uint8_t want[2][4] = { { 1, 2, 5, 6 }, { 3, 4, 7, 8 } };
    uint8_t out[2][4][3];

    posed_beside(&f, out[0][0]);
    for (int i = 0; i < 8; i++)
        ck_assert_int_eq(out[i / 4][i % 4][0], want[i / 4][i % 4]);
}
END_TEST

/* The hand has one face, the object is not opaque enough for any, and what is neither has no memory. */
static lt_status surface(const posed_frame *f, int part, lt_opacity_rule rule, double iso, lt_arena *arena,
                         lt_mesh *out)
{
    (void)f, (void)rule, (void)iso, (void)arena;
    *out = (lt_mesh){ .n_vertices = 3, .n_faces = 1 };
    return part == POSED_HAND ? LT_OK
        : part == POSED_OBJECT ? lt_error(LT_EINVAL, "nothing is opaque enough") : lt_error(LT_ENOMEM, "no memory");
}

START_TEST(surfaces)
{
    const posed_frame f = { .surface = surface };
    lt_arena *arena = lt_arena_new();
    lt_mesh m;

    check_ok(posed_surface(&f, POSED_HAND, LT_OPACITY_MEAN, POSED_ISO, arena, &m));
    ck_assert_int_eq(m.n_faces, 1);
    check_ok(posed_surface(&f, POSED_OBJECT, LT_OPACITY_MEAN, POSED_ISO, arena, &m));
    ck_assert_int_eq(m.n_faces + m.n_vertices, 0);
    check_error(posed_surface(&f, POSED_PARTS, LT_OPACITY_MEAN, POSED_ISO, arena, &m), LT_ENOMEM, "no memory");
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_test(tc, turned);
    tcase_add_test(tc, stopped);
    tcase_add_test(tc, beside);
    tcase_add_test(tc, surfaces);
}

int main(void)
{
    return run_suite("posed", add_tests);
}
