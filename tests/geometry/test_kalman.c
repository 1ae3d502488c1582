/* SPDX-License-Identifier: Apache-2.0 */
/* Filters of points and poses: what they take off noise, how they bridge gaps, what they refuse. */
#include "libtensor/base/rng.h"
#include "libtensor/geometry/kalman/kalman.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "tests/suite.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double DT = 1.0 / 30;

/* ---- points ------------------------------------------------------------------------------------------------- */

enum { JOINTS = 21, FRAMES = 900 };

/* A hand that goes to and fro 20 cm about every 1.5 s and opens and closes, joint by joint. */
static void joint_at(int joint, double t, double out[3])
{
    const double sway = 2 * M_PI * t;

    out[0] = 0.2 * sin(sway / 1.5) + 0.01 * joint * cos(sway / 3);
    out[1] = 0.12 * sin(sway / 1.95 + 1) + 0.004 * joint;
    out[2] = 0.7 + 0.1 * cos(sway / 1.2);
}

static double distance(const double a[3], const double b[3])
{
    return sqrt(pow(a[0] - b[0], 2) + pow(a[1] - b[1], 2) + pow(a[2] - b[2], 2));
}

typedef struct {
    double raw, filtered;           /* mean errors, metres; a frame without a measurement keeps the last one */
} gain;

static gain measure_gain(double dropped, double noise)
{
    lt_rng rng = lt_rng_make(11, 0);
    lt_point_filter f[JOINTS] = { { .rejected = 0 } };
    double last[JOINTS][3];
    gain g = { 0, 0 };

    for (int k = 0; k < FRAMES; k++) {
        const bool missing = k > 0 && lt_rng_uniform(&rng) < dropped;

        for (int j = 0; j < JOINTS; j++) {
            double truth[3];

            joint_at(j, k * DT, truth);
            for (int i = 0; i < 3 && !missing; i++)
                last[j][i] = truth[i] + noise * lt_rng_normal(&rng);
            lt_point_filter_step(&f[j], DT, missing ? NULL : last[j]);
            g.raw += distance(last[j], truth) / (JOINTS * FRAMES);
            g.filtered += distance(f[j].x, truth) / (JOINTS * FRAMES);
        }
    }
    return g;
}

START_TEST(joints_gain)
{
    const gain g = measure_gain(0.2, 0.005);

    printf("20 %% dropped, 5 mm noise: raw %.2f mm, filtered %.2f mm, %.1f %% less\n", 1e3 * g.raw, 1e3 * g.filtered,
           100 * (1 - g.filtered / g.raw));
    ck_assert_double_lt(g.filtered, 0.7 * g.raw);
}
END_TEST

START_TEST(steady_motion_is_followed)
{
    lt_point_filter f = { .started = false };
    double m[3];

    ck_assert(!lt_point_filter_step(&f, DT, NULL));
    for (int k = 0; k < 200; k++) {
        m[0] = 0.5 * k * DT, m[1] = -0.2 * k * DT, m[2] = 0.6;
        ck_assert(lt_point_filter_step(&f, DT, m));
    }
    for (int k = 200; k < 210; k++)
        ck_assert(!lt_point_filter_step(&f, DT, NULL));
    ck_assert_double_eq_tol(f.x[0], 0.5 * 209 * DT, 1e-4);
    ck_assert_double_eq_tol(f.x[1], -0.2 * 209 * DT, 1e-4);
    ck_assert_double_eq_tol(f.v[0], 0.5, 1e-3);
}
END_TEST

/* What jumps is refused twice and believed the third time; NaN is no measurement. */
START_TEST(jumps_are_gated)
{
    const double here[3] = { 0, 0, 0.6 }, there[3] = { 0.3, 0, 0.6 }, nowhere[3] = { NAN, 0, 0.6 };
    lt_point_filter f = { .started = false };

    ck_assert(!lt_point_filter_step(&f, DT, nowhere) && !f.started);
    for (int k = 0; k < 30; k++)
        ck_assert(lt_point_filter_step(&f, DT, here));
    ck_assert(!lt_point_filter_step(&f, DT, there));
    ck_assert(lt_point_filter_step(&f, DT, here));
    ck_assert(!lt_point_filter_step(&f, DT, there));
    ck_assert(!lt_point_filter_step(&f, DT, nowhere));
    ck_assert(!lt_point_filter_step(&f, DT, there));
    ck_assert_double_lt(fabs(f.x[0]), 0.05);
    ck_assert(lt_point_filter_step(&f, DT, there));
    ck_assert_double_eq(f.x[0], 0.3);
}
END_TEST

