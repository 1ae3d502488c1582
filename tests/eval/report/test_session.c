/* SPDX-License-Identifier: Apache-2.0 */
/* The page of a session: who did what, beside the truth; tracks, times, drops, pictures; lines that are none. */
#include "data/recording/recording.h"
#include "eval/report/session/internal.h"
#include "eval/report/session/session.h"
#include "libtensor/io/file.h"
#include "tests/scratch.h"

#include <stdlib.h>
#include <unistd.h>

enum { WIDTH = 64, HEIGHT = 48, SETS = 20 };

#define SET "{\"schema\":\"palmar.set/1\","
#define EVIL "<script>alert(1)</script>"

static const recording_rig rig = {
    .camera = {
        { .name = "front", .role = RECORDING_FRONT, .width = WIDTH, .height = HEIGHT, .K = { 60, 60, 31.5, 23.5 },
          .placed = true, .R = { 1, 0, 0, 0, 1, 0, 0, 0, 1 } },
        { .name = "side", .role = RECORDING_SIDE, .width = WIDTH, .height = HEIGHT, .K = { 60, 60, 31.5, 23.5 } },
    },
    .n = 2, .fps = 10, .synthetic = true,
};

/* A folder of two cameras with a frame each in ten sets a second; the second one's clock is 5 s ahead. */
static void record(const char *root)
{
    static uint8_t rgb[3 * WIDTH * HEIGHT];
    const lt_image image = { WIDTH, HEIGHT, 3, 8, rgb };
    recording_writer *w;
    int64_t line;

    check_ok(recording_create(root, &rig, &w));
    for (int k = 1; k <= SETS; k++)
        for (int c = 0; c < 2; c++) {
            check_ok(recording_store(w, c, k, &(recording_pictures){ .colour = &image }));
            check_ok(recording_add(w, c, k, 0.1 * (k - 1) + 5 * c, false, &line));
        }
    check_ok(recording_close(w));
}

/* "[x, y, z]" n times, with commas between */
static void put_points(FILE *f, int n, double x, double y, double z)
{
    for (int i = 0; i < n; i++)
        fprintf(f, "%s[%g,%g,%g]", i ? "," : "", x, y + 0.01 * i, z);
}

/* Somebody walks, then waves, and touches a mug; the mug's number changes halfway. */
static void put_line(FILE *f, int k)
{
    fprintf(f, "{\"schema\":\"palmar.set/1\",\"set\":%d,\"t\":[%g,", k, 0.1 * k);
    fprintf(f, k % 2 ? "null" : "%g", 5 + 0.1 * k);
    fprintf(f, "],\"pair_ms\":1.5,\"dropped\":[0,2],\"tracks\":[{\"id\":1,\"class\":\"person\",\"camera\":0,"
            "\"track\":1,\"box\":[5,5,40,40],\"score\":0.9,\"centre\":null},{\"id\":%d,\"class\":\"025_mug\","
            "\"camera\":1,\"track\":1,\"box\":[20,20,30,30]}],\"hands\":[{\"id\":7,\"side\":\"left\",\"person\":1,"
            "\"state\":\"%s\",\"camera\":0,\"joints\":[", k < SETS / 2 ? 2 : 3, k < 15 ? "on" : "coast");
    put_points(f, 21, 0, 0, 1);
    fprintf(f, "]}],\"objects\":[{\"id\":2,\"class\":\"025_mug\",\"R\":[1,0,0,0,1,0,0,0,1],\"t\":[0,0,1],\"state\":"
            "\"on\"}],\"people\":[{\"id\":1,\"camera\":0,\"box\":[1,2,3,4],\"joints\":[");
    put_points(f, 65, 0.1, 0, 1.5);
    fprintf(f, "]}],\"contact\":[%s],\"action\":[{\"person\":1,\"class\":\"%s\",\"p\":0.8,\"onset\":0}],"
            "\"interaction\":[{\"person\":1,\"state\":\"%s\",\"object\":null,\"side\":\"left\",\"since\":0,\"p\":0.5}],"
            "\"age_ms\":%d,\"stages_ms\":{\"S1\":10,\"S4\":%d}}\n",
            k > 5 ? "{\"hand\":7,\"object\":2,\"camera\":1,\"since\":0.6}" : "",
            k < SETS / 2 ? "walking" : "waving", k < 8 ? "none" : "hold", 50 + k, k);
}

