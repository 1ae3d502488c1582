/* SPDX-License-Identifier: Apache-2.0 */
/* People in pictures, each with a body: whose boxes, what the record and the overlay have, boxes that are none. */
#include "pipeline/internal.h"
#include "pipeline/stage.h"

#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "tests/estimate/body_run.h"
#include "tests/suite.h"

#include <stdlib.h>
#include <unistd.h>

enum { WIDTH = 96, HEIGHT = 80 };

static body_estimator bodies;
static lt_arena *arena;
static char *said;                      /* messages of the last run */

static const char *in(const char *name)
{
    return lt_path_join(arena, scratch_folder, name);
}

/* One network and one picture for all tests */
static void setup(void)
{
    lt_image img;

    make_scratch_folder();
    arena = lt_arena_new();
    write_body_run(in("osx.safetensors"), "embedded", 0);
    check_ok(body_estimator_open(in("osx.safetensors"), &bodies));
    check_ok(lt_image_init(arena, WIDTH, HEIGHT, 3, 8, &img));
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++)
        img.data[i] = (uint8_t)(i * 7 % 251);
    check_ok(lt_png_write(in("a.png"), &img));
}

static void teardown(void)
{
    body_estimator_close(&bodies);
    lt_arena_free(arena);
    free(said);
    remove_scratch_folder();
}

static const cJSON *get(const cJSON *root, const char *key)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(root, key);

    ck_assert_msg(item, "no %s", key);
    return item;
}

static bool noted(const cJSON *root, const char *code)
{
    const cJSON *note;

    cJSON_ArrayForEach(note, get(root, "notes"))
        if (strcmp(get(note, "code")->valuestring, code) == 0)
            return true;
    return false;
}

static lt_status predict(const crop_box *box, cJSON **root)
{
    const char *input = in("a.png");
    predict_options o = { .body = &bodies, .inputs = &input, .n_inputs = 1, .out = in("out"), .person_box = box };
    size_t size;
    lt_status st;

    free(said);
    o.messages = open_memstream(&said, &size);
    st = predict_images(&o, NULL);
    fclose(o.messages);
    if (!st)
        check_ok(lt_json_read(in("out/a.json"), root));
    return st;
}

/* ---- a box that is given, or none ---- */

static void check_person(const cJSON *person, const char *source)
{
    ck_assert_str_eq(get(get(person, "box"), "source")->valuestring, source);
    ck_assert_int_eq(cJSON_GetArraySize(get(person, "joints3d_m")), BODY_NODES);
    ck_assert_int_eq(cJSON_GetArraySize(get(person, "joints2d_px")), BODY_NODES);
    ck_assert_int_eq(cJSON_GetArraySize(get(person, "pose_rad")), 3 * BODY_JOINTS);
    ck_assert_int_eq(cJSON_GetArraySize(get(person, "shape")), BODY_SHAPES);
    ck_assert_int_eq(cJSON_GetArraySize(get(person, "expression")), BODY_EXPRESSIONS);
    for (int k = 0; k < 3; k++)         /* it begins at the pelvis */
        ck_assert_double_eq_tol(cJSON_GetArrayItem(get(person, "pelvis_m"), k)->valuedouble,
                                cJSON_GetArrayItem(cJSON_GetArrayItem(get(person, "joints3d_m"), 0), k)->valuedouble,
                                1e-6);
}

START_TEST(one_person)
{
    const crop_box box = { 20, 10, 60, 70 };
    cJSON *root;

    check_ok(predict(&box, &root));
    ck_assert_int_eq(cJSON_GetArraySize(get(root, "people")), 1);
    check_person(cJSON_GetArrayItem(get(root, "people"), 0), "given");
    ck_assert_str_eq(get(get(root, "body_estimator"), "body_model")->valuestring, "synthetic stand-in, not SMPL-X");
    ck_assert(cJSON_IsNull(get(root, "model")) && cJSON_GetArraySize(get(root, "hands")) == 0);
    ck_assert(noted(root, "camera-assumed") && !noted(root, "person-box-assumed"));
    ck_assert_int_eq(access(in("out/a.overlay.png"), F_OK), 0);
    cJSON_Delete(root);
}
END_TEST

