/* SPDX-License-Identifier: Apache-2.0 */
/* PnP: exact poses come back, outliers do no harm, impossible input gets a status. */
#include "libtensor/base/arena.h"
#include "libtensor/base/rng.h"
#include "libtensor/geometry/box21.h"
#include "libtensor/geometry/pnp/pnp.h"
#include "libtensor/geometry/rotation.h"
#include "tests/suite.h"

#include <stdio.h>

enum { REPEATS = 10, MANY = REPEATS * LT_BOX_POINTS };

static const lt_camera camera = { 614.627, 614.101, 320.262, 238.469 };

/* Half the extents of a can, a cracker box, scissors, a marker, a bowl, a foam brick; metres. */
static const double half_size[][3] = {
    { .0511, .0512, .0700 }, { .0358, .0820, .1067 }, { .0480, .1007, .0078 },
    { .0105, .0604, .0094 }, { .0807, .0805, .0275 }, { .0263, .0389, .0255 },
};

typedef struct {
    double R[9], t[3];
    double X[3 * MANY], uv[2 * MANY];
} scene;

static void make_scene(lt_rng *r, int box_index, double noise_px, scene *s)
{
    lt_box box;
    double q[4], points[LT_BOX_POINTS][3];

    for (int k = 0; k < 3; k++) {
        const double shift = lt_rng_range(r, -.02, .02);
        box.lo[k] = shift - half_size[box_index][k];
        box.hi[k] = shift + half_size[box_index][k];
    }
    lt_box21(&box, points);
    for (int i = 0; i < 4; i++)
        q[i] = lt_rng_normal(r);
    lt_rot_from_quat(q, s->R);
    s->t[0] = lt_rng_range(r, -.15, .15);
    s->t[1] = lt_rng_range(r, -.1, .1);
    s->t[2] = lt_rng_range(r, .35, 1.1);
    for (int i = 0; i < MANY; i++) {
        double p[3];
        memcpy(s->X + 3 * i, points[i % LT_BOX_POINTS], sizeof(p));
        lt_rigid_apply(s->R, s->t, s->X + 3 * i, p);
        ck_assert(lt_camera_project(&camera, p, s->uv + 2 * i));
        s->uv[2 * i] += noise_px * lt_rng_normal(r);
        s->uv[2 * i + 1] += noise_px * lt_rng_normal(r);
    }
}

static double pose_error(const scene *s, const double R[9], const double t[3])
{
    return fmax(lt_rot_angle(s->R, R), lt_vec3_distance(s->t, t));
}

static double add_metric(const scene *s, const double R[9], const double t[3])
{
    double sum = 0;

    for (int i = 0; i < LT_BOX_POINTS; i++) {
        double a[3], b[3];
        lt_rigid_apply(R, t, s->X + 3 * i, a);
        lt_rigid_apply(s->R, s->t, s->X + 3 * i, b);
        sum += lt_vec3_distance(a, b) / LT_BOX_POINTS;
    }
    return sum;
}

START_TEST(exact_poses)
{
    lt_rng r = lt_rng_make(1, 0);
    double worst[2] = { 0 };
    scene s;

    for (int trial = 0; trial < 600; trial++) {
        double R[9], t[3];
        make_scene(&r, trial % (int)LT_COUNT(half_size), 0, &s);
        ck_assert_int_eq(lt_epnp(&camera, LT_BOX_POINTS, s.X, s.uv, R, t), LT_OK);
        worst[0] = fmax(worst[0], pose_error(&s, R, t));
        ck_assert_int_eq(lt_epnp(&camera, MANY, s.X, s.uv, R, t), LT_OK);
        worst[1] = fmax(worst[1], pose_error(&s, R, t));
    }
    printf("epnp, exact points: largest error %.2g (21 points), %.2g (210)\n", worst[0], worst[1]);
    ck_assert_double_lt(worst[0], 1e-6);
    ck_assert_double_lt(worst[1], 1e-6);
}
END_TEST

