/* SPDX-License-Identifier: Apache-2.0 */
/* The DexYCB hand score against NumPy and SciPy. */
#include "eval/scorers/dexycb_score.h"

#include "libtensor/base/arena.h"
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/hand/model.h"
#include "tests/eval/scorers/dexycb_vectors.h"
#include "tests/eval/scorers/predictions.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { J = LT_HAND_KEYPOINTS, N = 4 };

static float p[N][J][3], g[N][J][3];

static void make_samples(int kind)
{
    uint32_t state = 201 + (uint32_t)kind;

    for (int i = 0; i < N; i++)
        make_predictions(kind, &state, J, g[i], p[i]);
}

static void score(int calls, double scores[DEXYCB_SCORES], dexycb_sample_errors *each)
{
    dexycb_scorer *s = dexycb_scorer_new();

    for (int i = 0; i < calls; i++)
        dexycb_scorer_add(s, N / calls, p[i * N / calls][0], g[i * N / calls][0],
                          each ? each + i * N / calls : NULL);
    dexycb_scorer_scores(s, scores);
    dexycb_scorer_free(s);
}

START_TEST(like_numpy)
{
    double scores[DEXYCB_SCORES];

    make_samples(_i);
    score(1, scores, NULL);
    for (int k = 0; k < DEXYCB_SCORES; k++)
        ck_assert_msg(fabs(scores[k] - dexycb_wanted[_i][k]) < 1e-7 * (1 + scores[k]), "%s: %.9f, want %.9f",
                      dexycb_score_name((dexycb_score)k), scores[k], dexycb_wanted[_i][k]);
}
END_TEST

START_TEST(threads_and_calls)
{
    double one[DEXYCB_SCORES], many[DEXYCB_SCORES];
    dexycb_sample_errors each[N];
    double mean = 0;

    make_samples(1);
    lt_set_threads(1);
    score(1, one, NULL);
    lt_set_threads(3);
    score(N, many, each);
    ck_assert_int_eq(memcmp(one, many, sizeof(one)), 0);
    for (int i = 0; i < N; i++)
        mean += 1000 * each[i].relative / N;
    ck_assert_double_eq_tol(mean, one[DEXYCB_RELATIVE_MEAN], 1e-9);
}
END_TEST

START_TEST(failures_and_nothing)
{
    dexycb_scorer *s = dexycb_scorer_new();
    double scores[DEXYCB_SCORES];

    dexycb_scorer_scores(s, scores);
    for (int k = 0; k < DEXYCB_SCORES; k++)
        ck_assert(isnan(scores[k]));
    make_samples(0);
    p[1][4][2] = NAN;
    dexycb_scorer_add(s, N, p[0][0], g[0][0], NULL);
    dexycb_scorer_scores(s, scores);
    for (int k = 0; k < DEXYCB_SCORES; k += 2)
        ck_assert(isnan(scores[k]) && scores[k + 1] > .7 && scores[k + 1] < 1);
    dexycb_scorer_free(s);
    for (int i = 1; i < 20; i++) {
        lt_alloc_fail_at(i);
        dexycb_scorer_free(dexycb_scorer_new());
    }
    lt_alloc_fail_at(0);
}
END_TEST

START_TEST(result_line)
{
    char *text = NULL;
    size_t size;
    FILE *f = open_memstream(&text, &size);
    int fields = 1;

    make_samples(0);
    p[0][0][0] = .0125f;
    p[0][J - 1][2] = -.5f;
    dexycb_hpe_line(f, 46, p[0][0]);
    fclose(f);
    for (const char *c = text; *c; c++)
        fields += *c == ',';
    ck_assert_int_eq(fields, 64);
    ck_assert_int_eq(strncmp(text, "46,12.5,", 8), 0);
    ck_assert_str_eq(text + size - 6, ",-500\n");
    free(text);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_loop_test(t, like_numpy, 0, 5);
    tcase_add_test(t, threads_and_calls);
    tcase_add_test(t, failures_and_nothing);
    tcase_add_test(t, result_line);
}

int main(void)
{
    return run_suite("dexycb_score", add_tests);
}
