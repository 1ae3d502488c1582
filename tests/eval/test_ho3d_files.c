/* SPDX-License-Identifier: Apache-2.0 */
/* Prediction files against ground truth, both as streams: the scores of the samples themselves, and every way such
 * files are broken. */
#include "data/ho3d/points.h"
#include "eval/scorers/ho3d_files.h"
#include "eval/scorers/ho3d_submission.h"

#include "libtensor/base/rng.h"
#include "libtensor/geometry/hand/model.h"
#include "libtensor/io/text/number.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

enum { J = LT_HAND_KEYPOINTS, V = LT_HAND_VERTICES, N = 70 };

static float (*p_xyz)[J][3], (*g_xyz)[J][3], (*p_verts)[V][3], (*g_verts)[V][3];

static void write_truth(const char *path, const float *x, int n, int points)
{
    FILE *f = fopen(path, "w");
    char text[LT_NUMBER_TEXT];

    fputs("[", f);
    for (int i = 0; i < n * points * 3; i++) {
        if (i % 3 == 0)
            fputs(i % (points * 3) ? "," : i ? ",\n [" : "[", f);
        fprintf(f, "%s%s%s", i % 3 ? ", " : "[", lt_print_float(x[i], text), i % 3 == 2 ? "]" : "");
        if (i % (points * 3) == points * 3 - 1)
            fputs("]", f);
    }
    fputs("]", f);
    fclose(f);
}

static void write_pred(const char *path, int n)
{
    ho3d_submission *s;

    check_ok(ho3d_submission_open(path, n, &s));
    for (int i = 0; i < n; i++)
        check_ok(ho3d_submission_add(s, p_xyz[i][0], p_verts[i][0]));
    check_ok(ho3d_submission_close(s));
}

/* Points before HO3D's camera, and predictions a few millimetres off. */
static void fill(lt_rng *rng, int n, float *truth, float *predicted)
{
    for (int i = 0; i < n; i++) {
        truth[i] = (float)lt_rng_range(rng, -0.5, -0.1);
        predicted[i] = truth[i] + (float)lt_rng_range(rng, -0.01, 0.01);
    }
}

static void setup(void)
{
    lt_rng rng = lt_rng_make(7, 7);

    p_xyz = calloc(N, sizeof(*p_xyz));
    g_xyz = calloc(N, sizeof(*g_xyz));
    p_verts = calloc(N, sizeof(*p_verts));
    g_verts = calloc(N, sizeof(*g_verts));
    fill(&rng, N * J * 3, &g_xyz[0][0][0], &p_xyz[0][0][0]);
    fill(&rng, N * V * 3, &g_verts[0][0][0], &p_verts[0][0][0]);
    write_truth(in_folder("xyz.json"), g_xyz[0][0], N, J);
    write_truth(in_folder("verts.json"), g_verts[0][0], N, V);
}

static void teardown(void)
{
    free(p_xyz);
    free(g_xyz);
    free(p_verts);
    free(g_verts);
}

static void expect_scores(const char *path)
{
    ho3d_scorer *s = ho3d_scorer_new();
    double want[HO3D_SCORES], got[HO3D_SCORES];
    int64_t n;

    check_ok(ho3d_scorer_add(s, N, p_xyz[0][0], p_verts[0][0], g_xyz[0][0], g_verts[0][0], NULL));
    ho3d_scorer_scores(s, want);
    ho3d_scorer_free(s);
    check_ok(ho3d_score_files(path, in_folder("xyz.json"), in_folder("verts.json"), got, &n, NULL, NULL));
    ck_assert_int_eq(n, N);
    for (int i = 0; i < HO3D_SCORES; i++)               /* seven digits of half a metre */
        ck_assert_double_eq_tol(got[i], want[i], 2e-5);
}

START_TEST(scores_of_json_and_zip)
{
    write_pred(in_folder("pred.json"), N);
    expect_scores(in_folder("pred.json"));
    write_pred(in_folder("pred.zip"), N);
    expect_scores(in_folder("pred.zip"));
}
END_TEST

static lt_status score(const char *pred)
{
    double scores[HO3D_SCORES];
    int64_t n = -1;
    const lt_status st = ho3d_score_files(pred, in_folder("xyz.json"), in_folder("verts.json"), scores, &n, NULL, NULL);

    ck_assert(!st || n == -1);
    return st;
}

