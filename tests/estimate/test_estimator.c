/* SPDX-License-Identifier: Apache-2.0 */
/* From a network's votes to an object's pose: a model whose outputs are known, of more cells than any in use. */
#include "estimate/estimator.h"
#include "estimate/protocol.h"
#include "libtensor/base/rng.h"
#include "libtensor/geometry/rotation.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CELLS = 128, PLACES = CELLS * CELLS, SIDE = 256, VOTES = 10 };

static const double R_true[9] = { 0.36, 0.48, -0.8, -0.8, 0.6, 0, 0.48, 0.64, 0.6 }, t_true[3] = { 0.03, -0.02, 0.6 };
static const lt_camera camera = { 600, 600, 320, 240 };

/* The crop has half the image's resolution, and begins at (64, -16). */
static const float affine[6] = { 0.5f, 0, -32, 0, 0.5f, 8 };

static float conf[LT_BOX_POINTS][PLACES], x[LT_BOX_POINTS][PLACES], y[LT_BOX_POINTS][PLACES];
static float control[LT_BOX_POINTS][3];
static bool hand_alone, depth_fit;
static float surface[800][3], normal[800][3];

static void add(model_record *r, const char *name, lt_shape shape, const float *values)
{
    lt_real *zeros = calloc((size_t)lt_shape_numel(&shape), sizeof(*zeros));

    model_port_add(&r->outputs, name, lt_output(lt_constant(r->g, LT_F32, shape, values ? values : zeros), name));
    free(zeros);
}

static void record(const model *m, bool losses, model_record *r)
{
    const lt_shape cells = LT_SHAPE(1, LT_BOX_POINTS, CELLS, CELLS);

    (void)m;
    (void)losses;
    add(r, "joints2d", LT_SHAPE(1, LT_HAND_KEYPOINTS, 2), NULL);
    add(r, "peak", LT_SHAPE(1, LT_HAND_KEYPOINTS), NULL);
    add(r, "rotation", LT_SHAPE(1, LT_HAND_JOINTS, 3, 3), NULL);
    add(r, "beta", LT_SHAPE(1, LT_HAND_BETAS), NULL);
    add(r, "vertices", LT_SHAPE(1, LT_HAND_VERTICES, 3), NULL);
    add(r, "joints", LT_SHAPE(1, LT_HAND_KEYPOINTS, 3), NULL);
    add(r, "conf", cells, conf[0]);
    add(r, "point_x", cells, x[0]);
    add(r, "point_y", cells, y[0]);
}

/* Ten good votes a point in any places, noise_px off in the image, among cells that are worse and say nothing. */
static void cast_votes(double noise_px)
{
    lt_rng r = lt_rng_make(3, 0);
    const lt_box box = { { -.05, -.03, -.08 }, { .05, .03, .08 } };
    double points[LT_BOX_POINTS][3], uv[2];

    lt_box21(&box, points);
    for (int v = 0; v < LT_BOX_POINTS; v++) {
        double p[3];

        lt_rigid_apply(R_true, t_true, points[v], p);
        lt_camera_project(&camera, p, uv);
        for (int d = 0; d < 3; d++)
            control[v][d] = (float)points[v][d];
        for (int i = 0; i < PLACES; i++) {
            conf[v][i] = (float)lt_rng_range(&r, 0.5, 0.7);
            x[v][i] = y[v][i] = 0;
        }
        for (int k = 0; k < VOTES; k++) {
            const int i = PLACES - 1 - (int)lt_rng_below(&r, PLACES / VOTES) * VOTES - k;      /* all different */

            conf[v][i] = (float)lt_rng_range(&r, 0.8, 1);
            x[v][i] = (float)((affine[0] * (uv[0] + noise_px * lt_rng_normal(&r)) + affine[2]) / SIDE);
            y[v][i] = (float)((affine[4] * (uv[1] + noise_px * lt_rng_normal(&r)) + affine[5]) / SIDE);
        }
    }
}

/* Points of the box's faces, three of which the camera sees: nothing of the rest, or of what is behind, was
 * measured. */
static void measure(hand_object_batch *b)
{
    const double half[3] = { .05, .03, .08 };
    lt_rng r = lt_rng_make(4, 0);

    for (int i = 0; i < 800; i++) {
        double n[3] = { 0 }, point[3], p[3], turned[3], uv[2];
        const int axis = i % 3;

        n[axis] = i % 2 ? 1 : -1;
        for (int d = 0; d < 3; d++) {
            point[d] = half[d] * (d == axis ? n[d] : lt_rng_range(&r, -1, 1));
            surface[i][d] = (float)point[d];
            normal[i][d] = (float)n[d];
        }
        lt_rigid_apply(R_true, t_true, point, p);
        lt_rigid_apply(R_true, (const double[3]){ 0 }, n, turned);
        if (turned[0] * p[0] + turned[1] * p[1] + turned[2] * p[2] >= 0)
            continue;
        lt_camera_project(&camera, p, uv);
        uv[0] = affine[0] * uv[0] + affine[2], uv[1] = affine[4] * uv[1] + affine[5];
        for (int v = (int)uv[1] - 1; v <= (int)uv[1] + 1; v++)
            for (int u = (int)uv[0] - 1; u <= (int)uv[0] + 1; u++)
                b->metres[v * SIDE + u] = (float)p[2];
    }
}