static void put_session(const char *root, const char *more)
{
    FILE *f = fopen(lt_path_join(arena, root, "session.ndjson"), "w");

    for (int k = 0; k < SETS; k++)
        put_line(f, k);
    fputs(more, f);
    fclose(f);
}

/* The same person by another number, and somebody else far away */
static void put_truth(const char *root)
{
    FILE *f = fopen(lt_path_join(arena, root, "truth.ndjson"), "w");

    fputs("{\"t\":[null,null],\"people\":[],\"action\":[]}\n", f);           /* no camera kept a frame */
    for (int k = 0; k < 3 * SETS; k++) {
        fprintf(f, "{\"t\":%g,\"light\":1,\"people\":[{\"id\":40,\"joints\":[", k / 30.0);
        put_points(f, 65, 0.2, 0, 1.5);
        fputs("]},{\"id\":41,\"joints\":[", f);
        put_points(f, 65, 3, 0, 1.5);
        fprintf(f, "]}],\"action\":[{\"person\":40,\"class\":\"%s\"},{\"person\":41,\"class\":\"pointing\"}]}\n",
                k < 31 ? "walking" : "waving");
    }
    fclose(f);
}

static const char *page(const char *root)
{
    uint8_t *bytes;
    size_t n;

    check_ok(session_report_write(root, lt_path_join(arena, root, "report.html")));
    check_ok(lt_read_file(arena, lt_path_join(arena, root, "report.html"), LT_FILE_MAX, &bytes, &n));
    return (const char *)bytes;
}

static void has(const char *text, const char *part)
{
    ck_assert_msg(strstr(text, part), "the page lacks %s", part);
}

static int count(const char *text, const char *part)
{
    int n = 0;

    while ((text = strstr(text, part)) != NULL) {
        text += strlen(part);
        n++;
    }
    return n;
}

static const lane *find(const history *h, lane_kind kind, int64_t id)
{
    for (int i = 0; i < h->n_lanes; i++)
        if (h->lane[i].kind == kind && h->lane[i].id == id)
            return &h->lane[i];
    ck_abort_msg("no lane %d of %d", (int)kind, (int)id);
    return NULL;
}

/* ---- whole sessions ---- */

START_TEST(what_was_when)
{
    const char *root = at("a");
    const lane *l;
    history h;

    record(root);
    put_session(root, "{\"summary\":1,\"captured\":60,\"taken\":30,\"dropped\":30}\n");
    put_truth(root);
    check_ok(history_read(arena, root, &h));
    ck_assert_int_eq(h.n, SETS);
    ck_assert_double_eq_tol(h.time[SETS - 1], 1.9, 1e-9);
    l = find(&h, LANE_ACTION, 1);
    ck_assert_int_eq(l->n, 2);
    ck_assert_str_eq(l->span[1].label, "waving");
    ck_assert_double_eq_tol(l->span[0].to, 1, 1e-9);            /* it goes on until the next one begins */
    ck_assert_double_eq_tol(l->span[1].to, 1.9, 1e-9);
    ck_assert_double_eq_tol(find(&h, LANE_INTERACTION, 1)->span[0].from, 0.8, 1e-9);
    l = find(&h, LANE_CONTACT, 1);
    ck_assert(strcmp(l->cls, "left") == 0 && strcmp(l->span[0].label, "025_mug") == 0);
    ck_assert_int_eq(find(&h, LANE_TRACK, 3)->n, 1);
    ck_assert(find(&h, LANE_HAND, 7)->span[1].pale && !find(&h, LANE_HAND, 7)->span[0].pale);
    l = find(&h, LANE_TRUE_ACTION, 40);
    ck_assert_int_eq(l->beside, 1);
    ck_assert_double_eq_tol(l->span[1].from, 31 / 30.0, 1e-5);
    ck_assert_int_eq(find(&h, LANE_TRUE_ACTION, 41)->beside, 0);
    ck_assert_double_eq(h.drops[1].y[SETS - 1], 2 * SETS);
    ck_assert_double_eq(h.sum.dropped, 30);
}
END_TEST

