/* SPDX-License-Identifier: Apache-2.0 */
/* Rotations, the 3 x 3 SVD, the camera, boxes. The numbers of the
 * HO3D, MANO and projection vectors were computed with the datasets' own formulas. */
#include "libtensor/base/rng.h"
#include "libtensor/geometry/box21.h"
#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/geometry/svd3.h"
#include "tests/suite.h"

static void expect_near(const double *got, const double *want, int n, double tol)
{
    for (int i = 0; i < n; i++)
        ck_assert_msg(fabs(got[i] - want[i]) <= tol, "[%d] is %.17g, want %.17g within %g", i, got[i],
                      want[i], tol);
}

static void expect_orthogonal(const double M[9], double tol)
{
    double Mt[9], P[9], I[9];

    lt_mat3_transpose(M, Mt);
    lt_mat3_mul(M, Mt, P);
    lt_mat3_identity(I);
    expect_near(P, I, 9, tol);
}

static void random_rotation(lt_rng *r, double R[9])
{
    double q[4];

    for (int i = 0; i < 4; i++)
        q[i] = lt_rng_normal(r);
    lt_rot_from_quat(q, R);
}

START_TEST(rodrigues_vector)
{
    const double aa[3] = { 0.1, -0.2, 0.3 };
    const double want[9] = { .935755, -.302933, -.180540, .283165, .950581, -.127335,
                             .210192, .068031, .975290 };
    const double want_q[4] = { .982551, .049709, -.099418, .149127 };
    double R[9], q[4], back[3];

    lt_rot_from_axis_angle(aa, R);
    expect_near(R, want, 9, 6e-7);
    lt_rot_to_quat(R, q);
    expect_near(q, want_q, 4, 6e-7);
    lt_rot_to_axis_angle(R, back);
    expect_near(back, aa, 3, 1e-15);
}
END_TEST

/* Angles from nothing to just under pi, on both sides of where the series takes over. */
START_TEST(axis_angle_round_trip)
{
    static const double angles[] = { 0, 1e-300, 1e-12, 1e-8, 1e-4, 9.99e-3, 1.001e-2, 1, 3, 3.14159,
                                     M_PI - 1e-7, M_PI - 1e-12 };
    lt_rng r = lt_rng_make(1, 0);

    for (int trial = 0; trial < 200; trial++) {
        double axis[3], aa[3], R[9], back[3], norm;
        for (int i = 0; i < 3; i++)
            axis[i] = lt_rng_normal(&r);
        norm = lt_vec3_norm(axis);
        for (size_t k = 0; k < LT_COUNT(angles); k++) {
            for (int i = 0; i < 3; i++)
                aa[i] = axis[i] / norm * angles[k];
            lt_rot_from_axis_angle(aa, R);
            expect_orthogonal(R, 2e-15);
            lt_rot_to_axis_angle(R, back);
            expect_near(back, aa, 3, 2e-15);
        }
    }
}
END_TEST

START_TEST(half_turns)
{
    static const double axes[][3] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { .6, -.8, 0 }, { 0, -.6, .8 } };

    for (size_t k = 0; k < LT_COUNT(axes); k++) {
        const double q[4] = { 0, axes[k][0], axes[k][1], axes[k][2] };
        double R[9], aa[3], back[9];
        lt_rot_from_quat(q, R);
        lt_rot_to_axis_angle(R, aa);
        ck_assert_double_eq_tol(lt_vec3_norm(aa), M_PI, 1e-15);
        lt_rot_from_axis_angle(aa, back);
        expect_near(back, R, 9, 1e-15);
        ck_assert_double_eq_tol(lt_rot_angle(R, back), 0, 1e-15);
    }
}
END_TEST

START_TEST(quaternions)
{
    const double zero[4] = { 0 }, I[9] = { 1, 0, 0, 0, 1, 0, 0, 0, 1 };
    lt_rng r = lt_rng_make(2, 0);
    double R[9], q[4], back[9];

    for (int trial = 0; trial < 1000; trial++) {
        random_rotation(&r, R);
        lt_rot_to_quat(R, q);
        ck_assert_double_ge(q[0], 0);
        lt_rot_from_quat(q, back);
        expect_near(back, R, 9, 1e-15);
    }
    lt_rot_from_quat(zero, R);
    expect_near(R, I, 9, 0);
}
END_TEST