static void look(protocol_pose how, estimate *out)
{
    const model_class cls = { .name = how == POSE_REFINED ? "unified" : "hocat", .record = record };
    const model m = {
        .cls = &cls, .image_size = SIDE, .cells = CELLS, .hand_alone = hand_alone, .depth_fit = depth_fit,
    };
    const float whole[4] = { 0, 0, SIDE, SIDE };
    const object_shape object = { control, { 800, surface, normal } };
    hand_object_batch *b = hand_object_batch_new(1, SIDE, CELLS);
    estimator *e;

    b->count = 1;
    memcpy(b->object_box, whole, sizeof(whole));
    memcpy(b->hand_box, whole, sizeof(whole));
    memcpy(b->affine, affine, sizeof(affine));
    b->K[0] = b->K[4] = 300;
    b->K[2] = affine[0] * 320 + affine[2];
    b->K[5] = affine[4] * 240 + affine[5];
    ck_assert_int_eq(estimator_new(&m, 1, &e), LT_OK);
    if (depth_fit)
        measure(b);
    estimator_run(e, b, &object, out);
    estimator_free(e);
    hand_object_batch_free(b);
}

static void expect_pose(const estimate *e, double tolerance)
{
    ck_assert_double_lt(lt_rot_angle(R_true, e->object.R), 10 * tolerance);
    for (int d = 0; d < 3; d++)
        ck_assert_double_eq_tol(e->object.t[d], t_true[d], tolerance);
}

static estimate *out;

static void setup(void)
{
    out = malloc(sizeof(*out));
}

static void teardown(void)
{
    free(out);
}

/* All votes are found wherever their cells are, and no cell is taken twice. */
START_TEST(every_cell_counts)
{
    cast_votes(0);
    look(_i ? POSE_REFINED : POSE_OPENCV, out);
    ck_assert_int_eq(out->object_inliers, VOTES * LT_BOX_POINTS);
    expect_pose(out, 1e-4);
}
END_TEST

/* Whoever was never taught objects is not asked for one, whatever its votes. */
START_TEST(hands_alone)
{
    cast_votes(0);
    hand_alone = true;
    look(_i ? POSE_REFINED : POSE_OPENCV, out);
    hand_alone = false;
    ck_assert_int_eq(out->object_inliers, 0);
    ck_assert_float_eq(out->object_confidence, 0);
}
END_TEST

/* A cell that is not a number is not the best one, wherever it stands. */
START_TEST(not_a_number)
{
    cast_votes(0);
    for (int v = 0; v < LT_BOX_POINTS; v++)
        conf[v][v % 2 ? 0 : PLACES / 2] = NAN;
    look(POSE_OPENCV, out);
    ck_assert_int_eq(out->object_inliers, VOTES * LT_BOX_POINTS);
    expect_pose(out, 1e-4);
}
END_TEST

/* The refined pose is told in pixels of the image, the other one in those of the crop. */
START_TEST(pixels)
{
    estimate *crop = malloc(sizeof(*crop));

    cast_votes(1.5);
    look(POSE_OPENCV, crop);
    look(POSE_REFINED, out);
    ck_assert_double_eq_tol((double)out->object_error_px, 1.5 * sqrt(M_PI / 2), 0.3);
    ck_assert_double_eq_tol((double)crop->object_error_px, 0.75 * sqrt(M_PI / 2), 0.15);
    expect_pose(out, 5e-3);
    free(crop);
}
END_TEST

/* Votes by which the object is 4 cm too far, which only what was measured can tell */
START_TEST(depth_has_the_last_word)
{
    cast_votes(0);
    for (int v = 0; v < LT_BOX_POINTS; v++)
        for (int d = 0; d < 3; d++)
            control[v][d] *= 1.0667f;
    look(POSE_REFINED, out);
    ck_assert_double_eq_tol(out->object.t[2], 0.64, 2e-3);
    depth_fit = true;
    look(POSE_REFINED, out);
    depth_fit = false;
    expect_pose(out, 3e-3);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_checked_fixture(c, setup, teardown);
    tcase_add_loop_test(c, every_cell_counts, 0, 2);
    tcase_add_loop_test(c, hands_alone, 0, 2);
    tcase_add_test(c, not_a_number);
    tcase_add_test(c, pixels);
    tcase_add_test(c, depth_has_the_last_word);
}

int main(void)
{
    return run_suite("estimator", add_tests);
}
