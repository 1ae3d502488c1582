/* SPDX-License-Identifier: Apache-2.0 */
/* Recordings: what is written is read, depth bit by bit; killed in the middle of a line; files that are wrong. */
#include "data/recording/recording.h"
#include "libtensor/io/file.h"
#include "tests/suite.h"

static lt_arena *arena;

static void setup(void)
{
    make_scratch_folder();
    arena = lt_arena_new();
}

static void teardown(void)
{
    lt_arena_free(arena);
    remove_scratch_folder();
}

static const recording_rig two = {
    .n = 2, .fps = 30, .has_robot = true, .robot = { 0, 1, 0, 0.5 }, .synthetic = true,
    .camera = {
        { .name = "front", .role = RECORDING_FRONT, .width = 20, .height = 16, .K = { 30, 31, 9.5, 7.5 },
         .placed = true,
          .R = { 0, 0, 1, -1, 0, 0, 0, -1, 0 }, .t = { 1, 2, 3 }, .depth_scale = 0.001 },
        { .name = "plain \"side\"", .role = RECORDING_SIDE, .width = 16, .height = 16, .K = { 30, 30, 7.5, 7.5 } },
    },
};

/* ---- depth ---- */

START_TEST(depth_comes_back)
{
    uint16_t depth[12 * 7], back[12 * 7];
    uint8_t *bytes;
    size_t n;

    for (int i = 0; i < 84; i++)
        depth[i] = (uint16_t)(i % 5 == 0 ? 0 : i % 7 == 0 ? 65535 : 700 + 3 * i);
    check_ok(recording_depth_pack(arena, depth, 12, 7, &bytes, &n));
    check_ok(recording_depth_unpack(arena, "a.z16", bytes, n, 12, 7, back));
    ck_assert_mem_eq(depth, back, sizeof(depth));
    check_error(recording_depth_unpack(arena, "a.z16", bytes, n, 12, 6, back), LT_EFORMAT, "a.z16: no depth of 12 x 6");
    for (size_t cut = 0; cut < n; cut++)
        ck_assert_int_eq(recording_depth_unpack(arena, "a.z16", bytes, cut, 12, 7, back), LT_EFORMAT);
}
END_TEST

/* ---- a folder ---- */

static void record(const char *root)
{
    uint8_t rgb[3 * 20 * 16];
    uint16_t depth[20 * 16];
    recording_writer *w;
    int64_t line;

    memset(rgb, 90, sizeof(rgb));
    for (int i = 0; i < 20 * 16; i++)
        depth[i] = (uint16_t)(i * i);
    check_ok(recording_create(root, &two, &w));
    for (int c = 0; c < 2; c++)
        for (int k = 1; k <= 2; k++) {
            const lt_image image = { two.camera[c].width, two.camera[c].height, 3, 8, rgb };

            check_ok(recording_store(w, c, k, &(recording_pictures){ .colour = &image, .depth = c ? NULL : depth }));
        }
    check_ok(recording_add(w, 0, 1, 0.25, true, &line));
    check_ok(recording_add(w, 1, 1, -4e-3, false, &line));
    check_ok(recording_add(w, 0, 2, 0.2833, true, &line));
    ck_assert_int_eq(line, 2);
    check_ok(recording_add_set(w, &(recording_set){ { 0, 1 } }));
    check_ok(recording_add_set(w, &(recording_set){ { 2, -1 } }));
    check_ok(recording_close(w));
}

START_TEST(a_folder)
{
    const char *root = in_folder("a");
    recording_writer *w;
    lt_image image;
    recording r;

    record(root);
    ck_assert(recording_probe(root) && !recording_probe(in_folder("b")));
    check_ok(recording_open(arena, root, &r));
    ck_assert_int_eq(r.rig.n, 2);
    ck_assert(r.rig.synthetic && r.rig.has_robot && r.rig.camera[0].placed && !r.rig.camera[1].placed);
    ck_assert_str_eq(r.rig.camera[1].name, "plain \"side\"");
    ck_assert_mem_eq(r.rig.camera[0].R, two.camera[0].R, sizeof(two.camera[0].R));
    ck_assert_mem_eq(&r.rig.camera[0].K, &two.camera[0].K, sizeof(lt_camera));
    ck_assert_mem_eq(r.rig.robot, two.robot, sizeof(two.robot));
    ck_assert_int_eq(r.n_frames, 3);
    ck_assert_double_eq(r.frame[1].t, -4e-3);
    ck_assert_ptr_null(r.frame[1].depth);
    ck_assert_int_eq(r.n_sets, 2);
    ck_assert_int_eq(r.set[1].frame[0], 2);
    ck_assert_int_eq(r.set[1].frame[1], -1);
    check_ok(recording_colour(&r, 1, arena, &image));
    ck_assert_int_eq(image.width, 16);
    check_ok(recording_depth(&r, 0, arena, &image));
    ck_assert_int_eq(((const uint16_t *)image.data)[300], (300 * 300) & 0xffff);
    check_error(recording_create(root, &two, &w), LT_EINVAL, "there is a recording in it");
    check_ok(recording_close(w));
}
END_TEST

/* Killed while it wrote a line: that line is left out. */
START_TEST(cut_off)
{
    const char *root = in_folder("a");
    recording r;
    FILE *f;

    record(root);
    f = fopen(in_folder("a/frames.jsonl"), "a");
    fputs("{\"camera\":1,\"t\":0.0", f);
    fclose(f);
    check_ok(recording_open(arena, root, &r));
    ck_assert_int_eq(r.n_frames, 3);
}
END_TEST