/* A fifth of the points anywhere in the image, the rest exact. One such outlier may fall within 8 px of its
 * place, and a lucky draw of few different points may end the search early; the pose is exact unless the
 * former happened. */
START_TEST(outliers)
{
    const lt_pnp_opts presets[2] = { lt_pnp_opencv(), lt_pnp_refined() };
    lt_rng r = lt_rng_make(2, 0);
    unsigned char inlier[MANY];
    int exact = 0;
    lt_pnp_pose pose;
    scene s;

    for (int trial = 0; trial < 200; trial++) {
        const int n = trial % 2 ? MANY : LT_BOX_POINTS, good = n - (n + 4) / 5;
        int kept = 0, fooled = 0;
        make_scene(&r, trial % (int)LT_COUNT(half_size), 0, &s);
        for (int i = 0; i < n; i += 5) {
            s.uv[2 * i] = lt_rng_range(&r, 0, 640);
            s.uv[2 * i + 1] = lt_rng_range(&r, 0, 480);
        }
        ck_assert_msg(!lt_pnp_ransac(&camera, n, s.X, s.uv, &presets[trial / 2 % 2], &pose, inlier), "%s",
                      lt_last_error());
        for (int i = 0; i < n; i++)
            if (i % 5)
                kept += inlier[i];
            else
                fooled += inlier[i];
        ck_assert_int_eq(pose.n_inliers, kept + fooled);
        ck_assert_int_ge(kept, 2 * good / 3);
        exact += pose_error(&s, pose.R, pose.t) < 1e-6 && pose.mean_err_px < 1e-5;
        ck_assert(fooled || pose_error(&s, pose.R, pose.t) < 1e-6);
    }
    printf("20 %% outliers: %d of 200 poses exact to 1e-6\n", exact);
    ck_assert_int_ge(exact, 150);
}
END_TEST

START_TEST(same_pose_every_time)
{
    lt_rng r = lt_rng_make(3, 0);
    lt_pnp_pose a, b;
    scene s;

    make_scene(&r, 1, 2, &s);
    ck_assert_int_eq(lt_pnp_ransac(&camera, MANY, s.X, s.uv, NULL, &a, NULL), LT_OK);
    ck_assert_int_eq(lt_pnp_ransac(&camera, MANY, s.X, s.uv, NULL, &b, NULL), LT_OK);
    ck_assert_mem_eq(&a, &b, sizeof(a));
}
END_TEST

/* Refinement lowers the squared error, and so on average the pose error, that EPnP leaves. */
START_TEST(refinement_helps)
{
    const lt_pnp_opts refined = lt_pnp_refined();
    lt_rng r = lt_rng_make(4, 0);
    double sum[2] = { 0 };
    scene s;

    for (int trial = 0; trial < 200; trial++) {
        lt_pnp_pose plain, fine;
        make_scene(&r, trial % (int)LT_COUNT(half_size), 2, &s);
        ck_assert_int_eq(lt_pnp_ransac(&camera, LT_BOX_POINTS, s.X, s.uv, NULL, &plain, NULL), LT_OK);
        ck_assert_int_eq(lt_pnp_ransac(&camera, LT_BOX_POINTS, s.X, s.uv, &refined, &fine, NULL), LT_OK);
        sum[0] += add_metric(&s, plain.R, plain.t);
        sum[1] += add_metric(&s, fine.R, fine.t);
    }
    printf("ADD at 2 px noise, 21 points: EPnP %.2f mm, refined %.2f mm\n", 5 * sum[0], 5 * sum[1]);
    ck_assert_double_lt(sum[1], sum[0]);
}
END_TEST

