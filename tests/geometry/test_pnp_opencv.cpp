/* SPDX-License-Identifier: Apache-2.0 */
/* PnP against OpenCV's: the same EPnP on the same points, the same quality behind RANSAC. */
#include "libtensor/base/rng.h"
#include "libtensor/geometry/box21.h"
#include "libtensor/geometry/pnp/pnp.h"
#include "libtensor/geometry/rotation.h"

#include <opencv2/calib3d.hpp>

#include <cmath>
#include <cstdio>
#include <vector>

#include "tests/suite.h"        /* last: Check's macro fail() would break iostream */

namespace {

const lt_camera camera = { 614.627, 614.101, 320.262, 238.469 };
const cv::Matx33d K(614.627, 0, 320.262, 0, 614.101, 238.469, 0, 0, 1);

/* Half the extents of a can, a cracker box, a mustard bottle, a drill, a foam brick; metres. */
const double half_size[][3] = {
    { .0511, .0512, .0700 }, { .0358, .0820, .1067 }, { .0486, .0333, .0957 },
    { .0921, .0937, .0287 }, { .0263, .0389, .0255 },
};

struct pose {
    double R[9], t[3];
};

struct scene {
    pose truth;
    std::vector<cv::Point3d> X;
    std::vector<cv::Point2d> uv;
};

/* 21 points voted for 10 times each, with Gaussian noise and a share of outliers. */
scene make_scene(lt_rng *r, int which, double noise_px, double outliers)
{
    scene s;
    lt_box box;
    double q[4], points[LT_BOX_POINTS][3];

    for (int k = 0; k < 3; k++) {
        box.lo[k] = -half_size[which][k];
        box.hi[k] = half_size[which][k];
    }
    lt_box21(&box, points);
    for (double &x : q)
        x = lt_rng_normal(r);
    lt_rot_from_quat(q, s.truth.R);
    s.truth.t[0] = lt_rng_range(r, -.15, .15);
    s.truth.t[1] = lt_rng_range(r, -.1, .1);
    s.truth.t[2] = lt_rng_range(r, .35, 1.1);
    for (int i = 0; i < 10 * LT_BOX_POINTS; i++) {
        const double *x = points[i % LT_BOX_POINTS];
        double p[3], uv[2];
        lt_rigid_apply(s.truth.R, s.truth.t, x, p);
        lt_camera_project(&camera, p, uv);
        uv[0] += noise_px * lt_rng_normal(r);
        uv[1] += noise_px * lt_rng_normal(r);
        if (lt_rng_uniform(r) < outliers) {
            uv[0] = lt_rng_range(r, 0, 640);
            uv[1] = lt_rng_range(r, 0, 480);
        }
        s.X.emplace_back(x[0], x[1], x[2]);
        s.uv.emplace_back(uv[0], uv[1]);
    }
    return s;
}

pose from_opencv(const cv::Mat &rvec, const cv::Mat &tvec)
{
    pose out;

    lt_rot_from_axis_angle(rvec.ptr<double>(), out.R);
    for (int i = 0; i < 3; i++)
        out.t[i] = tvec.at<double>(i);
    return out;
}

double add_metric(const scene &s, const pose &p)
{
    double sum = 0;

    for (int i = 0; i < LT_BOX_POINTS; i++) {
        double a[3], b[3];
        lt_rigid_apply(p.R, p.t, &s.X[i].x, a);
        lt_rigid_apply(s.truth.R, s.truth.t, &s.X[i].x, b);
        sum += lt_vec3_distance(a, b) / LT_BOX_POINTS;
    }
    return sum;
}

} // namespace

START_TEST(same_epnp)
{
    lt_rng r = lt_rng_make(1, 0);
    double sum = 0, cv_sum = 0;
    int same = 0;

    for (int trial = 0; trial < 200; trial++) {
        const scene s = make_scene(&r, trial % 5, 2, 0);
        cv::Mat rvec, tvec;
        pose ours, theirs;
        cv::solvePnP(s.X, s.uv, K, cv::noArray(), rvec, tvec, false, cv::SOLVEPNP_EPNP);
        theirs = from_opencv(rvec, tvec);
        ck_assert_int_eq(lt_epnp(&camera, (int)s.X.size(), &s.X[0].x, &s.uv[0].x, ours.R, ours.t), LT_OK);
        same += lt_rot_angle(ours.R, theirs.R) < 1e-6 && lt_vec3_distance(ours.t, theirs.t) < 1e-6;
        sum += add_metric(s, ours);
        cv_sum += add_metric(s, theirs);
    }
    std::printf("EPnP, 210 points, 2 px noise: %d of 200 poses agree with OpenCV to 1e-6; "
                "ADD %.4f mm, OpenCV %.4f mm\n", same, 5 * sum, 5 * cv_sum);
    ck_assert_int_eq(same, 200);
    ck_assert_double_le(sum, 1.01 * cv_sum);
}
END_TEST

