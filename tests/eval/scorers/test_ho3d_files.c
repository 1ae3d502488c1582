/* SPDX-License-Identifier: Apache-2.0 */
/* Prediction files against ground truth, both as streams: the scores of the samples themselves, and every way such
 * files are broken. */
#include "data/ho3d/points.h"
#include "eval/metrics/metrics.h"
#include "eval/scorers/ho3d/files.h"
#include "eval/scorers/ho3d/submission.h"

#include "libtensor/base/arena.h"
#include "libtensor/base/rng.h"
#include "libtensor/geometry/hand/model.h"
#include "libtensor/io/text/number.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>
#include <zip.h>

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
    check_ok(ho3d_score_files(path, in_folder("xyz.json"), in_folder("verts.json"), got, &n, NULL, NULL, NULL));
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
    const lt_status st = ho3d_score_files(pred, in_folder("xyz.json"), in_folder("verts.json"), scores, &n, NULL, NULL,
                                          NULL);

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
    { "[[[1,2,3],[1,NaN,3]]]", 1, "frame 0, point 1, y: found NaN, expected a coordinate" },
    { "[[[1,2,3],[1,2,3]],[[Infinity,2,3],[1,2,3]]]", 1, "frame 1, point 0, x: found Infinity, expected" },
    { "[[[1,2,-Infinity],[1,2,3]]]", 1, "frame 0, point 0, z: found -Infinity, expected" },
    { "[[[1,2,3],[1,2,1e154]]]", 1, "frame 0, point 1, z: found 1e154, expected" },
    { "[[[1,nan,3],[1,2,3]]]", 1, "found nan, expected numbers" },
    { "[[[1,0x1,3],[1,2,3]]]", 1, "found 0x1, expected" },
    { "[[[1,2,3],[01,2,3]]]", 1, "frame 0, point 1: parse error" }, { "[[[+1,2,3],[1,2,3]]]", 1, "found +1" },
    { "[[[.5,2,3],[1,2,3]]]", 1, "found .5" }, { "[[[1.,2,3],[1,2,3]]]", 1, "found 1., expected" },
    { "[[[1e,2,3],[1,2,3]]]", 1, "found 1e, expected" }, { "[[[1 2,3],[1,2,3]]]", 1, "parse error" },
    { "[[[1,,3],[1,2,3]]]", 1, "parse error" }, { "[[[1,2,3],[1,2,3],]]", 1, "point 2: parse error" },
    { "[[[1,2,3][1,2,3]]]", 1, "point 1: parse error" }, { "]", 1, "parse error" },
    { ",[[[1,2,3],[1,2,3]]]", 1, "parse error" }, { "[[[1,2,3],[1,2,3]]],", 1, "parse error" },
    { "[[[1,2,3],[1,2", 1, "frame 0: ends early" }, { "[[[1,2,3],[1,2,-", 1, "found -, expected numbers" },
    { "[[[1,2,3],[1,2,\"NaN\"]]]", 1, "point 1: found a text, expected numbers" },
    { "[[[1,2,3],[1,2,3]]]\"a\"", 1, "found a text" },
    { "PK", 1, "found PK" }, { "<!doctype html>", 1, "an HTML page" }, { "\x1f\x8b\x08 x", 1, "a gzip file" },
};

START_TEST(files_are_broken)
{
    int64_t n[2];

    put_text("b.json", broken[_i].text);
    ck_assert_int_eq(read_all(in_folder("b.json"), broken[_i].lists, n), LT_EFORMAT);
    ck_assert_msg(strstr(lt_last_error(), broken[_i].reason), "\"%s\" lacks \"%s\"", lt_last_error(),
                  broken[_i].reason);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "b.json"));
}
END_TEST

/* A byte order mark, as Windows writes one; the longest numbers; white space of all kinds. */
START_TEST(odd_but_right)
{
    int64_t n[2];

    put_text("o.json", "\xef\xbb\xbf [\r\n[[-0.0,\t1.5E-3,2e+2],"
             "[0.00000000000000000000000000000000000012345678901234567,1,"
             "9999]]\n]\n");
    check_ok(read_all(in_folder("o.json"), 1, n));
    ck_assert_int_eq(n[0], 1);
}
END_TEST