START_TEST(other_lengths)
{
    write_pred(in_folder("pred.json"), N - 1);
    check_error(score(in_folder("pred.json")), LT_EFORMAT, "pred.json has 69 frames, ");
    write_truth(in_folder("xyz.json"), g_xyz[0][0], N - 1, J);
    check_error(score(in_folder("pred.json")), LT_EFORMAT, "pred.json has 69 frames, ");
    write_truth(in_folder("verts.json"), g_verts[0][0], N - 1, V);
    check_ok(score(in_folder("pred.json")));
    write_truth(in_folder("verts.json"), g_verts[0][0], N - 2, V);
    check_error(score(in_folder("pred.json")), LT_EFORMAT, "verts.json has 68 frames, ");
}
END_TEST

static void put_text(const char *name, const char *text)
{
    put_file(in_folder(name), text, strlen(text));
}

/* Frames of two points, to have short files. */
static const int two[2] = { 2, 1 };

static lt_status read_all(const char *path, int lists, int64_t frames[2])
{
    ho3d_points *p;
    float x[6];
    bool more;
    lt_status st = ho3d_points_open(path, two, lists, &p);

    if (st)
        return st;
    for (int i = 0; !st && i < lists; i++)
        for (more = true, frames[i] = 0; !st && more; frames[i] += !st && more)
            st = ho3d_points_next(p, x, &more);
    ho3d_points_close(p);
    return st;
}

static const struct { const char *text; int lists; const char *reason; } broken[] = {
    { "", 1, "" }, { "5", 1, "found a number" }, { "[5]", 1, "found a number" }, { "{}", 1, "found an object" },
    { "\"x\"", 1, "found a text" }, { "[[[1,2,3]]]", 1, "expected 2 points" },
    { "[[[1,2,3],[1,2,3],[1,2,3]]]", 1, "found one more point" }, { "[[[1,2],[1,2,3]]]", 1, "expected three numbers" },
    { "[[[1,2,3,4],[1,2,3]]]", 1, "found a number" }, { "[[[1,2,[3]],[1,2,3]]]", 1, "found a list" },
    { "[[[1,2,true],[1,2,3]]]", 1, "found true" }, { "[[[1,2,1e5],[1,2,3]]]", 1, "found 1e5" },
    { "[[[1,2,3],[1,2,3]]", 1, "" }, { "[[[1,2,3],[1,2,3]]] x", 1, "" }, { "[[[1,2,3],[1,2,3]]][]", 1, "" },
    { "[[],[],[]]", 2, "found one more list" }, { "[[]]", 2, "a list of joints and one of vertices" },
    { "[[[[1,2,3],[1,2,3]]],[[[1,2,3],[1,2,3]]]]", 2, "found one more point" }, { "[[],3]", 2, "found a number" },
};

START_TEST(files_are_broken)
{
    int64_t n[2];

    put_text("b.json", broken[_i].text);
    ck_assert_int_eq(read_all(in_folder("b.json"), broken[_i].lists, n), LT_EFORMAT);
    ck_assert_msg(strstr(lt_last_error(), broken[_i].reason), "\"%s\" lacks \"%s\"", lt_last_error(), broken[_i].reason);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "b.json"));
}
END_TEST

/* A word over many blocks is refused before the parser has all of it, wherever it begins; white space may be as long as
 * it likes. */
START_TEST(long_words)
{
    static const char *const heads[] = { "[[[", "[[[\"", "[[[1,2,3],[0.", "x" };
    enum { LONG = 1 << 18 };
    char *text = malloc(LONG), reason[64];
    int64_t n[2];

    for (int i = 0; i < (int)LT_COUNT(heads); i++) {
        memset(text, '0', LONG);
        memcpy(text, heads[i], strlen(heads[i]));
        put_file(in_folder("w.json"), text, LONG);
        snprintf(reason, sizeof(reason), "w.json: frame 0, point %d: found a very long word", i == 2);
        check_error(read_all(in_folder("w.json"), 1, n), LT_EFORMAT, reason);
    }
    memset(text, ' ', LONG);
    memcpy(text, "[", 1);
    memcpy(text + LONG - 1, "]", 1);
    put_file(in_folder("w.json"), text, LONG);
    check_ok(read_all(in_folder("w.json"), 1, n));
    free(text);
}
END_TEST

START_TEST(lists_of_frames)
{
    int64_t n[2];

    put_text("a.json", "[[],[]]");
    check_ok(read_all(in_folder("a.json"), 2, n));
    ck_assert(n[0] == 0 && n[1] == 0);
    put_text("a.json", " [ [[[1,2,3],[4,5,6.5e0]], [[1,2,3],[4,5,6]]] ,\n[[[7,8,9]]]]\n");
    check_ok(read_all(in_folder("a.json"), 2, n));
    ck_assert(n[0] == 2 && n[1] == 1);
    ck_assert_int_eq(read_all(in_folder("none.json"), 2, n), LT_EIO);
}
END_TEST