START_TEST(no_box)
{
    cJSON *root;

    check_ok(predict(NULL, &root));
    check_person(cJSON_GetArrayItem(get(root, "people"), 0), "default");
    ck_assert(noted(root, "person-box-assumed"));
    ck_assert_ptr_nonnull(strstr(said, "a.png: no --person-box: took the whole picture for the person"));
    cJSON_Delete(root);
}
END_TEST

START_TEST(box_outside)
{
    const crop_box box = { 200, 10, 260, 70 };
    cJSON *root;

    check_error(predict(&box, &root), LT_EFORMAT, "skipped 1 of 1 inputs");
    ck_assert_ptr_nonnull(strstr(said, "a.png: the person box 200,10,260,70 lies outside the image of 96 x 80 pixels"));
}
END_TEST

/* ---- people that a detector sees ---- */

/* n people behind something else */
static cJSON *detected(int n)
{
    static const char *const row[] = { "look", "body", "judge", "draw", NULL };
    static uint8_t pixels[3 * WIDTH * HEIGHT];
    static detector seeing;
    static const char *names[] = { "person", "cup" };
    const predict_options o = { .detector = &seeing, .body = &bodies };
    predict_detection list[] = {
        { .kind = DETECTED_OBJECT, .cls = 1, .name = "cup", .score = 0.9, .box = { 50, 50, 60, 60 } },
        { .kind = DETECTED_PERSON, .name = "person", .score = 0.8, .box = { 0, 0, 50, 79 } },
        { .kind = DETECTED_PERSON, .name = "person", .score = 0.7, .box = { 40, 10, 80, 79 } },
    };
    predict_frame f = { .o = &o, .arena = arena, .notes.arena = arena, .detection = list, .n_detections = 1 + n,
                        .detected = true };
    pipeline *p;
    cJSON *root;
    char *line;
    size_t size;
    FILE *to = open_memstream(&line, &size);

    seeing = (detector){ .name = names, .n = 2, .t = { .path = "d", .m = bodies.t.m } };
    f.scene = (predict_view){ .path = "p", .name = "p", .rgb = pixels, .width = WIDTH, .height = HEIGHT,
                              .orientation = 1, .camera = { 120, 120, 47.5, 39.5 } };
    check_ok(pipeline_open(&o, FRAME_SCENE | FRAME_DETECTIONS, row, &p));
    check_ok(pipeline_run(p, &f));
    check_ok(predict_print_json(&f, to));
    pipeline_close(p);
    fclose(to);
    check_ok(lt_json_parse("line", line, size, &root));
    free(line);
    return root;
}

START_TEST(people)
{
    cJSON *root = detected(2);
    const cJSON *all = get(root, "people");

    ck_assert_int_eq(cJSON_GetArraySize(all), 2);
    for (int i = 0; i < 2; i++) {
        check_person(cJSON_GetArrayItem(all, i), "detected");
        ck_assert_double_eq(get(cJSON_GetArrayItem(all, i), "score")->valuedouble, i ? 0.7 : 0.8);
    }
    ck_assert_int_eq(cJSON_GetArraySize(get(root, "objects")), 1);
    ck_assert(!noted(root, "no-person"));
    cJSON_Delete(root);
    root = detected(0);
    ck_assert_int_eq(cJSON_GetArraySize(get(root, "people")), 0);
    ck_assert(noted(root, "no-person"));
    cJSON_Delete(root);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_set_timeout(t, 120);
    tcase_add_unchecked_fixture(t, setup, teardown);
    tcase_add_test(t, one_person);
    tcase_add_test(t, no_box);
    tcase_add_test(t, box_outside);
    tcase_add_test(t, people);
}

int main(void)
{
    return run_suite("bodies", add_tests);
}