START_TEST(refine_never_worsens)
{
    lt_rng r = lt_rng_make(5, 0);
    scene s;

    for (int trial = 0; trial < 100; trial++) {
        const double aa[3] = { .1 * lt_rng_normal(&r), .1 * lt_rng_normal(&r), .1 * lt_rng_normal(&r) };
        double turn[9], R[9], t[3], before;
        make_scene(&r, trial % (int)LT_COUNT(half_size), 0, &s);
        lt_rot_from_axis_angle(aa, turn);
        lt_mat3_mul(turn, s.R, R);
        memcpy(t, s.t, sizeof(t));
        before = pose_error(&s, R, t);
        ck_assert_int_eq(lt_pnp_refine(&camera, LT_BOX_POINTS, s.X, s.uv, 20, R, t), LT_OK);
        ck_assert_double_lt(pose_error(&s, R, t), 1e-6 * before);
    }
}
END_TEST

/* A sheet of paper: EPnP has nothing to say, the homography has. */
START_TEST(flat_things)
{
    const lt_pnp_opts presets[2] = { lt_pnp_opencv(), lt_pnp_refined() };
    lt_rng r = lt_rng_make(6, 0);
    lt_pnp_pose pose;
    scene s;

    for (int trial = 0; trial < 100; trial++) {
        double R[9], t[3];
        make_scene(&r, 1, 0, &s);
        for (int i = 0; i < LT_BOX_POINTS; i++) {
            double p[3];
            s.X[3 * i + trial % 3] = 0.01;
            lt_rigid_apply(s.R, s.t, s.X + 3 * i, p);
            lt_camera_project(&camera, p, s.uv + 2 * i);
        }
        ck_assert_int_eq(lt_epnp(&camera, LT_BOX_POINTS, s.X, s.uv, R, t), LT_OK);
        ck_assert_double_lt(pose_error(&s, R, t), 1e-6);
        ck_assert_int_eq(lt_pnp_ransac(&camera, LT_BOX_POINTS, s.X, s.uv, &presets[trial % 2], &pose, NULL),
                         LT_OK);
        ck_assert_double_lt(pose_error(&s, pose.R, pose.t), 1e-6);
    }
}
END_TEST

/* 1 mm thick and 20 cm wide, with noise: the refined preset stays near the truth. */
START_TEST(thin_things)
{
    const lt_pnp_opts refined = lt_pnp_refined();
    lt_rng r = lt_rng_make(7, 0);
    lt_pnp_pose pose;
    double sum = 0;
    scene s;

    for (int trial = 0; trial < 100; trial++) {
        make_scene(&r, 1, 0, &s);
        for (int i = 0; i < MANY; i++) {
            double p[3];
            s.X[3 * i] *= 0.01;
            lt_rigid_apply(s.R, s.t, s.X + 3 * i, p);
            lt_camera_project(&camera, p, s.uv + 2 * i);
            s.uv[2 * i] += 0.5 * lt_rng_normal(&r);
            s.uv[2 * i + 1] += 0.5 * lt_rng_normal(&r);
        }
        ck_assert_int_eq(lt_pnp_ransac(&camera, MANY, s.X, s.uv, &refined, &pose, NULL), LT_OK);
        sum += add_metric(&s, pose.R, pose.t);
    }
    printf("ADD of a 1 mm sheet at 0.5 px noise, 210 points, refined: %.2f mm\n", 10 * sum);
    ck_assert_double_lt(sum / 100, 0.003);
}
END_TEST

static void expect_status(lt_status want, int n, const double *X, const double *uv)
{
    const lt_pnp_opts presets[2] = { lt_pnp_opencv(), lt_pnp_refined() };
    lt_pnp_pose pose;

    for (int k = 0; k < 2; k++) {
        const lt_status st = lt_pnp_ransac(&camera, n, X, uv, &presets[k], &pose, NULL);
        ck_assert_msg(st == want, "status %d, want %d (%s)", st, want, lt_last_error());
    }
}

