/* SPDX-License-Identifier: Apache-2.0 */
/* Predictors without an image: the zero predictor and the mean of a training set. */
#include "tasks/hand_object/predictors.h"

#include "libtensor/base/arena.h"
#include "libtensor/base/rng.h"
#include "libtensor/geometry/rotation.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { J = LT_HAND_KEYPOINTS, V = LT_HAND_VERTICES, N = 4 };

static lt_hand_model *hand;
static float joints[N][J][3], rotation[N][LT_HAND_JOINTS][9], beta[N][LT_HAND_BETAS], R[N][9], t[N][3];
static int32_t object[N] = { 3, -1, 3, 5 };
static const predictor_labels labels = {
    N, joints[0][0], rotation[0][0], beta[0], object, R[0], t[0],
};

static void turn(double angle, float out[9])
{
    const double aa[3] = { 0, 0, angle };
    double M[9];

    lt_rot_from_axis_angle(aa, M);
    for (int k = 0; k < 9; k++)
        out[k] = (float)M[k];
}

/* A stiff hand of random points, moved by its wrist alone; vertex 0 is the wrist. */
static void make_hand(void)
{
    lt_rng rng = lt_rng_make(1, 0);

    hand = calloc(1, sizeof(*hand));
    for (int v = 0; v < V; v++) {
        for (int k = 0; k < 3; k++)
            hand->v_template[v][k] = (float)lt_rng_range(&rng, -.1, .1);
        hand->weights[v][0] = 1;
        hand->shapedirs[v][0][0] = .01f * (v > 0);
    }
    for (int j = 0; j < LT_HAND_JOINTS; j++)
        hand->J_regressor[j][0] = 1;
}

/* Wrists turned by -0.3, 0.3, -0.1, 0.1 about z: the mean is not turned. */
static void setup(void)
{
    static const double angle[N] = { -.3, .3, -.1, .1 };
    lt_rng rng = lt_rng_make(2, 0);

    make_hand();
    for (int i = 0; i < N; i++) {
        for (int k = 0; k < J * 3; k++)
            joints[i][k / 3][k % 3] = (float)lt_rng_range(&rng, -1, 1);
        for (int j = 0; j < LT_HAND_JOINTS; j++)
            turn(j ? 0 : angle[i], rotation[i][j]);
        beta[i][0] = (float)i;                                  /* mean 1.5 */
        turn(angle[i] + .5, R[i]);
        for (int k = 0; k < 3; k++)
            t[i][k] = joints[i][0][k] + (float)(i + k);
    }
}

static void teardown(void)
{
    free(hand);
}

START_TEST(mean_of_hands)
{
    const float wrist[3] = { 1, 2, 3 };
    float p[J][3], v[V][3];
    mean_predictor m;

    ck_assert_int_eq(mean_predictor_fit(&labels, hand, lt_hand_tips_ho3d, &m), LT_OK);
    mean_predictor_hand(&m, wrist, p[0], v[0]);
    for (int k = 0; k < 3; k++) {
        ck_assert_float_eq(p[8][k], v[lt_hand_tips_ho3d[1]][k]);        /* the mesh's own index tip */
        ck_assert_float_eq(p[0][k], wrist[k]);
        ck_assert_float_eq(v[0][k], wrist[k]);
        ck_assert_double_eq_tol(v[9][k], (double)hand->v_template[9][k] - hand->v_template[0][k] + wrist[k]
                                         + (k == 0 ? .015 : 0), 1e-6);
    }
}
END_TEST

START_TEST(mean_of_objects)
{
    const float wrist[3] = { 1, 2, 3 };
    mean_predictor m;
    lt_pose p, none;
    float wanted[9];

    ck_assert_int_eq(mean_predictor_fit(&labels, hand, lt_hand_tips_ho3d, &m), LT_OK);
    ck_assert_int_eq(m.object[3].n, 2);
    ck_assert_int_eq(m.object[5].n, 1);
    p = mean_predictor_object(&m, 3, wrist);
    turn(.3, wanted);                               /* of 0.2 and 0.4 */
    for (int k = 0; k < 9; k++)
        ck_assert_double_eq_tol(p.R[k], wanted[k], 1e-6);
    for (int k = 0; k < 3; k++)
        ck_assert_double_eq_tol(p.t[k], wrist[k] + 1 + k, 1e-6);
    none = zero_predictor_object();
    for (int o = -1; o <= PREDICTOR_OBJECTS; o += PREDICTOR_OBJECTS + 1) {
        p = mean_predictor_object(&m, o, wrist);
        ck_assert_int_eq(memcmp(&p, &none, sizeof(p)), 0);
    }
    p = mean_predictor_object(&m, 4, wrist);
    ck_assert_int_eq(memcmp(&p, &none, sizeof(p)), 0);
    ck_assert_double_eq(none.t[2], 1);
}
END_TEST

START_TEST(zeros)
{
    float p[J][3] = { { 1 } }, v[V][3] = { { 1 } };

    zero_predictor_hand(p[0], v[0]);
    ck_assert(p[0][0] == 0 && v[0][0] == 0 && v[V - 1][2] == 0);
}
END_TEST

START_TEST(bad_labels)
{
    predictor_labels l = labels;
    mean_predictor m;

    l.n = 0;
    ck_assert_int_eq(mean_predictor_fit(&l, hand, lt_hand_tips_ho3d, &m), LT_EINVAL);
    l.n = N;
    l.object = NULL;
    ck_assert_int_eq(mean_predictor_fit(&l, hand, lt_hand_tips_ho3d, &m), LT_OK);
    ck_assert_int_eq(m.object[3].n, 0);
    object[2] = PREDICTOR_OBJECTS;
    ck_assert_int_eq(mean_predictor_fit(&labels, hand, lt_hand_tips_ho3d, &m), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "mean pose: training sample 2 has object 32, want one below 32");
    object[2] = 3;
    t[2][1] = NAN;
    ck_assert_int_eq(mean_predictor_fit(&labels, hand, lt_hand_tips_ho3d, &m), LT_EINVAL);
    beta[1][9] = INFINITY;
    ck_assert_int_eq(mean_predictor_fit(&labels, hand, lt_hand_tips_ho3d, &m), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "mean pose: hand of training sample 1 is not finite");
    lt_alloc_fail_at(1);
    ck_assert_int_ne(mean_predictor_fit(&l, hand, lt_hand_tips_ho3d, &m), LT_OK);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_checked_fixture(c, setup, teardown);
    tcase_add_test(c, mean_of_hands);
    tcase_add_test(c, mean_of_objects);
    tcase_add_test(c, zeros);
    tcase_add_test(c, bad_labels);
}

int main(void)
{
    return run_suite("predictors", add_tests);
}