/* ---- poses -------------------------------------------------------------------------------------------------- */

static const lt_pose_measurement still = { .p = { 0, 0, 0.6 }, .q = { 1, 0, 0, 0 },
                                           .R_world_cam = { 1, 0, 0, 0, 1, 0, 0, 0, 1 } };

static void turned(double x, double y, double z, double angle, double q[4])
{
    const double aa[3] = { x * angle, y * angle, z * angle };
    double R[9];

    lt_rot_from_axis_angle(aa, R);
    lt_rot_to_quat(R, q);
}

static double angle_between(const double a[4], const double b[4])
{
    double A[9], B[9];

    lt_rot_from_quat(a, A);
    lt_rot_from_quat(b, B);
    return lt_rot_angle(A, B);
}

/* First b, then a */
static void compose(const double a[4], const double b[4], double out[4])
{
    double A[9], B[9], AB[9];

    lt_rot_from_quat(a, A);
    lt_rot_from_quat(b, B);
    lt_mat3_mul(A, B, AB);
    lt_rot_to_quat(AB, out);
}

/* 3 rad/s about an axis, measured with 5 degrees of noise a sign at random: below the noise, and over gaps. */
static double spin_error(bool flips, int gap_from, int gap_to)
{
    lt_rng rng = lt_rng_make(4, 1), sign = lt_rng_make(4, 2);
    lt_pose_filter f = { .state = LT_FILTER_OFF };
    double error = 0, noise = 0;
    int n = 0;

    for (int k = 0; k < 300; k++) {
        lt_pose_measurement m = still;
        double truth[4], wobble[4];

        turned(0.6, 0, 0.8, 3 * k * DT, truth);
        wobble[0] = 1;
        for (int i = 1; i < 4; i++)
            wobble[i] = 0.0873 / 2 * lt_rng_normal(&rng);
        compose(wobble, truth, m.q);
        if (flips && lt_rng_below(&sign, 2))
            for (int i = 0; i < 4; i++)
                m.q[i] = -m.q[i];
        lt_pose_filter_step(&f, DT, k >= gap_from && k < gap_to ? NULL : &m);
        if (k < 100)
            continue;
        error += angle_between(f.q, truth);
        noise += angle_between(m.q, truth);
        n++;
    }
    ck_assert_int_ne(f.state, LT_FILTER_OFF);
    ck_assert_double_lt(error, noise);
    return error / n;
}

START_TEST(spin_is_smoothed)
{
    const double plain = spin_error(false, 0, 0);

    ck_assert_double_lt(plain, 0.12);
    spin_error(true, 200, 210);
}
END_TEST

START_TEST(gaps_are_bridged_for_a_while)
{
    lt_pose_filter f = { .state = LT_FILTER_OFF };
    lt_pose_measurement m = still;

    ck_assert_int_eq(lt_pose_filter_step(&f, DT, NULL), LT_FILTER_OFF);
    for (int k = 0; k < 100; k++) {
        m.p[0] = 0.3 * k * DT;
        turned(0, 1, 0, 2 * k * DT, m.q);
        ck_assert_int_eq(lt_pose_filter_step(&f, DT, &m), LT_FILTER_ON);
    }
    for (int k = 0; k < 10; k++)
        ck_assert_int_eq(lt_pose_filter_step(&f, DT, NULL), LT_FILTER_COAST);
    turned(0, 1, 0, 2 * 109 * DT, m.q);
    ck_assert_double_eq_tol(f.p[0], 0.3 * 109 * DT, 5e-3);
    ck_assert_double_lt(angle_between(f.q, m.q), 0.05);
    for (int k = 10; k < LT_POSE_COAST; k++)
        ck_assert_int_eq(lt_pose_filter_step(&f, DT, NULL), LT_FILTER_COAST);
    ck_assert_int_eq(lt_pose_filter_step(&f, DT, NULL), LT_FILTER_OFF);
    ck_assert_int_eq(lt_pose_filter_step(&f, DT, &still), LT_FILTER_ON);
    ck_assert_double_eq(f.p[0], 0);
}
END_TEST