/* He walks until 0.9 s and then waves, in truth until 1 s, at 10 sets a second: the set at 1 s is the only one that is
 * wrong, and near the change. What was said of the state, none and hold, has no truth. */
START_TEST(beside_the_truth)
{
    const char *root = at("a");
    agreement a;
    history h;

    record(root);
    put_session(root, "");
    put_truth(root);
    check_ok(history_read(arena, root, &h));
    check_ok(agreement_of(&h, LANE_TRUE_ACTION, &a));
    ck_assert_int_eq(a.all, SETS);
    ck_assert_int_eq(a.right, SETS - 1);
    ck_assert_int_eq(a.settled_right, a.settled);
    ck_assert_int_ge(a.settled, SETS - 8);
    ck_assert_int_eq(a.n_words, 2);
    ck_assert_str_eq(a.word[0].word, "walking");
    ck_assert(a.word[0].all == 11 && a.word[0].right == 10 && a.word[1].all == 9 && a.word[1].right == 9);
    ck_assert_int_eq(a.n_delays, 2);
    ck_assert_double_eq_tol(a.median_delay, -1 / 60.0, 1e-4);   /* between 0 and a frame early */
    check_ok(agreement_of(&h, LANE_TRUE_INTERACTION, &a));
    ck_assert_int_eq(a.all, 0);
}
END_TEST

START_TEST(the_page)
{
    const char *root = at("a"), *text;

    record(root);
    put_session(root, "{\"summary\":1,\"captured\":60,\"taken\":30,\"dropped\":30,\"fps\":9.5,\"age_ms\":{\"p50\":59,"
                "\"p95\":68},\"rss_mb\":{\"first\":100,\"last\":101},\"crc32\":\"0badcafe\"}\n");
    put_truth(root);
    text = page(root);
    has(text, "2 cameras, 20 sets of frames in 1.9 s, with the truth");
    has(text, "synthetic data");
    has(text, "<td>age, 95 % are below, ms</td><td class=n>68.0</td>");
    has(text, "0badcafe");
    has(text, "<h3>Person 1</h3>");
    has(text, "<span>action, truth</span>");
    has(text, "<title>waving 1.00 to 1.90 s</title>");
    has(text, "<h2>Beside the truth</h2>");
    has(text, "<tr><td>action</td><td>walking</td><td class=n>90.9 %</td><td class=n>11</td></tr>");
    has(text, "Of 2 onsets of an action 2 were told");
    has(text, "<h3>Of nobody that is known</h3>");
    has(text, "025_mug #3");
    has(text, "<td>age</td><td class=n>59.0</td><td class=n>68.0</td><td class=n>69.0</td>");
    has(text, "<td>S4 whole bodies</td>");
    has(text, ">dropped, side</text>");
    has(text, "Set 19, 1.90 s; person 1: waving (0.80)");
    ck_assert_int_eq(count(text, "src=\"data:image/jpeg;base64,"), 12);
    ck_assert_int_eq(count(text, "<script"), 1);
}
END_TEST

/* Killed in a line, and nothing to sum up; without truth */
START_TEST(cut_short)
{
    const char *root = at("a"), *text;

    record(root);
    put_session(root, "{\"schema\":\"palmar.se");
    text = page(root);
    has(text, "20 sets of frames in 1.9 s <span");
    has(text, "The session has no summary: it was cut short.");
    put_file(lt_path_join(arena, root, "session.ndjson"), "", 0);
    has(page(root), "0 sets of frames in 0.0 s");
}
END_TEST

START_TEST(nothing_from_a_file_is_markup)
{
    const char *root = at("a"), *text;

    record(root);
    put_session(root, SET "\"t\":[9],\"tracks\":[{\"id\":9,\"class\":\"" EVIL "\",\"camera\":0,"
                "\"box\":[1e9,-1e9,null,4]}],\"action\":{\"class\":\"" EVIL "\"},\"contact\":[{\"hand\":1,"
                "\"object\":9}]}\n"
                "{\"summary\":1,\"crc32\":\"" EVIL "\"}\n");
    text = page(root);
    has(text, "&lt;script&gt;alert(1)&lt;/script&gt;");
    ck_assert_int_eq(count(text, "<script"), 1);
}
END_TEST