/* What quaternions do, matrices do as well. */
START_TEST(quaternion_algebra)
{
    double zero[4] = { 0 }, none[4] = { NAN, 0, 0, 1 };
    lt_rng r = lt_rng_make(3, 0);

    for (int trial = 0; trial < 1000; trial++) {
        double A[9], B[9], M[9], got[9], a[4], b[4], q[4], v[3];

        random_rotation(&r, A);
        random_rotation(&r, B);
        lt_rot_to_quat(A, a);
        lt_rot_to_quat(B, b);
        lt_quat_mul(a, b, q);
        lt_rot_from_quat(q, got);
        lt_mat3_mul(A, B, M);
        expect_near(got, M, 9, 1e-14);
        lt_quat_difference(a, b, v);
        ck_assert_double_eq_tol(lt_vec3_norm(v), lt_rot_angle(A, B), 1e-13);
        lt_quat_exp(v, 1, q);
        lt_rot_from_quat(q, got);
        lt_rot_from_axis_angle(v, M);
        expect_near(got, M, 9, 1e-14);
        lt_mat3_mul(M, B, M);                       /* A = exp(v) B */
        expect_near(M, A, 9, 1e-13);
        for (int i = 0; i < 4; i++)
            q[i] = 3 * a[i];
        ck_assert(lt_quat_unit(q));
        expect_near(q, a, 4, 1e-15);
    }
    ck_assert(!lt_quat_unit(zero) && !lt_quat_unit(none));
}
END_TEST

START_TEST(six_numbers)
{
    const double unit[6] = { 1, 0, 0, 0, 1, 0 }, I[9] = { 1, 0, 0, 0, 1, 0, 0, 0, 1 };
    const double skew[6] = { 0, 2, 0, -3, 7, 0 };        /* b1 = y, b2 = -x, b3 = z */
    const double want[9] = { 0, -1, 0, 1, 0, 0, 0, 0, 1 };
    const double flat[6] = { 0 };
    lt_rng r = lt_rng_make(3, 0);
    double R[9], d[6], back[9];

    lt_rot_from_6d(unit, R);
    expect_near(R, I, 9, 0);
    lt_rot_from_6d(skew, R);
    expect_near(R, want, 9, 1e-15);
    for (int trial = 0; trial < 100; trial++) {
        random_rotation(&r, R);
        lt_rot_to_6d(R, d);
        lt_rot_from_6d(d, back);
        expect_near(back, R, 9, 1e-15);
    }
    lt_rot_from_6d(flat, R);
    for (int i = 0; i < 9; i++)
        ck_assert(isfinite(R[i]));
}
END_TEST

START_TEST(nearest_and_angle)
{
    const double zero[9] = { 0 }, mirror[9] = { -1, 0, 0, 0, 1, 0, 0, 0, 1 };
    const double bad[9] = { NAN, 0, 0, 0, 1, 0, 0, 0, 1 };
    lt_rng r = lt_rng_make(4, 0);
    double R[9], S[9], M[9], turn[9], aa[3] = { 0, 0, 0 };

    for (int trial = 0; trial < 200; trial++) {
        random_rotation(&r, R);
        for (int i = 0; i < 9; i++)
            M[i] = 2.5 * R[i];
        lt_rot_nearest(M, S);
        expect_near(S, R, 9, 3e-15);
        ck_assert(lt_rot_is_near(R, 1e-14) && !lt_rot_is_near(M, 0.1));
        aa[trial % 3] = 1e-9;
        lt_rot_from_axis_angle(aa, turn);
        lt_mat3_mul(R, turn, S);
        ck_assert_double_eq_tol(lt_rot_angle(R, S), lt_vec3_norm(aa), 1e-15);
    }
    lt_rot_nearest(zero, R);
    expect_orthogonal(R, 1e-15);
    lt_rot_nearest(mirror, R);
    expect_orthogonal(R, 1e-15);
    ck_assert_double_eq_tol(lt_mat3_det(R), 1, 1e-15);
    lt_rot_nearest(bad, R);
    ck_assert(isnan(R[0]));
    ck_assert(!lt_rot_is_near(zero, 0.1) && !lt_rot_is_near(mirror, 0.1) && !lt_rot_is_near(bad, 0.1));
}
END_TEST