/* -q is q; an object that looks the same after half a turn may be measured either way. */
START_TEST(signs_and_symmetries_change_nothing)
{
    static const double half_turn[1][4] = { { 0, 0, 0, 1 } };
    lt_pose_filter a = { .state = LT_FILTER_OFF }, b = a, c = a;

    for (int k = 0; k < 40; k++) {
        lt_pose_measurement m = still, flipped, turned_over;

        m.symmetry = half_turn;
        m.n_symmetries = 1;
        turned(0, 1, 0, 0.5 * k * DT, m.q);
        flipped = turned_over = m;
        for (int i = 0; i < 4 && k % 2; i++)
            flipped.q[i] = -m.q[i];
        if (k % 2) {                            /* q (0, 0, 0, 1) */
            turned_over.q[0] = -m.q[3], turned_over.q[1] = m.q[2];
            turned_over.q[2] = -m.q[1], turned_over.q[3] = m.q[0];
        }
        lt_pose_filter_step(&a, DT, &m);
        lt_pose_filter_step(&b, DT, &flipped);
        lt_pose_filter_step(&c, DT, &turned_over);
        ck_assert_double_lt(angle_between(a.q, b.q), 1e-9);
        ck_assert_double_lt(angle_between(a.q, c.q), 1e-9);
    }
}
END_TEST

START_TEST(wild_poses_are_gated)
{
    lt_pose_filter f = { .state = LT_FILTER_OFF };
    lt_pose_measurement far = still, broken = still, none = still, longer = still;

    far.p[0] = 0.5;
    broken.q[2] = NAN;
    none.q[0] = 0;
    longer.q[0] = 3;
    ck_assert_int_eq(lt_pose_filter_step(&f, DT, &none), LT_FILTER_OFF);
    for (int k = 0; k < 60; k++)
        lt_pose_filter_step(&f, DT, &still);
    ck_assert_int_eq(lt_pose_filter_step(&f, DT, &far), LT_FILTER_COAST);
    ck_assert_int_eq(lt_pose_filter_step(&f, DT, &broken), LT_FILTER_COAST);
    ck_assert_int_eq(lt_pose_filter_step(&f, DT, &none), LT_FILTER_COAST);
    ck_assert_double_lt(fabs(f.p[0]), 1e-6);
    ck_assert_int_eq(lt_pose_filter_step(&f, DT, &longer), LT_FILTER_ON);
    ck_assert_double_lt(fabs(f.q[0] - 1), 1e-9);
}
END_TEST

/* Depth is believed less than the rest, in the camera's axes, and so is a pose of badly fitting points. */
START_TEST(uncertainty_lies_along_the_camera)
{
    const double side_view[9] = { 0, 0, 1, 0, 1, 0, -1, 0, 0 };     /* the camera looks along the world's x */
    lt_pose_filter front = { .state = LT_FILTER_OFF }, side = front, vague = front;
    lt_pose_measurement m = still;

    for (int k = 0; k < 20; k++) {
        if (k == 19)
            m.p[0] += 0.01;
        memcpy(m.R_world_cam, still.R_world_cam, sizeof(m.R_world_cam));
        lt_pose_filter_step(&front, DT, &m);
        m.reprojection_px = 16;
        lt_pose_filter_step(&vague, DT, &m);
        m.reprojection_px = 0;
        memcpy(m.R_world_cam, side_view, sizeof(m.R_world_cam));
        lt_pose_filter_step(&side, DT, &m);
    }
    ck_assert_double_gt(front.p[0], 1.2 * side.p[0]);
    ck_assert_double_gt(front.p[0], 1.2 * vague.p[0]);
    ck_assert_double_gt(side.p[0], 1e-4);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_test(c, joints_gain);
    tcase_add_test(c, steady_motion_is_followed);
    tcase_add_test(c, jumps_are_gated);
    tcase_add_test(c, spin_is_smoothed);
    tcase_add_test(c, gaps_are_bridged_for_a_while);
    tcase_add_test(c, signs_and_symmetries_change_nothing);
    tcase_add_test(c, wild_poses_are_gated);
    tcase_add_test(c, uncertainty_lies_along_the_camera);
}

int main(void)
{
    return run_suite("kalman", add_tests);
}
