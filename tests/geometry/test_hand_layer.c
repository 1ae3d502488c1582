/* SPDX-License-Identifier: Apache-2.0 */
/* The hand layer against NumPy, against itself in double, and its gradient against differences. The same
 * file is built for float and for double. */
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/kernels/kernels.h"

#include "tests/geometry/hand_layer_vectors.h"
#include "tests/geometry/hashed_hand.h"
#include "tests/suite.h"

enum { V = LT_HAND_VERTICES, J = LT_HAND_JOINTS, B = LT_HAND_BETAS, K = LT_HAND_KEYPOINTS, MOST = 70 };

#ifdef LT_DOUBLE
static const double TOL = 1e-14;
#else
static const double TOL = 1e-7;
#endif

static lt_arena *arena;
static lt_hand_model *hand;
static lt_hand_layer *layer;
static void *scratch;               /* of MOST samples */

static void fill_real(uint32_t seed, lt_real *out, size_t n)
{
    for (size_t i = 0; i < n; i++)
        out[i] = (lt_real)hashed(seed, (uint32_t)i);
}

static void make_hand(void)
{
    arena = lt_arena_new();
    hand = lt_arena_alloc(arena, sizeof(*hand));
    hashed_hand(hand);
    ck_assert_int_eq(lt_hand_layer_new(arena, hand, lt_hand_tips_ho3d, &layer), LT_OK);
    scratch = lt_arena_alloc(arena, lt_skin_scratch_bytes(layer, MOST));
    ck_assert_ptr_nonnull(scratch);
}

static void free_hand(void)
{
    lt_arena_free(arena);
}

static void sample_pose(lt_real R[9 * J], lt_real beta[B])
{
    fill_real(4, beta, B);
    for (int j = 0; j < J; j++) {
        double aa[3], M[9];
        for (int a = 0; a < 3; a++)
            aa[a] = hashed(5, (uint32_t)(3 * j + a));
        lt_rot_from_axis_angle(aa, M);
        for (int i = 0; i < 9; i++)
            R[9 * j + i] = (lt_real)M[i];
    }
}

static void widen(const lt_real *x, int n, double *out)
{
    for (int i = 0; i < n; i++)
        out[i] = x[i];
}

static void expect_near(const lt_real *got, const double *want, int n, double tol)
{
    for (int i = 0; i < n; i++)
        ck_assert_msg(fabs((double)got[i] - want[i]) <= tol, "[%d] is %.9g, want %.9g", i, (double)got[i],
                      want[i]);
}

START_TEST(values)
{
    lt_real R[9 * J], beta[B], v[3 * V], kp[3 * K];
    double mean[3] = { 0 };

    sample_pose(R, beta);
    lt_skin_forward(layer, 1, R, beta, v, kp, scratch);
    expect_near(kp, want_keypoints[0], 3 * K, TOL);
    for (size_t i = 0; i < LT_COUNT(shown_vertex); i++)
        expect_near(v + 3 * shown_vertex[i], want_shown[i], 3, TOL);
    for (int i = 0; i < 3 * V; i++)
        mean[i % 3] += v[i] / V;
    for (int a = 0; a < 3; a++)
        ck_assert_double_eq_tol(mean[a], want_mean_vertex[0][a], TOL);
}
END_TEST

/* The plain formula with a translation, less the wrist, is the layer. */
START_TEST(plain_formula_agrees)
{
    const double trans[3] = { .3, -.2, .7 };
    double Rd[9 * J], betad[B], v[3 * V], joints[3 * J], kp[3 * K], mano[3 * K], only[3 * J], rest[3];
    lt_real R[9 * J], beta[B], lv[3 * V], lkp[3 * K];

    sample_pose(R, beta);
    widen(R, 9 * J, Rd);
    widen(beta, B, betad);
    lt_hand_pose(hand, Rd, betad, trans, v, joints);
    lt_hand_pose(hand, Rd, betad, trans, NULL, only);
    ck_assert_mem_eq(joints, only, sizeof(only));
    lt_hand_rest_wrist(hand, betad, rest);
    for (int a = 0; a < 3; a++)
        ck_assert_double_eq_tol(joints[a], rest[a] + trans[a], 1e-15);
    lt_hand_keypoints(v, joints, lt_hand_tips_ho3d, LT_HAND_SIMPLE_ORDER, kp);
    lt_hand_keypoints(v, joints, lt_hand_tips_ho3d, LT_HAND_MANO_ORDER, mano);
    for (int i = 0; i < K; i++)
        ck_assert_mem_eq(mano + 3 * i, kp + 3 * lt_simple_to_mano[i], 3 * sizeof(*kp));
    for (int i = 0; i < 3 * V; i++)
        v[i] -= joints[i % 3];
    for (int i = 0; i < 3 * K; i++)
        kp[i] -= joints[i % 3];
    lt_skin_forward(layer, 1, R, beta, lv, lkp, scratch);
    expect_near(lv, v, 3 * V, TOL);
    expect_near(lkp, kp, 3 * K, TOL);
}
END_TEST