START_TEST(another_size)
{
    const char *root = in_folder("a");
    uint8_t rgb[3 * 16 * 16] = { 0 };
    lt_image image = { 16, 16, 3, 8, rgb };
    recording r;

    record(root);
    check_ok(lt_jpeg_write(in_folder("a/front/000001.jpg"), &image, 90));
    check_ok(recording_open(arena, root, &r));
    check_error(recording_colour(&r, 0, arena, &image), LT_EFORMAT, "16 x 16, expected 20 x 16 as recording.json says");
}
END_TEST

/* ---- what is wrong ---- */

#define CAMERA(more) "{\"name\":\"a\",\"role\":\"front\",\"width\":20,\"height\":16,\"K\":[9,9,9,9]," \
    "\"depth_scale\":0.001" \
    more "}"
#define RIG(cameras) "{\"schema\":\"palmar.recording/1\",\"fps\":30,\"cameras\":[" cameras "]}"

static const struct { const char *text, *line; } wrong_rigs[] = {
    { "{}", "r.json: \"schema\": expected \"palmar.recording/1\"" },
    { RIG(""), "\"cameras\": expected a list of 1 to 4" },
    { RIG(CAMERA("") "," CAMERA("")), "r.json: camera 2: \"a\" is the name of camera 1" },
    { RIG(CAMERA(",\"R_world_cam\":[1,0,0,0,1,0,0,0,1]")), "camera 1: \"t_world_cam\": expected a list of 3" },
    { RIG(CAMERA(",\"R_world_cam\":[1,0,0,0,1,0,0,0,-1],\"t_world_cam\":[0,0,0]")), "\"R_world_cam\" is no rotation" },
    { RIG("{\"name\":\"../a\"}"), "\"name\": expected the name of a folder" },
    { RIG("{\"name\":\"a\",\"role\":\"top\"}"), "\"role\": expected \"table\"" },
    { "{\"schema\":\"palmar.recording/1\",\"fps\":0,\"cameras\":[]}", "\"fps\": expected a number from" },
};

START_TEST(wrong_rig)
{
    recording_rig rig;

    check_error(recording_rig_parse(arena, "r.json", wrong_rigs[_i].text, strlen(wrong_rigs[_i].text), &rig),
                LT_EFORMAT,
                wrong_rigs[_i].line);
}
END_TEST

static lt_status parse(const char *text, recording *r,
                       lt_status (*how)(lt_arena *, const char *, const char *, size_t, recording *))
{
    return how(arena, "x.jsonl", text, strlen(text), r);
}

static const struct { const char *text, *line; } wrong_frames[] = {
    { "{\"camera\":0}\n", "x.jsonl:1: \"t\": expected seconds" },
    { "{\"camera\":2,\"t\":0}\n", "x.jsonl:1: \"camera\" is none" },
    { "{\"camera\":0,\"t\":1,\"colour\":\"/etc/passwd\"}\n", "\"colour\": expected a file within" },
    { "{\"camera\":0,\"t\":1,\"colour\":\"a\"}\n{\"camera\":0,\"t\":1,\"colour\":\"a\"}\n",
     "x.jsonl:2: \"t\": expected seconds" },
    { "{\"camera\":1,\"t\":1,\"colour\":\"a\",\"depth\":\"b\"}\n", "\"depth\" of a camera without depth_scale" },
    { "[\n", "x.jsonl:1:1" },
};

START_TEST(wrong_frame)
{
    recording r = { .rig = two };

    check_error(parse(wrong_frames[_i].text, &r, recording_parse_frames), LT_EFORMAT, wrong_frames[_i].line);
}
END_TEST

static const struct { const char *text, *line; } wrong_sets[] = {
    { "{}\n", "x.jsonl:1: \"frames\": expected a list" },
    { "{\"frames\":[0]}\n", "expected a list" },
    { "{\"frames\":[null,null]}\n", "\"frames\": none" },
    { "{\"frames\":[0,0]}\n", "a number is no line of frames.jsonl" },
    { "{\"frames\":[0,null]}\n{\"frames\":[2,null]}\n", "x.jsonl:2: " },
};

START_TEST(wrong_set)
{
    recording r = { .rig = two };

    check_ok(parse("{\"camera\":0,\"t\":1,\"colour\":\"a\"}\n{\"camera\":1,\"t\":1,\"colour\":\"a\"}\n", &r,
                   recording_parse_frames));
    check_error(parse(wrong_sets[_i].text, &r, recording_parse_sets), LT_EFORMAT, wrong_sets[_i].line);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, setup, teardown);
    tcase_add_test(tc, depth_comes_back);
    tcase_add_test(tc, a_folder);
    tcase_add_test(tc, cut_off);
    tcase_add_test(tc, another_size);
    tcase_add_loop_test(tc, wrong_rig, 0, (int)LT_COUNT(wrong_rigs));
    tcase_add_loop_test(tc, wrong_frame, 0, (int)LT_COUNT(wrong_frames));
    tcase_add_loop_test(tc, wrong_set, 0, (int)LT_COUNT(wrong_sets));
}

int main(void)
{
    return run_suite("recording", add_tests);
}