/* ---- lines that are none ---- */

START_TEST(bad_lines)
{
    static const struct { const char *line, *reason; } bad[] = {
        { "{\"schema\":\"palm", "session.ndjson:21: no JSON object" },
        { "[1]", "session.ndjson:21: no JSON object" },
        { "{\"t\":[0]}", "21: \"schema\" is missing or wrong, want palmar.set/1" },
        { "{\"schema\":\"palmar.set/2\"}", "21: \"schema\" is missing or wrong" },
        { "{\"schema\":\"palmar.set/1\"}", "21: \"t\" is missing or wrong, want seconds of at least one camera" },
        { SET "\"t\":[null]}", "21: \"t\" is missing or wrong" },
        { SET "\"t\":[0,0,0,0,0]}", "21: \"t\" is missing or wrong, want 1 to 4 numbers" },
        { SET "\"t\":[1e300]}", "21: \"t\" is missing or wrong" },
        { SET "\"t\":[0],\"age_ms\":\"old\"}", "21: \"age_ms\" is missing or wrong" },
        { SET "\"t\":[0],\"tracks\":7}", "21: \"tracks\" is missing or wrong, want a list" },
        { SET "\"t\":[0],\"tracks\":[7]}", "21: item 1 of \"tracks\" is no object" },
        { SET "\"t\":[0],\"tracks\":[{\"id\":1.5}]}", "21: \"id\" of item 1 of \"tracks\" is missing "
          "or wrong, want a whole number" },
        { SET "\"t\":[0],\"tracks\":[{\"id\":1,\"class\":\"a\",\"camera\":4}]}", "21: \"camera\" of "
          "item 1 of \"tracks\"" },
        { SET "\"t\":[0],\"people\":[{\"id\":1,\"joints\":[[0,0,0]]}]}", "21: \"joints\" of item 1 of "
          "\"people\" is missing or wrong, want 65 rows" },
        { SET "\"t\":[0],\"hands\":[{\"id\":1,\"side\":\"both\"}]}", "21: \"side\" of item 1 of "
          "\"hands\" is missing or wrong, want left or right" },
        { SET "\"t\":[0],\"action\":[{\"person\":1}]}", "21: \"class\" of item 1 of \"action\"" },
        { "{\"summary\":1,\"fps\":[]}", "21: \"fps\" is missing or wrong, want a number" },
    };
    const char *root = at("a");

    record(root);
    for (size_t i = 0; i < LT_COUNT(bad); i++) {
        put_session(root, lt_arena_printf(arena, "%s\n", bad[i].line));
        check_error(session_report_write(root, at("bad.html")), LT_EFORMAT, bad[i].reason);
        ck_assert_int_ne(access(at("bad.html"), F_OK), 0);
    }
    put_session(root, "");
    put_file(lt_path_join(arena, root, "truth.ndjson"), "{\"t\":[]}\n", 9);
    check_error(session_report_write(root, at("bad.html")), LT_EFORMAT, "truth.ndjson:1: \"t\" is missing or wrong");
}
END_TEST

START_TEST(no_session)
{
    record(at("a"));
    check_error(session_report_write(at("a"), at("bad.html")), LT_EIO, "a: was not watched yet");
    check_error(session_report_write(at("none"), at("bad.html")), LT_EIO, "none/recording.json");
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 60);
    tcase_add_checked_fixture(tc, open_scratch, close_scratch);
    tcase_add_test(tc, what_was_when);
    tcase_add_test(tc, beside_the_truth);
    tcase_add_test(tc, the_page);
    tcase_add_test(tc, cut_short);
    tcase_add_test(tc, nothing_from_a_file_is_markup);
    tcase_add_test(tc, bad_lines);
    tcase_add_test(tc, no_session);
}

int main(void)
{
    return run_suite("session", add_tests);
}
