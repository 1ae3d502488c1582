/* SPDX-License-Identifier: Apache-2.0 */
/* The HO3D score against a NumPy and SciPy writing of the official script. */
#include "eval/scorers/ho3d/score.h"

#include "libtensor/base/arena.h"
#include "libtensor/base/parallel.h"
#include "tests/eval/scorers/ho3d_vectors.h"
#include "tests/eval/scorers/predictions.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { J = LT_HAND_KEYPOINTS, V = LT_HAND_VERTICES, N = 4 };

typedef struct {
    float p_xyz[N][J][3], p_verts[N][V][3], g_xyz[N][J][3], g_verts[N][V][3];
} samples;

static samples *make_samples(int kind)
{
    samples *s = calloc(1, sizeof(*s));
    uint32_t state = (uint32_t)kind + 1;

    for (int i = 0; i < N; i++) {
        make_predictions(kind, &state, J, s->g_xyz[i], s->p_xyz[i]);
        make_predictions(kind, &state, V, s->g_verts[i], s->p_verts[i]);
    }
    return s;
}

static void add(ho3d_scorer *scorer, const samples *s, int first, int n, ho3d_sample_errors *each)
{
    ck_assert_int_eq(ho3d_scorer_add(scorer, n, s->p_xyz[first][0], s->p_verts[first][0],
                                     s->g_xyz[first][0], s->g_verts[first][0], each), LT_OK);
}

static void score(const samples *s, double scores[HO3D_SCORES])
{
    ho3d_scorer *scorer = ho3d_scorer_new();

    add(scorer, s, 0, N, NULL);
    ho3d_scorer_scores(scorer, scores);
    ho3d_scorer_free(scorer);
}

START_TEST(like_the_official_script)
{
    samples *s = make_samples(_i);
    double scores[HO3D_SCORES];

    score(s, scores);
    for (int k = 0; k < HO3D_SCORES; k++)
        ck_assert_msg(fabs(scores[k] - ho3d_wanted[_i][k]) < 1e-7, "score %d: %.9f, want %.9f", k,
                      scores[k], ho3d_wanted[_i][k]);
    free(s);
}
END_TEST

START_TEST(perfect_predictions)
{
    samples *s = make_samples(0);
    double scores[HO3D_SCORES];

    memcpy(s->p_xyz, s->g_xyz, sizeof(s->g_xyz));
    memcpy(s->p_verts, s->g_verts, sizeof(s->g_verts));
    score(s, scores);
    for (int k = 0; k < HO3D_F_5; k += 2) {
        ck_assert_double_eq_tol(scores[k], 0, 1e-6);
        ck_assert_double_ge(scores[k + 1], 1 - .51 / 99);       /* rounding may miss the threshold 0 */
    }
    for (int k = HO3D_F_5; k < HO3D_SCORES; k++)
        ck_assert_double_eq(scores[k], 1);
    free(s);
}
END_TEST

/* The same bits on one thread and on many, in one call and in four. */
START_TEST(threads_and_calls)
{
    samples *s = make_samples(1);
    double one[HO3D_SCORES], many[HO3D_SCORES];
    ho3d_sample_errors each[N];
    ho3d_scorer *scorer = ho3d_scorer_new();
    double mean = 0;

    lt_set_threads(1);
    score(s, one);
    lt_set_threads(5);
    for (int i = 0; i < N; i++)
        add(scorer, s, i, 1, &each[i]);
    ho3d_scorer_scores(scorer, many);
    ck_assert_int_eq(memcmp(one, many, sizeof(one)), 0);
    for (int i = 0; i < N; i++)
        mean += each[i].xyz_pa / N;
    ck_assert_double_eq_tol(100 * mean, one[HO3D_XYZ_PA_MEAN], 1e-9);
    ho3d_scorer_free(scorer);
    free(s);
}
END_TEST

START_TEST(failures_are_counted)
{
    samples *s = make_samples(0);
    ho3d_scorer *scorer = ho3d_scorer_new();
    ho3d_sample_errors each[N];
    double scores[HO3D_SCORES];

    if (_i)
        s->p_verts[2][700][1] = INFINITY;
    else
        s->p_xyz[2][5][0] = NAN;
    add(scorer, s, 0, N, each);
    ho3d_scorer_scores(scorer, scores);
    ck_assert_int_eq(ho3d_scorer_failed(scorer), 1);
    ck_assert(isinf(_i ? each[2].mesh : each[2].xyz) && each[2].f15 == 0 && each[2].f_al15 == 0);
    ck_assert(isnan(scores[_i ? HO3D_MESH_MEAN : HO3D_XYZ_MEAN]));
    ck_assert_double_eq_tol(scores[HO3D_F_AL_15], (N - 1.) / N, 1e-12);
    ck_assert_double_lt(scores[_i ? HO3D_MESH_PA_AUC : HO3D_XYZ_PA_AUC], .75);
    ho3d_scorer_free(scorer);
    free(s);
}
END_TEST