static void check_svd(const double A[9])
{
    double U[9], s[3], V[9], US[9], Vt[9], back[9], top = 0;

    lt_svd3(A, U, s, V);
    expect_orthogonal(U, 2e-15);
    expect_orthogonal(V, 2e-15);
    ck_assert(s[0] >= s[1] && s[1] >= s[2] && s[2] >= 0);
    for (int i = 0; i < 9; i++) {
        US[i] = U[i] * s[i % 3];
        top = fmax(top, fabs(A[i]));
    }
    lt_mat3_transpose(V, Vt);
    lt_mat3_mul(US, Vt, back);
    expect_near(back, A, 9, 6e-15 * top);
}

/* 10,000 matrices: full rank, rank 2 and 1 exactly and nearly, graded, permuted, tiny, huge. */
START_TEST(svd_of_anything)
{
    lt_rng r = lt_rng_make(5, 0);

    for (int trial = 0; trial < 10000; trial++) {
        double A[9], size = pow(10, lt_rng_range(&r, -12, 12));
        for (int i = 0; i < 9; i++)
            A[i] = size * lt_rng_normal(&r);
        for (int i = 0; i < 3; i++) {
            if (trial % 5 >= 1)
                A[3 * i + 1] = 2 * A[3 * i] + (trial % 5 == 2 ? 1e-15 * size : 0);
            if (trial % 5 >= 3)
                A[3 * i + 2] = -A[3 * i] + (trial % 5 == 4 ? 1e-17 * A[3 * i + 2] : 0);
        }
        check_svd(A);
    }
}
END_TEST