/* What else people hand in for two lists, of frames of two points and of one: nothing, or other meshes. */
static const struct { const char *text; int frames, others, points; const char *reason; } handed_in[] = {
    { "[[[[1,2,3],[4,5,6]],[[1,2,3],[4,5,6]]], [[[7,8,9]],[[7,8,9]]]]", 2, 2, 1, NULL },
    { "[[[[1,2,3],[4,5,6]],[[1,2,3],[4,5,6]]]]", 2, 0, 1, NULL },
    { "[[[[1,2,3],[4,5,6]]], []]", 1, 0, 1, NULL },
    { "[[[[1,2,3],[4,5,6]]], null]", 1, 0, 1, NULL },
    { "[[[[1,2,3],[4,5,6]],[[1,2,3],[4,5,6]]], [[],[]]]", 2, 2, 0, NULL },
    { "[[[1,2,3],[4,5,6]],[[1,2,3],[4,5,6]]]", 2, 0, 1, NULL },
    { "[[[[1,2,3],[4,5,6]]], [[[7,8,9],[7,8,9],[7,8,9]]]]", 1, 1, 3, NULL },
    { "[[[[1,2,3],[4,5,6]],[[1,2,3],[4,5,6]]], [[[7,8,9],[7,8,9]],[[7,8,9]]]]", 2, 1, 2, "expected 2 points" },
    { "[[[[1,2,3]]], []]", 0, 0, 1, "expected 2 points" },
    { "[[[1,2,3],[4,5,6]],[[1,2,3]]]", 1, 0, 1, "expected 2 points" },
    { "[null, []]", 0, 0, 1, "found null" }, { "[[], [], []]", 0, 0, 1, "H2O-3D's predictions have more" },
    { "[[[[1,2,3],[4,5,6]]], [null]]", 1, 0, 1, "found null" }, { "[]", 0, 0, 1, "a list of joints" },
};

START_TEST(joints_alone_and_other_meshes)
{
    static float x[3 * HO3D_MOST_POINTS];
    const int want[2] = { handed_in[_i].frames, handed_in[_i].others };
    ho3d_points *p;
    lt_status st = LT_OK;

    put_text("h.json", handed_in[_i].text);
    check_ok(ho3d_points_open(in_folder("h.json"), two, 2, &p));
    ho3d_points_any(p);
    for (int i = 0; !st && i < 2; i++) {
        int n = 0;
        for (bool more = true; !st && more; n += !st && more)
            st = ho3d_points_next(p, x, &more);
        ck_assert(st || n == want[i]);
    }
    ck_assert_int_eq(st, handed_in[_i].reason ? LT_EFORMAT : LT_OK);
    if (st)
        ck_assert_msg(strstr(lt_last_error(), handed_in[_i].reason), "\"%s\" lacks \"%s\"", lt_last_error(),
                      handed_in[_i].reason);
    else
        ck_assert_int_eq(ho3d_points_of(p, 1), handed_in[_i].points);
    ho3d_points_close(p);
}
END_TEST

/* A word or a text over many blocks is refused before the parser has all of it, wherever it begins; white space may be
 * as long as it likes. */