START_TEST(no_samples)
{
    ho3d_scorer *scorer = ho3d_scorer_new();
    double scores[HO3D_SCORES];

    ck_assert_int_eq(ho3d_scorer_add(scorer, 0, NULL, NULL, NULL, NULL, NULL), LT_OK);
    ho3d_scorer_scores(scorer, scores);
    for (int k = 0; k < HO3D_SCORES; k++)
        ck_assert(isnan(scores[k]));
    ho3d_scorer_free(scorer);
    ho3d_scorer_free(NULL);
}
END_TEST

START_TEST(score_file)
{
    const double scores[HO3D_SCORES] = { 56.87, 0, 5.19, .1, 1, .25, 57.12, 0, 5.47, .5, 0, 0, 0, .017 };
    static const char wanted[] =
        "xyz_mean3d: 56.870000\nxyz_auc3d: 0.000000\nxyz_procrustes_al_mean3d: 5.190000\n"
        "xyz_procrustes_al_auc3d: 0.100000\nxyz_scale_trans_al_mean3d: 1.000000\n"
        "xyz_scale_trans_al_auc3d: 0.250000\nmesh_mean3d: 57.120000\nmesh_auc3d: 0.000000\n"
        "mesh_al_mean3d: 5.470000\nmesh_al_auc3d: 0.500000\nf_score_5: 0.000000\n"
        "f_al_score_5: 0.000000\nf_score_15: 0.000000\nf_al_score_15: 0.017000\n";
    char found[sizeof(wanted) + 16] = "";
    FILE *f;

    ck_assert_int_eq(ho3d_write_scores("test_scores.txt", scores), LT_OK);
    f = fopen("test_scores.txt", "r");
    ck_assert_uint_eq(fread(found, 1, sizeof(found), f), sizeof(wanted) - 1);
    fclose(f);
    unlink("test_scores.txt");
    ck_assert_str_eq(found, wanted);
    ck_assert_int_eq(ho3d_write_scores("no/such/folder/scores.txt", scores), LT_EIO);
}
END_TEST

START_TEST(from_our_axes_and_order)
{
    float joints[J][3], out[J][3], vertices[V][3] = { { 1, 2, 3 } }, turned[V][3];

    for (int i = 0; i < J; i++) {
        for (int k = 0; k < 3; k++)
            joints[i][k] = (float)(i + 100 * k);
    }
    ho3d_joints_from_camera(joints[0], out[0]);
    ck_assert_float_eq(out[1][0], 5);               /* index MCP */
    ck_assert_float_eq(out[16][1], -104);           /* thumb tip */
    ck_assert_float_eq(out[20][2], -220);           /* little tip */
    ho3d_vertices_from_camera(vertices[0], turned[0]);
    ck_assert(turned[0][0] == 1 && turned[0][1] == -2 && turned[0][2] == -3);
}
END_TEST

START_TEST(no_memory)
{
    samples *s = make_samples(0);
    ho3d_scorer *scorer;
    int refused = 0;

    for (int i = 1; i < 40; i++) {
        lt_alloc_fail_at(i);
        scorer = ho3d_scorer_new();
        refused += !scorer;
        ho3d_scorer_free(scorer);
    }
    lt_alloc_fail_at(0);
    ck_assert_int_ge(refused, 6);
    scorer = ho3d_scorer_new();
    lt_alloc_fail_at(3);
    ck_assert_int_eq(ho3d_scorer_add(scorer, N, s->p_xyz[0][0], s->p_verts[0][0], s->g_xyz[0][0],
                                     s->g_verts[0][0], NULL), LT_ENOMEM);
    ho3d_scorer_free(scorer);
    free(s);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_loop_test(t, like_the_official_script, 0, 5);
    tcase_add_test(t, perfect_predictions);
    tcase_add_test(t, threads_and_calls);
    tcase_add_loop_test(t, failures_are_counted, 0, 2);
    tcase_add_test(t, no_samples);
    tcase_add_test(t, score_file);
    tcase_add_test(t, from_our_axes_and_order);
    tcase_add_test(t, no_memory);
}

int main(void)
{
    return run_suite("ho3d_score", add_tests);
}