/* A chain of three joints and a vertex that hangs on all: the numbers of the
 * skinning formula in double precision. */
START_TEST(chain_of_three)
{
    const double want_joint[9] = { 0, 0, 0, .088206, .017880, 0, .080259, .057083, 0 };
    const double want_vertex[3] = { .079688, .062417, -.001023 };
    const double aa[3][3] = { { 0, 0, .2 }, { 0, 0, M_PI / 2 }, { 0, .5, 0 } }, beta[B] = { 0 };
    const float at[4][3] = { { 0, 0, 0 }, { .09f, 0, 0 }, { .13f, 0, 0 }, { .14f, .005f, .002f } };
    double R[9 * J], v[3 * V], joints[3 * J];

    memset(hand, 0, sizeof(*hand));
    memcpy(hand->v_template, at, sizeof(at));
    for (int j = 0; j < 3; j++)
        hand->J_regressor[j][j] = 1;
    for (int i = 0; i < 9 * J; i++)
        R[i] = i % 9 % 4 == 0;
    for (int j = 0; j < 3; j++)
        lt_rot_from_axis_angle(aa[j], R + 9 * j);
    hand->weights[3][0] = .1f;
    hand->weights[3][1] = .3f;
    hand->weights[3][2] = .6f;
    lt_hand_pose(hand, R, beta, NULL, v, joints);
    for (int i = 0; i < 9; i++)
        ck_assert_double_eq_tol(joints[i], want_joint[i], 6e-7);
    for (int a = 0; a < 3; a++)
        ck_assert_double_eq_tol(v[9 + a], want_vertex[a], 6e-7);
}
END_TEST

static void zero_pose(lt_real R[9 * J], lt_real beta[B])
{
    memset(beta, 0, B * sizeof(*beta));
    for (int i = 0; i < 9 * J; i++)
        R[i] = i % 9 % 4 == 0;
}

START_TEST(zero_pose_is_the_template)
{
    const double no_beta[B] = { 0 };
    lt_real R[9 * J], beta[B], v[3 * V], kp[3 * K];
    double wrist[3], want[3 * V];

    zero_pose(R, beta);
    lt_skin_forward(layer, 1, R, beta, v, kp, scratch);
    lt_hand_rest_wrist(hand, no_beta, wrist);
    for (int i = 0; i < 3 * V; i++)
        want[i] = hand->v_template[i / 3][i % 3] - wrist[i % 3];
    expect_near(v, want, 3 * V, TOL);
    for (int a = 0; a < 3; a++)
        ck_assert_double_eq((double)kp[a], 0);
}
END_TEST

/* Together they are one product of the blends, alone a sum of their own: the same bits. */
START_TEST(many_are_as_each_alone)
{
    enum { MANY = 5 };
    static lt_real R[MANY][9 * J], beta[MANY][B], v[MANY][3 * V], kp[MANY][3 * K], v1[3 * V], kp1[3 * K];

    for (int i = 0; i < MANY; i++) {
        sample_pose(R[i], beta[i]);
        for (int k = 0; k < B; k++)
            beta[i][k] += (lt_real)(0.25 * i);
    }
    lt_skin_forward(layer, MANY, R[0], beta[0], v[0], kp[0], scratch);
    for (int i = 0; i < MANY; i++) {
        lt_skin_forward(layer, 1, R[i], beta[i], v1, kp1, scratch);
        ck_assert_mem_eq(v[i], v1, sizeof(v1));
        ck_assert_mem_eq(kp[i], kp1, sizeof(kp1));
    }
}
END_TEST