START_TEST(long_words)
{
    static const char *const heads[] = { "[[[", "[[[1,2,3],[0.", "x", "[[[\"," };
    enum { LONG = 1 << 18 };
    char *text = malloc(LONG), reason[64];
    int64_t n[2];

    for (int i = 0; i < (int)LT_COUNT(heads); i++) {
        memset(text, i < 3 ? '0' : ',', LONG);
        memcpy(text, heads[i], strlen(heads[i]));
        put_file(in_folder("w.json"), text, LONG);
        snprintf(reason, sizeof(reason), "w.json: frame 0, point %d: found a %s", i == 1,
                 i < 3 ? "very long word" : "text");
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

/* The parser has memory of its own: what may be missing is ours. */
START_TEST(without_memory)
{
    lt_status st = LT_ENOMEM;
    int64_t n[2];
    long refused = 0;

    put_text("m.json", "[[[[1,2,3],[4,5,6]]],[[[7,8,9]]]]");
    for (; st == LT_ENOMEM && refused < 10; refused += st == LT_ENOMEM) {
        lt_alloc_fail_at(refused + 1);
        st = read_all(in_folder("m.json"), 2, n);
        lt_alloc_fail_at(0);
    }
    check_ok(st);
    ck_assert_int_eq(refused, 3);
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
    check_error(score(in_folder("cut.zip")), LT_EFORMAT, "cut.zip: a zip archive that is cut short");
    bytes[size / 2] ^= 0x55;
    put_file(in_folder("bad.zip"), bytes, size);
    ck_assert_int_ne(score(in_folder("bad.zip")), LT_OK);
    free(bytes);
}
END_TEST

/* ---- what archives hold ---- */

static const struct { const char *names[4]; const char *note, *reason; } zips[] = {
    { { "pred.json" }, NULL, NULL }, { { "results/pred.json" }, "found results/pred.json in it", NULL },
    { { "a/b/pred.json", "a/readme.txt" }, "found a/b/pred.json in it", NULL },
    { { "results/pred.json", "__MACOSX/results/._pred.json" }, "found results/pred.json in it", NULL },
    { { "old/pred.json", "pred.json" }, NULL, NULL },
    { { "my_results.json", "log.txt" }, "found my_results.json in it", NULL },
    { { "a/pred.json", "b/pred.json" }, NULL,
      "found a/pred.json and b/pred.json in it, expected pred.json at the top" },
    { { "a.json", "b.json" }, NULL, "found a.json and b.json in it" },
    { { "pred.txt" }, NULL, "no JSON file in this archive, expected pred.json in it" },
};

static void put_archive(const char *path, const char *const *names)
{
    static const char text[] = "[[[[1,2,3],[4,5,6]]],[[[7,8,9]]]]";
    int why;
    zip_t *z = zip_open(path, ZIP_CREATE | ZIP_TRUNCATE, &why);

    ck_assert_ptr_nonnull(z);
    for (int i = 0; i < 4 && names[i]; i++)
        ck_assert_int_ge(zip_file_add(z, names[i], zip_source_buffer(z, text, sizeof(text) - 1, 0), 0), 0);
    ck_assert_int_eq(zip_close(z), 0);
}

START_TEST(entries_of_archives)
{
    const char *path = in_folder("z.zip");
    ho3d_points *p;
    int64_t n[2];

    put_archive(path, zips[_i].names);
    if (zips[_i].reason) {
        check_error(ho3d_points_open(path, two, 2, &p), LT_EFORMAT, zips[_i].reason);
        return;
    }
    check_ok(read_all(path, 2, n));
    check_ok(ho3d_points_open(path, two, 2, &p));
    ck_assert_int_eq(ho3d_points_note(p) != NULL, zips[_i].note != NULL);
    if (zips[_i].note)
        ck_assert_ptr_nonnull(strstr(ho3d_points_note(p), zips[_i].note));
    ho3d_points_close(p);
}
END_TEST

/* ---- scores, and what is said beside them ---- */

static eval_notes notes;
static double got[HO3D_SCORES];

static lt_status score_with_notes(const char *pred)
{
    int64_t n;

    notes.n = 0;
    return ho3d_score_files(pred, in_folder("xyz.json"), in_folder("verts.json"), got, &n, &notes, NULL, NULL);
}

static void put_pred(const char *path, const float *verts, int points)
{
    FILE *f;

    write_truth(in_folder("p1.json"), p_xyz[0][0], N, J);
    write_truth(in_folder("p2.json"), verts, N, points);
    f = fopen(path, "w");
    for (int k = 0; k < 2; k++) {
        FILE *part = fopen(in_folder(k ? "p2.json" : "p1.json"), "r");
        fputc("[,"[k], f);
        for (int c = fgetc(part); c != EOF; c = fgetc(part))
            fputc(c, f);
        fclose(part);
    }
    fputc(']', f);
    fclose(f);
}

/* The joints' scores are those of a whole file. */
static void expect_joint_scores(const double want[HO3D_SCORES])
{
    for (int i = HO3D_XYZ_MEAN; i <= HO3D_XYZ_ST_AUC; i++)
        ck_assert_double_eq_tol(got[i], want[i], 2e-5);
    ck_assert(got[HO3D_MESH_MEAN] == -100 && got[HO3D_MESH_PA_MEAN] == -100);
    ck_assert(got[HO3D_MESH_AUC] == -1 && got[HO3D_MESH_PA_AUC] == -1);
}

START_TEST(scores_of_joints_alone)
{
    double want[HO3D_SCORES];

    write_pred(in_folder("pred.json"), N);
    check_ok(score_with_notes(in_folder("pred.json")));
    ck_assert_int_eq(notes.n, 0);
    memcpy(want, got, sizeof(want));
    write_truth(in_folder("joints.json"), p_xyz[0][0], N, J);
    check_ok(score_with_notes(in_folder("joints.json")));
    expect_joint_scores(want);
    for (int i = HO3D_F_5; i < HO3D_SCORES; i++)
        ck_assert_double_eq(got[i], 0);
    ck_assert_int_eq(notes.n, 1);
    ck_assert_str_eq(notes.note[0].code, "joints-only");
    write_truth(in_folder("verts.json"), g_verts[0][0], N - 1, V);
    check_error(score_with_notes(in_folder("joints.json")), LT_EFORMAT, "verts.json has 69 frames, ");
}
END_TEST

/* Every other vertex. With true joints the similarity is none, and the script shrinks the mesh about its middle by the
 * joints' size, which is what aligned F is then of. */
START_TEST(scores_of_another_mesh)
{
    enum { HALF = V / 2 };
    float (*half)[HALF][3] = calloc(N, sizeof(*half));
    double f5 = 0, f_al15 = 0, want[HO3D_SCORES];

    memcpy(p_xyz, g_xyz, N * sizeof(*p_xyz));
    put_pred(in_folder("pred.json"), p_verts[0][0], V);
    check_ok(score_with_notes(in_folder("pred.json")));
    memcpy(want, got, sizeof(want));
    for (int i = 0; i < N; i++) {
        static double p[3 * HALF], g[3 * V], d_p[HALF], d_g[V];
        double middle[3] = { 0 }, m[3] = { 0 }, size = 0;
        for (int k = 0; k < HALF * 3; k++) {
            half[i][k / 3][k % 3] = p_verts[i][2 * (k / 3)][k % 3];
            p[k] = half[i][k / 3][k % 3];
            middle[k % 3] += p[k] / HALF;
        }
        for (int k = 0; k < V * 3; k++)
            g[k] = g_verts[i][k / 3][k % 3];
        check_ok(eval_nearest(HALF, p, V, g, d_p, d_g));
        f5 += eval_f_score(HALF, d_p, V, d_g, .005).f / N;
        for (int k = 0; k < J * 3; k++)
            m[k % 3] += g_xyz[i][k / 3][k % 3] / (double)J;
        for (int k = 0; k < J * 3; k++)
            size += pow(g_xyz[i][k / 3][k % 3] - m[k % 3], 2);
        for (int k = 0; k < HALF * 3; k++)
            p[k] = middle[k % 3] + sqrt(size) * (p[k] - middle[k % 3]);
        check_ok(eval_nearest(HALF, p, V, g, d_p, d_g));
        f_al15 += eval_f_score(HALF, d_p, V, d_g, .015).f / N;
    }
    put_pred(in_folder("half.json"), half[0][0], HALF);
    check_ok(score_with_notes(in_folder("half.json")));
    expect_joint_scores(want);
    ck_assert_double_eq_tol(got[HO3D_F_5], f5, 1e-6);
    ck_assert_double_eq_tol(got[HO3D_F_AL_15], f_al15, 1e-6);
    ck_assert_int_eq(notes.n, 1);
    ck_assert_str_eq(notes.note[0].code, "other-mesh");
    free(half);
}
END_TEST

static void in_mm(float *x, int n)
{
    for (int i = 0; i < n; i++)
        x[i] *= 1000;
}

static void in_opencv(float *x, int n)
{
    for (int i = 0; i < n; i++)
        x[i] *= i % 3 ? -1 : 1;
}

static void from_the_wrist(float *x, int n)
{
    for (int i = 0; i < n; i += 3 * J)
        for (int k = 3 * J - 1; k >= 0; k--)
            x[i + k] -= x[i + k % 3];
}

static void in_simple_order(float *x, int n)
{
    for (int i = 0; i < n; i += 3 * J) {
        float old[J][3];
        memcpy(old, x + i, sizeof(old));
        for (int j = 0; j < J; j++)
            memcpy(x + i + 3 * j, old[lt_mano_to_simple[j]], sizeof(old[0]));
    }
}

/* mesh: to the vertices as well, where it can be done to them. */
static const struct { void (*make)(float *x, int n); bool mesh; const char *code, *words; } slips[] = {
    { in_mm, true, "unit", "it looks as if the joints are in millimetres, not metres" },
    { in_opencv, true, "axes", "it looks as if the joints have OpenCV's axes (y down, z forward), not OpenGL's" },
    { in_simple_order, false, "order",
      "it looks as if the joints are ordered from thumb to little finger, not as MANO" },
    { from_the_wrist, false, "place", "it looks as if the joints are counted from the wrist" },
};

START_TEST(slips_are_named)
{
    char want[128];

    slips[_i].make(p_xyz[0][0], N * J * 3);
    if (slips[_i].mesh)
        slips[_i].make(p_verts[0][0], N * V * 3);
    put_pred(in_folder("slip.json"), p_verts[0][0], V);
    check_ok(score_with_notes(in_folder("slip.json")));
    ck_assert_int_eq(notes.n, slips[_i].mesh ? 2 : 1);
    ck_assert_str_eq(notes.note[0].code, slips[_i].code);
    ck_assert_msg(strstr(notes.note[0].text, slips[_i].words), "%s", notes.note[0].text);
    snprintf(want, sizeof(want), "the vertices %s", strstr(slips[_i].words, "joints ") + 7);
    if (slips[_i].mesh)
        ck_assert_msg(strstr(notes.note[1].text, want), "%s", notes.note[1].text);
}
END_TEST

/* By its place, in joints and in vertices. */
static void not_a_number_at(const char *path, int points, int at)
{
    FILE *f = fopen(path, "w");

    fputs("[[", f);
    for (int i = 0; i < points; i++)
        fprintf(f, "%s[0, %s, -0.5]", i ? ", " : "", i == at ? "NaN" : "0");
    fputs("]]", f);
    fclose(f);
}

START_TEST(not_finite)
{
    static const int joints = J, vertices = V;
    float x[3 * V];
    ho3d_points *p;
    bool more;

    not_a_number_at(in_folder("nan.json"), J, 4);
    check_error(score_with_notes(in_folder("nan.json")), LT_EFORMAT, "frame 0, joint 4, y: found NaN");
    check_ok(ho3d_points_open(in_folder("nan.json"), &joints, 1, &p));
    check_error(ho3d_points_next(p, x, &more), LT_EFORMAT, "frame 0, joint 4, y: found NaN, expected a coordinate in");
    ho3d_points_close(p);
    not_a_number_at(in_folder("nan.json"), V, 777);
    check_ok(ho3d_points_open(in_folder("nan.json"), &vertices, 1, &p));
    check_error(ho3d_points_next(p, x, &more), LT_EFORMAT, "frame 0, vertex 777, y: found NaN");
    ho3d_points_close(p);
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
    ck_assert_int_eq(ho3d_score_files(in_folder("pred.json"), in_folder("xyz.json"), in_folder("verts.json"), scores,
                                      &n, NULL, stop_at_once, &done), LT_ESTOPPED);
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
    tcase_add_test(tc, odd_but_right);
    tcase_add_loop_test(tc, joints_alone_and_other_meshes, 0, LT_COUNT(handed_in));
    tcase_add_test(tc, long_words);
    tcase_add_test(tc, damage);
    tcase_add_test(tc, without_memory);
    tcase_add_test(tc, archives);
    tcase_add_loop_test(tc, entries_of_archives, 0, LT_COUNT(zips));
    tcase_add_test(tc, scores_of_joints_alone);
    tcase_add_test(tc, scores_of_another_mesh);
    tcase_add_loop_test(tc, slips_are_named, 0, LT_COUNT(slips));
    tcase_add_test(tc, not_finite);
    tcase_add_test(tc, decimals);
    tcase_add_test(tc, stopping);
}

int main(void)
{
    return run_suite("ho3d_files", add_tests);
}