START_TEST(svd_of_the_worst)
{
    static const double worst[][9] = {
        { 0 }, { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, { 1, 1, 1, 1, 1, 1, 1, 1, 1 },
        { 0, 0, 0, 0, 0, 0, 0, 0, 3 }, { 0, 1, 0, 0, 0, 0, 0, 0, 0 }, { -1, 0, 0, 0, -1, 0, 0, 0, -1 },
        { 1e300, 1e-300, 0, 0, 1e300, 0, 0, 0, 1e-300 }, { 1e-310, 0, 0, 0, 1e-315, 0, 0, 0, 0 },
        { 1e-200, 1e-200, 0, 1e-200, -1e-200, 0, 0, 0, 1e-200 },
    };
    const double bad[9] = { 1, 2, INFINITY, 0, 0, 0, 0, 0, 0 };
    double U[9], s[3], V[9];

    for (size_t k = 0; k < LT_COUNT(worst); k++)
        check_svd(worst[k]);
    lt_svd3(bad, U, s, V);
    ck_assert(isnan(s[0]));
    expect_orthogonal(U, 0);
}
END_TEST

/* The smallest singular value of a graded matrix keeps its digits: one-sided Jacobi's virtue. */
START_TEST(svd_small_values)
{
    const double A[9] = { 1, 0, 0, 0, 1e-8, 0, 0, 0, 1e-16 };
    double U[9], s[3], V[9];

    lt_svd3(A, U, s, V);
    ck_assert_double_eq_tol(s[1] / 1e-8, 1, 1e-15);
    ck_assert_double_eq_tol(s[2] / 1e-16, 1, 1e-15);
}
END_TEST

START_TEST(projection_opengl)
{
    const lt_camera cam = { 614.627, 614.101, 320.262, 238.469 };
    const double want[2] = { 371.480917, 258.939033 }, gl[3] = { .05, -.02, -.6 };
    double p[3] = { .05, -.02, -.6 }, uv[2], back[3];

    ck_assert(!lt_camera_project(&cam, gl, uv));
    lt_flip_yz(p);
    ck_assert(lt_camera_project(&cam, p, uv));
    expect_near(uv, want, 2, 6e-7);
    lt_camera_backproject(&cam, uv, p[2], back);
    expect_near(back, p, 3, 1e-15);
    p[2] = 0;
    ck_assert(!lt_camera_project(&cam, p, uv));
    ck_assert(isfinite(uv[0]) && isfinite(uv[1]));
}
END_TEST

START_TEST(mano_opengl_to_opencv)
{
    const double J0[3] = { .095, .006, .006 }, v[3] = { .03, .01, -.02 };
    const double want_aa[3] = { -2.992752, .454224, .302816 }, want_t[3] = { .02, .018, .588 };
    const double want_v[3] = { .057658, .035293, .632748 };
    double aa[3] = { .1, -.2, .3 }, t[3] = { .02, -.03, -.6 }, d[3], R[9], at[3];

    lt_flip_yz_mano(aa, t, J0);
    expect_near(aa, want_aa, 3, 6e-7);
    expect_near(t, want_t, 3, 1e-15);
    lt_rot_from_axis_angle(aa, R);
    lt_vec3_sub(v, J0, d);
    lt_rigid_apply(R, t, d, at);
    for (int i = 0; i < 3; i++)
        at[i] += J0[i];
    expect_near(at, want_v, 3, 6e-7);
    lt_flip_yz_mano(aa, t, J0);                     /* and back */
    ck_assert_double_eq_tol(aa[0], .1, 1e-14);
    ck_assert_double_eq_tol(t[2], -.6, 1e-15);
}
END_TEST

START_TEST(mirrored_rotation)
{
    const double want[3] = { .1, -.2, -.3 };
    double aa[3] = { .1, .2, .3 };

    lt_mirror_axis_angle(aa);
    expect_near(aa, want, 3, 0);
}
END_TEST

START_TEST(crops)
{
    const lt_camera cam = { 600, 610, 320, 240 };
    const double centre[2] = { 400, 300 }, middle[2] = { 128, 128 }, p[3] = { .1, -.05, .7 };
    const double flat[6] = { 1, 2, 0, 2, 4, 0 };
    double A[6], inv[6], q[2], r[2], seen[2];
    lt_camera crop;

    lt_affine_crop(400, 300, 200, 0.7, 256, A);
    lt_affine_apply(A, centre, q);
    expect_near(q, middle, 2, 1e-12);
    ck_assert_double_eq_tol(A[0], 1.28 * cos(0.7), 1e-15);
    ck_assert_double_eq_tol(A[1], -1.28 * sin(0.7), 1e-15);
    ck_assert_int_eq(lt_affine_inverse(A, inv), LT_OK);
    lt_affine_apply(inv, q, r);
    expect_near(r, centre, 2, 1e-12);
    ck_assert_int_eq(lt_affine_inverse(flat, inv), LT_EINVAL);

    lt_affine_crop(400, 300, 200, 0, 256, A);
    crop = lt_camera_crop(&cam, A);
    lt_camera_project(&cam, p, q);
    lt_affine_apply(A, q, q);
    lt_camera_project(&crop, p, seen);
    expect_near(seen, q, 2, 1e-12);
}
END_TEST

/* The table of the 21 points, spelled out. */
START_TEST(control_points)
{
    static const char *const table[LT_BOX_POINTS] = {
        "lll", "hll", "lhl", "hhl", "llh", "hlh", "lhh", "hhh", "lml", "hml", "mhl",
        "mll", "lmh", "hmh", "mhh", "mlh", "lhm", "llm", "hhm", "hlm", "mmm",
    };
    const float points[3][3] = { { -1, 5, 2 }, { 3, -2, 2.5f }, { 0, 0, 4 } };
    const float bad[3] = { 0, NAN, 0 };
    double out[LT_BOX_POINTS][3];
    lt_box box;

    ck_assert_int_eq(lt_box_from_points(3, points[0], &box), LT_OK);
    ck_assert_double_eq_tol(lt_box_diagonal(&box), sqrt(16 + 49 + 4), 1e-15);
    lt_box21(&box, out);
    for (int i = 0; i < LT_BOX_POINTS; i++)
        for (int k = 0; k < 3; k++) {
            const double lo = box.lo[k], hi = box.hi[k];
            const char c = table[i][k];
            ck_assert_double_eq(out[i][k], c == 'l' ? lo : c == 'h' ? hi : (lo + hi) / 2);
        }
    ck_assert_int_eq(lt_box_from_points(0, points[0], &box), LT_EINVAL);
    ck_assert_int_eq(lt_box_from_points(1, bad, &box), LT_EINVAL);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_test(c, rodrigues_vector);
    tcase_add_test(c, axis_angle_round_trip);
    tcase_add_test(c, half_turns);
    tcase_add_test(c, quaternions);
    tcase_add_test(c, quaternion_algebra);
    tcase_add_test(c, six_numbers);
    tcase_add_test(c, nearest_and_angle);
    tcase_add_test(c, svd_of_anything);
    tcase_add_test(c, svd_of_the_worst);
    tcase_add_test(c, svd_small_values);
    tcase_add_test(c, projection_opengl);
    tcase_add_test(c, mano_opengl_to_opencv);
    tcase_add_test(c, mirrored_rotation);
    tcase_add_test(c, crops);
    tcase_add_test(c, control_points);
}

int main(void)
{
    return run_suite("rotation", add_tests);
}