/* So many that they are cut, and that AMX's tiles make the blends where there are any: the same hands, if not the same
 * bits. */
START_TEST(a_crowd_is_as_each_alone)
{
    enum { CROWD = MOST };
    static lt_real R[CROWD][9 * J], beta[CROWD][B], v[CROWD][3 * V], kp[CROWD][3 * K], v1[3 * V], kp1[3 * K];
    static double want[3 * V], want_kp[3 * K];

    for (int i = 0; i < CROWD; i++) {
        sample_pose(R[i], beta[i]);
        beta[i][i % B] += (lt_real)(0.02 * i);
    }
    lt_skin_forward(layer, CROWD, R[0], beta[0], v[0], kp[0], scratch);
    for (int i = 0; i < CROWD; i++) {
        lt_skin_forward(layer, 1, R[i], beta[i], v1, kp1, scratch);
        widen(v1, 3 * V, want);
        widen(kp1, 3 * K, want_kp);
        expect_near(v[i], want, 3 * V, 3 * TOL);
        expect_near(kp[i], want_kp, 3 * K, 3 * TOL);
    }
}
END_TEST

/* A layer is laid out for the instruction set in use when it was made: another one gives the same bits. */
START_TEST(any_instruction_set)
{
    enum { MANY = 5 };
    static lt_real R[MANY][9 * J], beta[MANY][B], v[2][MANY][3 * V], kp[2][MANY][3 * K];
    lt_kernels generic;

    for (int i = 0; i < MANY; i++)
        sample_pose(R[i], beta[i]);
    ck_assert_int_eq(lt_kernels_get(LT_ISA_GENERIC, &generic), LT_OK);
    lt_skin_forward(layer, MANY, R[0], beta[0], v[0][0], kp[0][0], scratch);
    lt_kernels_use(&generic);
    lt_skin_forward(layer, MANY, R[0], beta[0], v[1][0], kp[1][0], scratch);
    lt_kernels_use(NULL);
    ck_assert_mem_eq(v[0], v[1], sizeof(v[0]));
    ck_assert_mem_eq(kp[0], kp[1], sizeof(kp[0]));
}
END_TEST

/* Whoever makes a layer before anything else has it packed for the kernels that will run it. */
START_TEST(packed_for_the_kernels_in_use)
{
    const lt_isa made_for = lt_k->isa;

    ck_assert_int_eq(lt_kernels_init(), LT_OK);
    ck_assert_int_eq(made_for, lt_k->isa);
}
END_TEST

START_TEST(root_rotation_is_rigid)
{
    const double aa[3] = { .7, -1.1, .4 };
    lt_real R[9 * J], beta[B], v[3 * V], kp[3 * K], turned_v[3 * V];
    double M[9], want[3 * V];

    sample_pose(R, beta);
    for (int i = 0; i < 9; i++)
        R[i] = i % 4 == 0;
    lt_skin_forward(layer, 1, R, beta, v, kp, scratch);
    lt_rot_from_axis_angle(aa, M);
    for (int i = 0; i < 9; i++)
        R[i] = (lt_real)M[i];
    lt_skin_forward(layer, 1, R, beta, turned_v, kp, scratch);
    for (int i = 0; i < V; i++) {
        double x[3];
        widen(v + 3 * i, 3, x);
        lt_mat3_mulvec(M, x, want + 3 * i);
    }
    expect_near(turned_v, want, 3 * V, 3 * TOL);
}
END_TEST

/* The gradient of the script's loss along the script's direction. */
START_TEST(slope)
{
    lt_real R[9 * J], beta[B], v[3 * V], kp[3 * K], gv[3 * V], gk[3 * K];
    lt_real dR[9 * J] = { 0 }, dbeta[B] = { 0 };
    double sum = 0;

    sample_pose(R, beta);
    fill_real(6, gv, 3 * V);
    fill_real(7, gk, 3 * K);
    lt_skin_forward(layer, 1, R, beta, v, kp, scratch);
    lt_skin_backward(layer, 1, R, gv, gk, dR, dbeta, scratch);
    for (int i = 0; i < 9 * J; i++)
        sum += hashed(8, (uint32_t)i) * dR[i];
    for (int i = 0; i < B; i++)
        sum += hashed(9, (uint32_t)i) * dbeta[i];
    ck_assert_double_eq_tol(sum / want_slope, 1, sizeof(lt_real) == 8 ? 1e-10 : 1e-5);
}
END_TEST