/* Cut anywhere, a prediction is refused; with bits flipped it does no harm. */
START_TEST(damage)
{
    static const char whole[] = "[[[[1,2,3],[4,5,6]],[[1,2,3],[4,5,6]]],[[[7,8,9]],[[7,8,9]]]]";
    lt_rng rng = lt_rng_make(1, 1);
    int64_t n[2];

    for (size_t cut = 0; cut + 1 < sizeof(whole); cut++) {
        put_file(in_folder("c.json"), whole, cut);
        ck_assert_int_ne(read_all(in_folder("c.json"), 2, n), LT_OK);
    }
    for (int i = 0; i < 3000; i++) {
        char copy[sizeof(whole)];
        memcpy(copy, whole, sizeof(whole));
        copy[lt_rng_below(&rng, sizeof(whole) - 1)] ^= (char)(1 << lt_rng_below(&rng, 8));
        put_file(in_folder("c.json"), copy, sizeof(whole) - 1);
        read_all(in_folder("c.json"), 2, n);
    }
}
END_TEST

START_TEST(archives)
{
    char *bytes = malloc(1 << 22);
    FILE *f;
    size_t size;

    write_pred(in_folder("pred.zip"), N);
    f = fopen(in_folder("pred.zip"), "rb");
    size = fread(bytes, 1, 1 << 22, f);
    fclose(f);
    put_file(in_folder("cut.zip"), bytes, size / 2);
    check_error(score(in_folder("cut.zip")), LT_EFORMAT, "cut.zip");
    bytes[size / 2] ^= 0x55;
    put_file(in_folder("bad.zip"), bytes, size);
    ck_assert_int_ne(score(in_folder("bad.zip")), LT_OK);
    free(bytes);
}
END_TEST

/* Numbers are the same as by strtod, bit by bit, and end where it ends. */
START_TEST(decimals)
{
    static const char *const odd[] = {
        "0", "-0", "1.", "1.5.2", "-.5", "+1", "00012.50", "123456789012345", "1234567890123456", "0.123456789012345",
        "0.1234567890123456", "1e5", "1.5e-3x", "0x10", "1e", "-", ".", "", "12,5", "9007199254740993", " 1", "1 ",
    };
    lt_rng rng = lt_rng_make(3, 4);
    char text[64];

    for (int i = 0; i < 200000 + (int)LT_COUNT(odd); i++) {
        const char *end;
        char *want_end;
        double x, want;
        if (i < (int)LT_COUNT(odd))
            snprintf(text, sizeof(text), "%s", odd[i]);
        else
            snprintf(text, sizeof(text), i % 2 ? "%.*g" : "%.*f", (int)lt_rng_below(&rng, 17),
                     lt_rng_range(&rng, -1, 1) * pow(10, lt_rng_range(&rng, -5, 5)));
        x = lt_strtod(text, &end);
        want = strtod(text, &want_end);
        ck_assert_msg(memcmp(&x, &want, sizeof(x)) == 0, "%s: %a, want %a", text, x, want);
        ck_assert_ptr_eq(end, want_end);
    }
}
END_TEST

static bool stop_at_once(void *ctx, int64_t done, int64_t total)
{
    *(int64_t *)ctx = done;
    ck_assert_int_eq(total, N);
    return false;
}

START_TEST(stopping)
{
    double scores[HO3D_SCORES];
    int64_t n, done = 0;

    write_pred(in_folder("pred.json"), N);
    ck_assert_int_eq(ho3d_score_files(in_folder("pred.json"), in_folder("xyz.json"), in_folder("verts.json"), scores, &n,
                                      stop_at_once, &done), LT_ESTOPPED);
    ck_assert_int_eq(done, 64);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_checked_fixture(tc, setup, teardown);
    tcase_add_test(tc, scores_of_json_and_zip);
    tcase_add_test(tc, other_lengths);
    tcase_add_loop_test(tc, files_are_broken, 0, LT_COUNT(broken));
    tcase_add_test(tc, lists_of_frames);
    tcase_add_test(tc, long_words);
    tcase_add_test(tc, damage);
    tcase_add_test(tc, archives);
    tcase_add_test(tc, decimals);
    tcase_add_test(tc, stopping);
}

int main(void)
{
    return run_suite("ho3d_files", add_tests);
}
