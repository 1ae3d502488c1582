/* SPDX-License-Identifier: Apache-2.0 */
/* The page of a run: what is on it, what is not there yet, and that nothing from a file is markup. */
#include "eval/report/report.h"
#include "libtensor/base/arena.h"
#include "libtensor/io/file.h"
#include "tests/suite.h"

#define EVIL "<script>alert(1)</script>\\u0007"

static const char config[] = "{\"model\": {\"name\": \"hocat\", \"variant\": \"" EVIL "\"}, \"seed\": 1}";
static const char env[] = "{\"data\": \"HO3D v3 & more\", \"synthetic_data\": true, \"cpu\": \"a 'cpu'\"}";
static const char steps[] =
    "{\"step\":1,\"epoch\":0,\"loss\":100,\"parts\":{\"heatmap\":7},\"lr\":0.001,\"grad_norm\":null,\"img_per_s\":4}\n"
    "{\"step\":2,\"epoch\":0,\"loss\":1,\"parts\":{\"heatmap\":5},\"lr\":0.001,\"grad_norm\":3,\"img_per_s\":5,"
    "\"skipped\":\"conv2d \\\"" EVIL "\\\"\"}\n"
    "{\"step\":2,\"epoch\":0,\"samples\":4,\"pa_mpjpe_mm\":12.5,\"mpjpe_mm\":88,\"validation_loss\":9,\"parts\":{}}\n"
    "{\"step\":3,\"epo";
static const char table[] =
    "### HOCAT, Table 1\n\n| method | PAMPJPE (mm) |\n| ------ | -----------: |\n| HOCAT | 9.1 |\n"
    "| <b>ours</b> | 12.1 |\n\nProtocol: SYNTHETIC data; split test\n";
static const char samples[] =
    "sample,pa_mpjpe_mm\nA/0001,5.5\nB/<i>0002</i>,25\nC/0003,nan\nD/0004,7\n";

static const char *run = "run";

static void put(const char *name, const char *text)
{
    char path[256];

    snprintf(path, sizeof(path), "%s/%s", in_folder(run), name);
    put_file(path, text, strlen(text));
}

static void make_run(bool scored)
{
    char eval[256];

    check_ok(lt_make_dirs(in_folder(run)));
    put("config.json", config);
    put("env.json", env);
    put("log.jsonl", steps);
    if (!scored)
        return;
    snprintf(eval, sizeof(eval), "%s/eval", in_folder(run));
    check_ok(lt_make_dirs(eval));
    put("eval/table.md", table);
    put("eval/per-sample.csv", samples);
    put("eval/per-joint.csv", "joint,pa_mpjpe_mm,mpjpe_mm\nwrist,4.5,0\nindex tip,9.5,33\n");
    put("eval/pictures.png", "Man");                    /* "TWFu" in base 64 */
}

static lt_arena *arena;

static const char *page(void)
{
    uint8_t *bytes;
    size_t n;

    arena = lt_arena_new();
    check_ok(report_write(in_folder(run), in_folder("report.html"), NULL));
    check_ok(lt_read_file(arena, in_folder("report.html"), LT_FILE_MAX, &bytes, &n));
    return (const char *)bytes;
}

static void has(const char *text, const char *part)
{
    ck_assert_msg(strstr(text, part), "the page lacks %s", part);
}

static void lacks(const char *text, const char *part)
{
    ck_assert_msg(!strstr(text, part), "the page has %s", part);
}

static void has_in_order(const char *text, const char *first, const char *second)
{
    has(text, first);
    has(text, second);
    ck_assert_msg(strstr(text, first) < strstr(text, second), "the page has %s before %s", second, first);
}

START_TEST(a_scored_run)
{
    const char *text;

    make_run(true);
    text = page();
    has(text, "<!DOCTYPE html>");
    has(text, "<h3>HOCAT, Table 1</h3>");
    has(text, "<th>method</th><th class=n>PAMPJPE (mm)</th>");
    has(text, "<td>HOCAT</td><td class=n>9.1</td>");
    has(text, "<p>Protocol: SYNTHETIC data; split test</p>");
    has(text, "synthetic data</span>");
    has(text, ">loss</text>");
    has(text, ">validation pa_mpjpe_mm</text>");
    has(text, "<title>2: 12.5</title>");
    has(text, ">heatmap</text>");
    has(text, "The 3 worst of 3");
    has_in_order(text, "<td>index tip</td><td>9.5</td>", "<td>wrist</td>");
    has_in_order(text, "0002", "<td>D/0004</td>");                              /* the worst first */
    has(text, "src=\"data:image/png;base64,TWFu\"");
    has(text, "2 steps in the log");
    has(text, "&quot;seed&quot;:\t1");
    lacks(text, "has gone on");
    lt_arena_free(arena);
}
END_TEST

START_TEST(scores_of_before_the_run_went_on)
{
    make_run(true);
    put("eval/scores.json", "{\"step\": 1}");
    has(page(), "<p>Scored at step 1; the run has gone on to step 2.</p>");
    lt_arena_free(arena);
}
END_TEST

START_TEST(nothing_from_a_file_is_markup)
{
    const char *text;

    make_run(true);
    text = page();
    lacks(text, "<script");
    lacks(text, "<b>");
    lacks(text, "<i>");
    lacks(text, "\a");
    has(text, "&lt;script&gt;alert(1)&lt;/script&gt;\xef\xbf\xbd");
    has(text, "&lt;b&gt;ours&lt;/b&gt;");
    has(text, "B/&lt;i&gt;0002&lt;/i&gt;");
    has(text, "HO3D v3 &amp; more");
    has(text, "a &#39;cpu&#39;");
    lacks(text, "http://");
    lacks(text, "https://");
    lacks(text, "src=\"/");
    has(text, "default-src 'none'");
    lt_arena_free(arena);
}
END_TEST