/* Gradients are added; either gradient may be absent; together they are the sum. */
START_TEST(gradients_add)
{
    lt_real R[9 * J], beta[B], v[3 * V], kp[3 * K], gv[3 * V], gk[3 * K];
    lt_real both[9 * J + B] = { 0 }, each[9 * J + B] = { 0 };

    sample_pose(R, beta);
    fill_real(6, gv, 3 * V);
    fill_real(7, gk, 3 * K);
    lt_skin_forward(layer, 1, R, beta, v, kp, scratch);
    lt_skin_backward(layer, 1, R, gv, gk, both, both + 9 * J, scratch);
    lt_skin_forward(layer, 1, R, beta, v, kp, scratch);
    lt_skin_backward(layer, 1, R, gv, NULL, each, each + 9 * J, scratch);
    lt_skin_forward(layer, 1, R, beta, v, kp, scratch);
    lt_skin_backward(layer, 1, R, NULL, gk, each, each + 9 * J, scratch);
    for (int i = 0; i < 9 * J + B; i++)
        ck_assert_double_eq_tol((double)both[i], (double)each[i], 100 * TOL);
}
END_TEST

#ifdef LT_DOUBLE
static double loss(const lt_real *R, const lt_real *beta, const lt_real *gv, const lt_real *gk)
{
    lt_real v[3 * V], kp[3 * K];
    double sum = 0;

    lt_skin_forward(layer, 1, R, beta, v, kp, scratch);
    for (int i = 0; i < 3 * V; i++)
        sum += gv[i] * v[i];
    for (int i = 0; i < 3 * K; i++)
        sum += gk[i] * kp[i];
    return sum;
}

/* Every one of the 154 inputs, against central differences. */
START_TEST(gradient)
{
    const double e = 1e-5;
    lt_real R[9 * J], beta[B], v[3 * V], kp[3 * K], gv[3 * V], gk[3 * K];
    lt_real dR[9 * J] = { 0 }, dbeta[B] = { 0 };

    sample_pose(R, beta);
    fill_real(6, gv, 3 * V);
    fill_real(7, gk, 3 * K);
    lt_skin_forward(layer, 1, R, beta, v, kp, scratch);
    lt_skin_backward(layer, 1, R, gv, gk, dR, dbeta, scratch);
    for (int i = 0; i < 9 * J + B; i++) {
        lt_real *x = i < 9 * J ? &R[i] : &beta[i - 9 * J];
        const double got = i < 9 * J ? dR[i] : dbeta[i - 9 * J], x0 = *x;
        double up, down, want;
        *x = x0 + e;
        up = loss(R, beta, gv, gk);
        *x = x0 - e;
        down = loss(R, beta, gv, gk);
        *x = x0;
        want = (up - down) / (2 * e);
        ck_assert_msg(fabs(got - want) <= 1e-6 * fmax(1, fabs(want)), "input %d: %.12g, want %.12g", i, got,
                      want);
    }
}
END_TEST
#endif

START_TEST(bad_tip)
{
    const int tips[5] = { 0, 1, 2, 3, V };
    lt_hand_layer *none = NULL;

    ck_assert_int_eq(lt_hand_layer_new(arena, hand, tips, &none), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "hand layer: finger tip 4 is vertex 778, want 0 to 777");
    ck_assert_ptr_null(none);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_checked_fixture(c, make_hand, free_hand);
    tcase_add_test(c, values);
    tcase_add_test(c, plain_formula_agrees);
    tcase_add_test(c, chain_of_three);
    tcase_add_test(c, zero_pose_is_the_template);
    tcase_add_test(c, many_are_as_each_alone);
    tcase_add_test(c, a_crowd_is_as_each_alone);
    tcase_add_test(c, any_instruction_set);
    tcase_add_test(c, packed_for_the_kernels_in_use);
    tcase_add_test(c, root_rotation_is_rigid);
    tcase_add_test(c, slope);
    tcase_add_test(c, gradients_add);
#ifdef LT_DOUBLE
    tcase_add_test(c, gradient);
#endif
    tcase_add_test(c, bad_tip);
}

int main(void)
{
    return run_suite("hand_layer " LT_REAL_FMT, add_tests);
}
