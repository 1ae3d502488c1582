/* SPDX-License-Identifier: Apache-2.0 */
/* Which samples show a grasp, and depth beside a crop. */
#include "assets/hand/hand.h"
#include "data/contact.h"
#include "libtensor/geometry/hand/layer.h"
#include "tests/suite.h"
#include "vision/depth.h"

#include <math.h>
#include <string.h>

/* ---- contact: a flat square 0, 4, 6 ... mm above the hand's highest point --------------------------------- */

enum { SAMPLES = 6, BROKEN = 4 };

static const float gap_mm[SAMPLES] = { 0, 4, 6, 4, 0, 30 };
static lt_hand_model *hand;
static double top;                              /* of the flat hand above its wrist */
static bool fails;

static lt_status annotation(const dataset *d, int64_t index, lt_arena *arena, dataset_sample *s)
{
    (void)d, (void)arena;
    if (index == BROKEN && fails)
        return lt_error(LT_EFORMAT, "sample %lld is broken", (long long)index);
    *s = (dataset_sample){
        .flags = SAMPLE_HAND_POSE | SAMPLE_ROOT | SAMPLE_OBJECT, .root = { 0.1f, -0.2f, 0.7f },
        .R = { -1, 0, 0, 0, 1, 0, 0, 0, -1 },   /* half a turn: the square looks down */
    };
    for (int j = 0; j < LT_HAND_JOINTS; j++)
        s->rotation[j][0] = s->rotation[j][4] = s->rotation[j][8] = 1;
    memcpy(s->t, s->root, sizeof(s->t));
    s->t[1] -= (float)top + gap_mm[index] / 1e3f;
    if (index == 3)
        s->object = -1;
    if (index == BROKEN)
        s->flags &= ~(unsigned)SAMPLE_HAND_POSE;
    return LT_OK;
}

static void measure_hand(void)
{
    double R[LT_HAND_JOINTS * 9] = { 0 }, beta[LT_HAND_BETAS] = { 0 };
    double vertices[LT_HAND_VERTICES][3], joints[LT_HAND_JOINTS][3];

    for (int j = 0; j < LT_HAND_JOINTS; j++)
        R[9 * j] = R[9 * j + 4] = R[9 * j + 8] = 1;
    lt_hand_pose(hand, R, beta, NULL, vertices[0], joints[0]);
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        top = fmax(top, joints[0][1] - vertices[v][1]);
}

START_TEST(close_hands_are_kept)
{
    float corner[4][3] = { { -1, 0, -1 }, { 1, 0, -1 }, { 1, 0, 1 }, { -1, 0, 1 } };
    int face[2][3] = { { 0, 1, 2 }, { 0, 2, 3 } };
    const dataset_object object = {
        .name = "square", .mesh = { .vertex = corner, .n_vertices = 4, .face = face, .n_faces = 2 },
    };
    const dataset_ops ops = { .annotation = annotation };
    const dataset d = { .ops = &ops, .root = "made up", .count = SAMPLES, .objects = &object, .n_objects = 1 };
    lt_arena *arena = lt_arena_new();
    const int64_t *index;
    int64_t n;

    ck_assert_int_eq(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand), LT_OK);
    measure_hand();
    check_ok(contact_select(&d, hand, 0, SAMPLES, 5e-3, arena, &index, &n));
    ck_assert_int_eq(n, 2);
    ck_assert_int_eq(index[0], 0);
    ck_assert_int_eq(index[1], 1);
    ck_assert_int_eq(contact_select(&d, hand, 0, SAMPLES, 0.1, arena, &index, &n), LT_OK);
    ck_assert_int_eq(n, 4);
    ck_assert_int_eq(contact_select(&d, hand, 0, 0, 0.1, arena, &index, &n), LT_OK);
    ck_assert_int_eq(n, 0);
    fails = true;
    ck_assert_int_eq(contact_select(&d, hand, 0, SAMPLES, 5e-3, arena, &index, &n), LT_EFORMAT);
    ck_assert_str_eq(lt_last_error(), "sample 4 is broken");
    lt_arena_free(arena);
}
END_TEST

/* ---- depth -------------------------------------------------------------------------------------------------- */

enum { W = 12, H = 10, S = 6 };

static const double identity[6] = { 1, 0, 0, 0, 1, 0 };
static float depth[W * H], metres[S * S], crop[S * S], scratch[S * S];

START_TEST(depth_about_its_middle)
{
    for (int i = 0; i < W * H; i++)
        depth[i] = 0.8f;
    depth[0] = 0.7f, depth[1] = 2, depth[2] = 0, depth[W] = 0.1f, depth[W + 1] = NAN;
    depth_crop(identity, depth, NULL, W, H, metres, crop, S, scratch);
    ck_assert_float_eq_tol(crop[0], -1.f / 3, 1e-6f);
    ck_assert_float_eq(crop[1], 1);
    ck_assert_float_eq(crop[2], 1);
    ck_assert_float_eq(crop[S], -1);
    ck_assert_float_eq(crop[S + 1], 1);
    ck_assert_float_eq(crop[S * S - 1], 0);
}
END_TEST

START_TEST(depth_about_the_object)
{
    uint8_t mask[W * H] = { 0 };

    for (int i = 0; i < W * H; i++)
        depth[i] = 0.8f;
    mask[0] = mask[1] = mask[2] = 1;
    depth[0] = 0.5f, depth[1] = 0.6f, depth[2] = 0.7f;
    depth_crop(identity, depth, mask, W, H, metres, crop, S, scratch);
    ck_assert_float_eq_tol(crop[0], -1.f / 3, 1e-6f);
    ck_assert_float_eq_tol(crop[1], 0, 1e-6f);
    ck_assert_float_eq_tol(crop[S], 2.f / 3, 1e-6f);
    depth[0] = depth[1] = depth[2] = 0;         /* nothing known there: the middle counts */
    depth_crop(identity, depth, mask, W, H, metres, crop, S, scratch);
    ck_assert_float_eq(crop[0], 1);
    ck_assert_float_eq_tol(crop[S], 0, 1e-6f);
}
END_TEST

START_TEST(unknown_depth)
{
    const double beside[6] = { 1, 0, 100, 0, 1, 0 };

    for (int i = 0; i < W * H; i++)
        depth[i] = 0.8f;
    depth_crop(identity, NULL, NULL, W, H, metres, crop, S, scratch);
    for (int i = 0; i < S * S; i++)
        ck_assert_float_eq(crop[i], 1);
    depth_crop(beside, depth, NULL, W, H, metres, crop, S, scratch);
    for (int i = 0; i < S * S; i++)
        ck_assert_float_eq(crop[i], 1);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_test(c, close_hands_are_kept);
    tcase_add_test(c, depth_about_its_middle);
    tcase_add_test(c, depth_about_the_object);
    tcase_add_test(c, unknown_depth);
}

int main(void)
{
    return run_suite("contact", add_tests);
}