START_TEST(impossible)
{
    const lt_camera no_focus = { 0, 600, 320, 240 };
    lt_rng r = lt_rng_make(8, 0);
    double R[9], t[3] = { 0, 0, -1 };
    lt_pnp_pose pose;
    scene s;

    make_scene(&r, 0, 0, &s);
    expect_status(LT_EINVAL, 5, s.X, s.uv);
    expect_status(LT_EINVAL, 0, s.X, s.uv);
    expect_status(LT_EINVAL, -1, s.X, s.uv);
    ck_assert_int_eq(lt_epnp(&camera, 3, s.X, s.uv, R, t), LT_EINVAL);
    ck_assert_int_eq(lt_pnp_ransac(&no_focus, MANY, s.X, s.uv, NULL, &pose, NULL), LT_EINVAL);
    ck_assert_int_eq(lt_pnp_refine(&camera, MANY, s.X, s.uv, 20, s.R, t), LT_ENUMERIC);

    s.uv[3] = NAN;
    expect_status(LT_EINVAL, MANY, s.X, s.uv);
    make_scene(&r, 0, 0, &s);
    s.X[7] = INFINITY;
    expect_status(LT_EINVAL, MANY, s.X, s.uv);

    make_scene(&r, 0, 0, &s);
    for (int i = 0; i < 3 * MANY; i++)
        s.X[i] = 0.01;
    expect_status(LT_ENUMERIC, MANY, s.X, s.uv);        /* one point */
    ck_assert_int_eq(lt_epnp(&camera, MANY, s.X, s.uv, R, t), LT_ENUMERIC);
}
END_TEST

/* In any direction, and not only where coordinates are exact. */
START_TEST(lines)
{
    lt_rng r = lt_rng_make(11, 0);
    double R[9], t[3];
    scene s;

    for (int trial = 0; trial < 200; trial++) {
        const int n = 6 + (int)lt_rng_below(&r, MANY - 6);
        double from[3], along[3];

        make_scene(&r, 0, 0, &s);
        for (int k = 0; k < 3; k++) {
            from[k] = lt_rng_range(&r, -.1, .1);
            along[k] = trial ? lt_rng_normal(&r) : 1;
        }
        for (int i = 0; i < n; i++) {
            const double step = lt_rng_range(&r, -.1, .1);

            for (int k = 0; k < 3; k++)
                s.X[3 * i + k] = from[k] + step * along[k];
        }
        expect_status(LT_ENUMERIC, n, s.X, s.uv);
        ck_assert_int_eq(lt_epnp(&camera, n, s.X, s.uv, R, t), LT_ENUMERIC);
    }
}
END_TEST

/* Many votes for few points: two or three leave the pose open, and what four or more say is held against them. */
START_TEST(few_points_with_many_votes)
{
    const lt_pnp_opts presets[2] = { lt_pnp_opencv(), lt_pnp_refined() };
    enum { VOTES = 30 };
    lt_rng r = lt_rng_make(12, 0);
    int found = 0;

    for (int trial = 0; trial < 600; trial++) {
        const int distinct = 2 + trial % 3;
        double X[3 * VOTES], uv[2 * VOTES];
        lt_pnp_pose pose;
        lt_status st;
        scene s;

        make_scene(&r, 0, 0, &s);
        for (int i = 0; i < VOTES; i++) {
            const int from = 5 * (i % distinct);

            memcpy(X + 3 * i, s.X + 3 * from, 3 * sizeof(X[0]));
            for (int d = 0; d < 2; d++)
                uv[2 * i + d] = s.uv[2 * from + d] + 2 * lt_rng_normal(&r);
        }
        st = lt_pnp_ransac(&camera, VOTES, X, uv, &presets[trial / 3 % 2], &pose, NULL);
        if (distinct < 4)
            ck_assert_int_eq(st, LT_ENUMERIC);
        ck_assert(st || pose.mean_err_px <= presets[0].inlier_px);
        found += !st;
    }
    ck_assert_int_gt(found, 90);            /* of 100: the refined preset wants five points that differ */
}
END_TEST