START_TEST(a_run_that_is_not_scored)
{
    const char *text;

    run = "fresh";
    make_run(false);
    text = page();
    has(text, "Not scored yet");
    lacks(text, "<h2>Samples</h2>");
    lacks(text, "<h2>Pictures</h2>");
    put("log.jsonl", "");
    lt_arena_free(arena);
    text = page();
    has(text, "No steps yet.");
    lt_arena_free(arena);
}
END_TEST

START_TEST(no_run)
{
    run = "damaged";
    check_error(report_write(in_folder("none"), in_folder("no.html"), NULL), LT_EIO, "none/config.json");
    make_run(false);
    put("log.jsonl", "{\"step\":1}\nnonsense\n{\"step\":2}\n");
    check_error(report_write(in_folder(run), in_folder("no.html"), NULL), LT_EFORMAT, "log.jsonl");
    ck_assert(!exists(in_folder("no.html")));
}
END_TEST

/* Odd tables and curves: nothing reads past a line */
START_TEST(odd_files)
{
    static const char *const tables[] = { "|", "|\n|", "|a|\n|-|\n|b|", "| a\n| -- \n", "#", "|a|\n|--", "\n\n",
                                          "|--:|\n|" };
    static const char *const lists[] = { "", "sample", "sample\n", "a,b\nx\n,\ny,", "a,b\nx,1e999\nz,1\n" };
    arena = NULL;
    make_run(true);
    for (size_t i = 0; i < LT_COUNT(tables); i++) {
        put("eval/table.md", tables[i]);
        check_ok(report_write(in_folder(run), in_folder("odd.html"), NULL));
    }
    for (size_t i = 0; i < LT_COUNT(lists); i++) {
        put("eval/per-sample.csv", lists[i]);
        check_ok(report_write(in_folder(run), in_folder("odd.html"), NULL));
    }
}
END_TEST

/* ---- a detector ---- */

#define CURVE "\"precision\": [1, 0.5, 0]}"
static const char curves[] = "[{\"name\": \"hands & <b>\", \"iou\": 0.5, " CURVE ", "
    "{\"name\": \"all\", \"iou\": 0.75, " CURVE "]";
static const char confused[] = "truth,\"hand\",\"<i>cup, red</i>\",missed\nhand,3,1,0\n"
    "\"<i>cup, red</i>\",0,0,2\nnothing,1,0,0\n";

START_TEST(a_detector)
{
    const char *text;

    run = "detector";
    make_run(true);
    put("eval/curves.json", curves);
    put("eval/confusion.csv", confused);
    put("eval/per-image.csv", "image,errors\n\"a.jpg\",1\n\"b.jpg\",4\n");
    text = page();
    has(text, "Boxes at IoU 0.50");
    has(text, "Boxes at IoU 0.75");
    has(text, ">hands &amp; &lt;b&gt; 0.500</text>");
    has(text, "<title>hand found as hand: 3 of 4</title>");
    has(text, "<title>hand found as &lt;i&gt;cup, red&lt;/i&gt;: 1 of 4</title>");
    has(text, "<title>nothing found as hand: 1 of 1</title>");
    lacks(text, "cup, red&lt;/i&gt; found as hand");
    has(text, "The worst pictures");
    has_in_order(text, "<td>b.jpg</td>", "<td>a.jpg</td>");
    lacks(text, "<i>");
    lt_arena_free(arena);
}
END_TEST

START_TEST(odd_detections)
{
    static const char *const odd_curves[] = {
        "[]", "{}", "[1]", "[{\"iou\": 0.5}]", "[{\"name\": \"a\", \"iou\": 0.5, \"precision\": [1]}]",
        "[{\"name\": \"a\", \"iou\": 0.5, \"precision\": [1, \"x\"]}]",
        "[{\"name\": \"a\", \"iou\": 0.5, \"precision\": [1, 7]}]",
    };
    static const char *const odd_tables[] = { "", "truth", "truth,\n", "truth,a\na", "truth,a\na,1,2,3",
                                              "truth,a\na,x\n", "truth,a\na,-5\nb,1e99\n", "\n\n\n" };

    run = "odd";
    make_run(true);
    for (size_t i = 0; i < LT_COUNT(odd_curves); i++) {
        put("eval/curves.json", odd_curves[i]);
        check_ok(report_write(in_folder(run), in_folder("odd.html"), NULL));
    }
    for (size_t i = 0; i < LT_COUNT(odd_tables); i++) {
        put("eval/confusion.csv", odd_tables[i]);
        check_ok(report_write(in_folder(run), in_folder("odd.html"), NULL));
    }
    put("eval/curves.json", "[");
    check_error(report_write(in_folder(run), in_folder("odd.html"), NULL), LT_EFORMAT, "eval/curves.json");
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_test(tc, a_scored_run);
    tcase_add_test(tc, scores_of_before_the_run_went_on);
    tcase_add_test(tc, nothing_from_a_file_is_markup);
    tcase_add_test(tc, a_run_that_is_not_scored);
    tcase_add_test(tc, no_run);
    tcase_add_test(tc, odd_files);
    tcase_add_test(tc, a_detector);
    tcase_add_test(tc, odd_detections);
}

int main(void)
{
    return run_suite("report", add_tests);
}