/* Both draw their own fives out of the same points, with the same limits. A few poor poses carry much of the
 * mean, so that a few hundred trials differ by 2 % either way; thousands agree. */
START_TEST(same_quality_behind_ransac)
{
    enum { TRIALS = 4000 };
    lt_rng r = lt_rng_make(2, 0);
    double sum = 0, cv_sum = 0;

    for (int trial = 0; trial < TRIALS; trial++) {
        const scene s = make_scene(&r, trial % 5, 1.5, .2);
        std::vector<int> inliers;
        cv::Mat rvec, tvec;
        lt_pnp_pose ours;
        pose p;
        ck_assert(cv::solvePnPRansac(s.X, s.uv, K, cv::noArray(), rvec, tvec, false, 100, 8.f, .99, inliers,
                                     cv::SOLVEPNP_EPNP));
        ck_assert_int_eq(lt_pnp_ransac(&camera, (int)s.X.size(), &s.X[0].x, &s.uv[0].x, NULL, &ours, NULL),
                         LT_OK);
        memcpy(p.R, ours.R, sizeof(p.R));
        memcpy(p.t, ours.t, sizeof(p.t));
        sum += 1000 * add_metric(s, p) / TRIALS;
        cv_sum += 1000 * add_metric(s, from_opencv(rvec, tvec)) / TRIALS;
    }
    std::printf("RANSAC, 210 points, 1.5 px noise, 20 %% outliers: ADD %.4f mm, OpenCV %.4f mm\n", sum, cv_sum);
    ck_assert_double_le(sum, 1.01 * cv_sum);
    ck_assert_double_ge(sum, 0.99 * cv_sum);
}
END_TEST

/* Few points of a small thing with noise are where mirror images and second solutions compete: a share of poses that are
 * far off no larger than OpenCV's, by more than what is left to chance. */
static void compare_far_off(bool flat, int n, double px, double noise)
{
    enum { TRIALS = 1000 };
    lt_rng r = lt_rng_make(3, (uint64_t)n + flat);
    const double depth = camera.fx * .2 / px;
    int far = 0, cv_far = 0;

    for (int trial = 0; trial < TRIALS; trial++) {
        double q[4], truth[9], R[9], t[3], theirs[9];
        std::vector<cv::Point3d> X;
        std::vector<cv::Point2d> uv;
        cv::Mat rvec, tvec;

        for (double &x : q)
            x = lt_rng_normal(&r);
        lt_rot_from_quat(q, truth);
        if (flat && std::fabs(truth[8]) < .5)           /* seen at a slant of at most 60 degrees */
            continue;
        for (int i = 0; i < n; i++) {
            const double x[3] = { lt_rng_range(&r, -.1, .1), lt_rng_range(&r, -.1, .1),
                                  flat ? 0 : lt_rng_range(&r, -.1, .1) }, at[3] = { 0, 0, depth };
            double p[3], seen[2];

            lt_rigid_apply(truth, at, x, p);
            lt_camera_project(&camera, p, seen);
            X.emplace_back(x[0], x[1], x[2]);
            uv.emplace_back(seen[0] + noise * lt_rng_normal(&r), seen[1] + noise * lt_rng_normal(&r));
        }
        cv::solvePnP(X, uv, K, cv::noArray(), rvec, tvec, false, flat ? cv::SOLVEPNP_IPPE : cv::SOLVEPNP_EPNP);
        lt_rot_from_axis_angle(rvec.ptr<double>(), theirs);
        cv_far += lt_rot_angle(theirs, truth) > M_PI / 6;
        if ((flat ? lt_pnp_planar : lt_epnp)(&camera, n, &X[0].x, &uv[0].x, R, t) != LT_OK
            || lt_rot_angle(R, truth) > M_PI / 6)
            far++;
    }
    std::printf("%s, %d points over %.0f px, %.1f px noise: %d of %d poses more than 30 degrees off, OpenCV %d\n",
                flat ? "planar" : "EPnP", n, px, noise, far, TRIALS, cv_far);
    ck_assert_int_le(far, cv_far + 15);
}

START_TEST(no_more_poses_are_far_off)
{
    compare_far_off(false, 6, 60, 1);
    compare_far_off(false, 8, 60, 1);
    compare_far_off(true, 6, 60, .5);
    compare_far_off(true, 8, 60, 1);
    compare_far_off(true, 8, 200, 1);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_set_timeout(c, 0);
    tcase_add_test(c, same_epnp);
    tcase_add_test(c, same_quality_behind_ransac);
    tcase_add_test(c, no_more_poses_are_far_off);
}

int main()
{
    return run_suite("pnp_opencv", add_tests);
}