/* A sheet whose points are seen at random: no pose with one behind the camera. */
START_TEST(flat_things_are_in_front)
{
    lt_rng r = lt_rng_make(13, 0);
    int found = 0;

    for (int trial = 0; trial < 500; trial++) {
        double X[3 * 8] = { 0 }, uv[2 * 8], R[9], t[3];

        for (int i = 0; i < 8; i++)
            for (int d = 0; d < 2; d++) {
                X[3 * i + d] = lt_rng_range(&r, -.1, .1);
                uv[2 * i + d] = lt_rng_range(&r, 0, 640);
            }
        if (lt_pnp_planar(&camera, 8, X, uv, R, t))
            continue;
        ck_assert(isfinite(lt_pnp_error(&camera, 8, X, uv, R, t)));
        found++;
    }
    ck_assert_int_gt(found, 0);
}
END_TEST

/* Up to 256 inliers need none. */
START_TEST(no_memory)
{
    lt_rng r = lt_rng_make(10, 0);
    double X[2 * 3 * MANY], uv[2 * 2 * MANY];           /* every point twice */
    lt_pnp_pose pose = { .n_inliers = -1 };
    scene s;

    make_scene(&r, 0, 0, &s);
    for (int i = 0; i < 2; i++) {
        memcpy(X + i * 3 * MANY, s.X, sizeof(s.X));
        memcpy(uv + i * 2 * MANY, s.uv, sizeof(s.uv));
    }
    lt_alloc_fail_at(1);
    ck_assert_int_eq(lt_pnp_ransac(&camera, 2 * MANY, X, uv, NULL, &pose, NULL), LT_ENOMEM);
    ck_assert_int_eq(pose.n_inliers, -1);
    lt_alloc_fail_at(1);
    ck_assert_int_eq(lt_pnp_ransac(&camera, MANY, s.X, s.uv, NULL, &pose, NULL), LT_OK);
    ck_assert_int_eq(pose.n_inliers, MANY);
    lt_alloc_fail_at(0);
}
END_TEST

/* Whatever is thrown at it, an answer or a status, never a number that is not finite. */
START_TEST(rubbish)
{
    const lt_pnp_opts presets[2] = { lt_pnp_opencv(), lt_pnp_refined() };
    lt_rng r = lt_rng_make(9, 0);
    lt_pnp_pose pose;
    scene s;

    for (int trial = 0; trial < 300; trial++) {
        const double size = pow(10, lt_rng_range(&r, -9, 9));
        const int n = 6 + (int)lt_rng_below(&r, 30);
        for (int i = 0; i < 3 * n; i++)
            s.X[i] = trial % 3 ? size * lt_rng_normal(&r) : (double)lt_rng_below(&r, 2);
        for (int i = 0; i < 2 * n; i++)
            s.uv[i] = trial % 4 ? 1000 * lt_rng_normal(&r) : 320;
        if (lt_pnp_ransac(&camera, n, s.X, s.uv, &presets[trial % 2], &pose, NULL))
            continue;
        for (int i = 0; i < 9; i++)
            ck_assert(isfinite(pose.R[i]) && isfinite(pose.t[i % 3]));
        ck_assert(isfinite(pose.mean_err_px));
    }
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_set_timeout(c, 0);
    tcase_add_test(c, exact_poses);
    tcase_add_test(c, outliers);
    tcase_add_test(c, same_pose_every_time);
    tcase_add_test(c, refinement_helps);
    tcase_add_test(c, refine_never_worsens);
    tcase_add_test(c, flat_things);
    tcase_add_test(c, thin_things);
    tcase_add_test(c, impossible);
    tcase_add_test(c, lines);
    tcase_add_test(c, few_points_with_many_votes);
    tcase_add_test(c, flat_things_are_in_front);
    tcase_add_test(c, no_memory);
    tcase_add_test(c, rubbish);
}

int main(void)
{
    return run_suite("pnp", add_tests);
}
