/* SPDX-License-Identifier: Apache-2.0 */
/* Runs beside each other: what is on the page, and which runs cannot stand beside each other. */
#include "eval/report/sheet.h"
#include "libtensor/base/arena.h"
#include "libtensor/io/file.h"
#include "tests/suite.h"

enum { WIDTH = 16, HEIGHT = 8, PIXELS = WIDTH * HEIGHT };

static uint8_t truth[PIXELS][3], other[PIXELS][3], drawn[PIXELS][3];

/* run NAME, which was trained as one of the papers' variants */
static const char *make_run(const char *name, const char *config)
{
    const char *folder = in_folder(name);
    char path[256];

    check_ok(lt_make_dirs(folder));
    snprintf(path, sizeof(path), "%s/config.json", folder);
    put_file(path, config, strlen(config));
    return folder;
}

static lt_status surface(const posed_frame *f, int part, lt_opacity_rule rule, double iso, lt_arena *arena,
                         lt_mesh *out)
{
    (void)f, (void)part, (void)rule, (void)iso, (void)arena, (void)out;
    return lt_error(LT_EINVAL, "nothing is opaque enough");
}

static posed_frame frame(const char *name, const uint8_t (*rgb)[3], bool jittered, double psnr_db)
{
    return (posed_frame){ .number = 7, .name = name, .part = { "hand-01", "object-05" }, .width = WIDTH,
                          .height = HEIGHT, .camera = { 20, 20, 8, 4 }, .truth = rgb[0], .drawn = drawn[0],
                          .jittered = jittered, .psnr_db = psnr_db, .surface = surface };
}

static int count(const char *text, const char *what)
{
    int n = 0;

    for (; (text = strstr(text, what)); text += strlen(what))
        n++;
    return n;
}

static const char full[] = "{\"model\": {\"name\": \"hogs\", \"variant\": \"full\"}, \"data\": {\"jitter\": false}}";
static const char avatar[] = "{\"model\": {\"name\": \"hogs\", \"variant\": \"<b>mine\"}, \"data\": {\"jitter\": "
    "true}}";

/* The truth once in its own colours, a rendering a run with its PSNR, and the truth again where its colours are others;
 * nothing from a file is markup. */
START_TEST(page)
{
    lt_arena *arena = lt_arena_new();
    report_sheet *s = report_sheet_new(1, _i);
    const posed_frame a = frame("A/0007", truth, false, 31.25), b = frame("A/0007", other, true, 28.5);
    uint8_t *bytes;
    const char *text;
    size_t n;

    check_ok(report_sheet_run(s, make_run("full", full)));
    check_ok(report_sheet_add(s, &a));
    check_ok(report_sheet_run(s, make_run("avatar", avatar)));
    check_ok(report_sheet_add(s, &b));
    check_ok(report_sheet_write(s, in_folder("sheet.html")));
    check_ok(lt_read_file(arena, in_folder("sheet.html"), 1 << 20, &bytes, &n));
    text = (const char *)bytes;
    ck_assert_int_eq(count(text, "data:image/jpeg;base64,"), _i ? 6 : 4);
    ck_assert_int_eq(count(text, "31.25 dB"), 1);
    ck_assert_int_eq(count(text, "28.50 dB"), 1);
    ck_assert_int_eq(count(text, "jittered colours"), 1);
    ck_assert_int_eq(count(text, "frame 7, A/0007"), 1);
    ck_assert_int_eq(count(text, "<b>mine"), 0);
    ck_assert_int_ge(count(text, "&lt;b&gt;mine"), 1);
    report_sheet_free(s);
    lt_arena_free(arena);
}
END_TEST

/* Another frame, another size, another picture in the same colours; a folder that is no run. */
START_TEST(unlike)
{
    report_sheet *s = report_sheet_new(1, false);
    posed_frame f = frame("A/0007", truth, false, 30);

    check_error(report_sheet_run(s, in_folder("none")), LT_EIO, "none/config.json");
    check_ok(report_sheet_run(s, make_run("first", full)));
    check_ok(report_sheet_add(s, &f));
    check_ok(report_sheet_run(s, make_run("second", full)));
    f = frame("B/0001", truth, false, 30);
    check_error(report_sheet_add(s, &f), LT_EINVAL, "frame 7 is B/0001");
    f = frame("A/0007", truth, false, 30);
    f.height--;
    check_error(report_sheet_add(s, &f), LT_EINVAL, "frames are 16 x 7 pixels");
    f = frame("A/0007", other, false, 30);
    check_error(report_sheet_add(s, &f), LT_EINVAL, "is another picture than in");
    report_sheet_free(s);
}
END_TEST

static void add_tests(TCase *tc)
{
    memset(truth, 90, sizeof(truth));
    memset(other, 140, sizeof(other));
    tcase_add_checked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_loop_test(tc, page, 0, 2);
    tcase_add_test(tc, unlike);
}

int main(void)
{
    return run_suite("sheet", add_tests);
}
