/* SPDX-License-Identifier: Apache-2.0 */
/* Skinning of a rig of SMPL-X's size, against NumPy and against itself in double; and what is no rig. */
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/geometry/skin/skin.h"

#include "tests/geometry/hashed_rig.h"
#include "tests/geometry/skin_vectors.h"
#include "tests/suite.h"

#include <math.h>

enum { V = 10475, J = 55, S = 20, SAMPLES = 5 };

static const double TOL = 3e-7;

static lt_arena *arena;
static lt_rig rig;
static lt_skin_layer *layer;
static int points[J];
static lt_real *R, *shape, *vertices, *joints;
static void *scratch;

static lt_real *reals(size_t n)
{
    return lt_arena_array(arena, n, sizeof(lt_real));
}

/* The script's pose, and others */
static void make_poses(void)
{
    for (int i = 0; i < SAMPLES * J; i++) {
        double aa[3], M[9];

        for (int a = 0; a < 3; a++)
            aa[a] = hashed(5, (uint32_t)(3 * i + a));
        lt_rot_from_axis_angle(aa, M);
        for (int k = 0; k < 9; k++)
            R[9 * i + k] = (lt_real)M[k];
    }
    for (int i = 0; i < SAMPLES * S; i++)
        shape[i] = (lt_real)hashed(4, (uint32_t)i);
}

static void make_rig(void)
{
    arena = lt_arena_new();
    rig = hashed_rig(arena, V, J, S);
    for (int j = 0; j < J; j++)
        points[j] = j;
    ck_assert_int_eq(lt_skin_layer_new(arena, &rig, points, J, &layer), LT_OK);
    R = reals(SAMPLES * 9 * J);
    shape = reals(SAMPLES * S);
    vertices = reals(SAMPLES * 3 * V);
    joints = reals(SAMPLES * 3 * J);
    scratch = lt_arena_alloc(arena, lt_skin_scratch_bytes(layer, SAMPLES));
    make_poses();
}

static void free_rig(void)
{
    lt_arena_free(arena);
}

static void expect_near(const lt_real *got, const double *want, int n, double tol)
{
    for (int i = 0; i < n; i++)
        ck_assert_msg(fabs((double)got[i] - want[i]) <= tol, "[%d] is %.9g, want %.9g", i, (double)got[i], want[i]);
}

START_TEST(values)
{
    double mean[3] = { 0 };

    lt_skin_forward(layer, 1, R, shape, vertices, joints, scratch);
    expect_near(joints, want_joints[0], 3 * J, TOL);
    for (size_t i = 0; i < LT_COUNT(shown_vertex); i++)
        expect_near(vertices + 3 * shown_vertex[i], want_shown[i], 3, TOL);
    for (int i = 0; i < 3 * V; i++)
        mean[i % 3] += vertices[i] / V;
    for (int a = 0; a < 3; a++)
        ck_assert_double_eq_tol(mean[a], want_mean_vertex[0][a], TOL);
}
END_TEST

/* The plain formula with a translation, less the root, is the layer. */
START_TEST(plain_formula_agrees)
{
    const double trans[3] = { .3, -.2, .7 };
    double *v = lt_arena_array(arena, 3 * V, sizeof(*v)), R_wide[9 * J], wide[S], at[3 * J], only[3 * J], root[3];

    for (int i = 0; i < 9 * J; i++)
        R_wide[i] = R[i];
    for (int i = 0; i < S; i++)
        wide[i] = shape[i];
    lt_rig_pose(&rig, R_wide, wide, trans, v, at);
    lt_rig_pose(&rig, R_wide, wide, trans, NULL, only);
    ck_assert_mem_eq(at, only, sizeof(only));
    lt_rig_root(&rig, wide, root);
    for (int a = 0; a < 3; a++)
        ck_assert_double_eq_tol(at[a], root[a] + trans[a], 1e-15);
    for (int i = 0; i < 3 * V; i++)
        v[i] -= root[i % 3] + trans[i % 3];
    lt_skin_forward(layer, 1, R, shape, vertices, joints, scratch);
    expect_near(vertices, v, 3 * V, TOL);
}
END_TEST

/* The gradient of the script's loss along the script's direction */
START_TEST(slope)
{
    lt_real *g_v = reals(3 * V), *g_j = reals(3 * J), *dR = reals(9 * J), *d_shape = reals(S);
    double sum = 0;

    for (uint32_t i = 0; i < 3 * V; i++)
        g_v[i] = (lt_real)hashed(6, i);
    for (uint32_t i = 0; i < 3 * J; i++)
        g_j[i] = (lt_real)hashed(7, i);
    lt_skin_forward(layer, 1, R, shape, vertices, joints, scratch);
    lt_skin_backward(layer, 1, R, g_v, g_j, dR, d_shape, scratch);
    for (uint32_t i = 0; i < 9 * J; i++)
        sum += hashed(8, i) * (double)dR[i];
    for (uint32_t i = 0; i < S; i++)
        sum += hashed(9, i) * (double)d_shape[i];
    ck_assert_double_eq_tol(sum / want_slope, 1, 2e-5);
}
END_TEST

/* Samples of a batch are as each alone, with any number of threads. */
START_TEST(same_bits)
{
    lt_real *v = reals(3 * V), *j = reals(3 * J);

    lt_set_threads(3);
    lt_skin_forward(layer, SAMPLES, R, shape, vertices, joints, scratch);
    lt_set_threads(1);
    for (int i = 0; i < SAMPLES; i++) {
        lt_skin_forward(layer, 1, R + i * 9 * J, shape + i * S, v, j, scratch);
        ck_assert_mem_eq(vertices + i * 3 * V, v, 3 * V * sizeof(*v));
        ck_assert_mem_eq(joints + i * 3 * J, j, 3 * J * sizeof(*j));
    }
    lt_set_threads(0);
}
END_TEST

static void expect_refused(const lt_rig *wrong, int point, const char *message)
{
    lt_skin_layer *none = NULL;

    ck_assert_int_eq(lt_skin_layer_new(arena, wrong, &point, 1, &none), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), message);
    ck_assert_ptr_null(none);
}

START_TEST(no_rig)
{
    int parents[J];
    lt_rig wrong = rig;

    expect_refused(&wrong, J + V, "skin layer: point 0 is 10530, want a joint, 0 to 54, or a vertex, 55 to 10529");
    expect_refused(&wrong, -1, "skin layer: point 0 is -1, want a joint, 0 to 54, or a vertex, 55 to 10529");
    wrong.J = LT_RIG_JOINTS + 1;
    expect_refused(&wrong, 0, "skin layer: 10475 vertices, 129 joints and 20 shape directions, want at least 1, "
                   "1 to 128, and at least 0");
    wrong.J = J;
    wrong.parents = parents;
    memcpy(parents, rig.parents, sizeof(parents));
    parents[7] = 7;
    expect_refused(&wrong, 0, "skin layer: joint 7 has parent 7, want a joint before it");
    parents[7] = -1;
    expect_refused(&wrong, 0, "skin layer: joint 7 has parent -1, want a joint before it");
    parents[0] = 3;
    expect_refused(&wrong, 0, "skin layer: joint 0 has parent 3, want -1");
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_checked_fixture(c, make_rig, free_rig);
    tcase_add_test(c, values);
    tcase_add_test(c, plain_formula_agrees);
    tcase_add_test(c, slope);
    tcase_add_test(c, same_bits);
    tcase_add_test(c, no_rig);
}

int main(void)
{
    return run_suite("skin", add_tests);
}
