/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures for detectors: files, annotations against masks, figures, and the parts of a scene. */
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/coco_rle.h"
#include "libtensor/io/image/image.h"
#include "libtensor/io/text/json.h"
#include "synth/detect/detect.h"
#include "synth/detect/tally.h"
#include "synth/world/person.h"
#include "synth/world/seen.h"
#include "tests/synth/made.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PICTURES = 15, TRAIN = 12, SIDE = 320 };

static synth_figure figure[SYNTH_FIGURES];
static int n_figures;

static synth_options options(const char *folder)
{
    return (synth_options){ .preset = SYNTH_DETECT, .out = at(folder), .seed = 7, .frames = PICTURES };
}

/* One dataset for all tests. */
static void setup(void)
{
    synth_options o;

    open_scratch();
    o = options("data");
    check_ok(synth_generate(&o, figure, &n_figures));
}

/* ---- files ---- */

START_TEST(every_file_is_in_the_manifest)
{
    ck_assert_int_eq(check_manifest("detect", "7"), PICTURES + 3);
}
END_TEST

START_TEST(same_seed_same_bytes)
{
    synth_options o = options("again");

    lt_set_threads(3);
    check_ok(synth_generate(&o, NULL, NULL));
    lt_set_threads(0);
    same_files(at("data/manifest.json"), at("again/manifest.json"));
}
END_TEST

static bool is_near(uint64_t number)
{
    lt_rng r = lt_rng_make(7, lt_rng_mix(0x4e454152, number));      /* as synth/detect/layout.c draws */

    return lt_rng_uniform(&r) < 0.5;
}

static double number_in(const char *path, const char *key)
{
    double found;
    cJSON *j;

    check_ok(lt_json_read(at(path), &j));
    found = cJSON_GetObjectItem(j, key)->valuedouble;
    cJSON_Delete(j);
    return found;
}

/* Pictures from near by take the place of some, leave the others as they are, and are not in the figures. */
START_TEST(near_hands_change_their_pictures_alone)
{
    synth_options o = options("near");
    int n_near = 0;

    o.near = 0.5;
    check_ok(synth_generate(&o, NULL, NULL));
    for (int i = 0; i < PICTURES; i++) {
        const bool evaluation = i < PICTURES - TRAIN;
        const char *file = lt_arena_printf(arena, "%s/%06d.jpg", evaluation ? "evaluation" : "train",
                                           (evaluation ? i : i - PICTURES + TRAIN) + 1);
        uint8_t *a, *b;
        size_t n, m;
        check_ok(lt_read_file(arena, at(lt_arena_printf(arena, "data/%s", file)), LT_FILE_MAX, &a, &n));
        check_ok(lt_read_file(arena, at(lt_arena_printf(arena, "near/%s", file)), LT_FILE_MAX, &b, &m));
        ck_assert_msg((n == m && memcmp(a, b, n) == 0) == !is_near((uint64_t)i), "%s", file);
        n_near += is_near((uint64_t)i);
    }
    ck_assert_double_eq(number_in("data/stats.json", "images"), PICTURES);
    ck_assert_double_eq(number_in("near/stats.json", "images"), PICTURES - n_near);
    ck_assert_double_eq(number_in("near/manifest.json", "near"), 0.5);
}
END_TEST

START_TEST(the_evaluation_seed_is_for_evaluation_alone)
{
    ck_assert_int_eq(synth_detect_evaluation(1, 5000), 1000);
    ck_assert_int_eq(synth_detect_evaluation(1, 50000), 1000);
    ck_assert_int_eq(synth_detect_evaluation(1, 15), 3);
    ck_assert_int_eq(synth_detect_evaluation(DETECT_EVALUATION_SEED, 1000), 1000);
    ck_assert_int_eq(synth_detect_evaluation(DETECT_EVALUATION_SEED, 3000), 3000);
}
END_TEST

/* ---- annotations ---- */

static double number(const cJSON *of, const char *key)
{
    const cJSON *j = cJSON_GetObjectItem(of, key);

    ck_assert_msg(cJSON_IsNumber(j), "no %s", key);
    return j->valuedouble;
}

/* The box, the area and what the runs cover say the same. */
static void check_annotation(const cJSON *a)
{
    static uint8_t mask[SIDE * SIDE];
    const cJSON *segmentation = cJSON_GetObjectItem(a, "segmentation"), *box = cJSON_GetObjectItem(a, "bbox");
    int x0 = SIDE, y0 = SIDE, x1 = 0, y1 = 0, area = 0;

    check_ok(lt_rle_decode(cJSON_GetObjectItem(segmentation, "counts")->valuestring, SIDE, SIDE, mask));
    for (int i = 0; i < SIDE * SIDE; i++)
        if (mask[i]) {
            x0 = (int)lt_min_i64(x0, i % SIDE);
            x1 = (int)lt_max_i64(x1, i % SIDE + 1);
            y0 = (int)lt_min_i64(y0, i / SIDE);
            y1 = i / SIDE + 1;
            area++;
        }
    ck_assert_int_eq(area, (int)number(a, "area"));
    ck_assert_int_eq(cJSON_GetArrayItem(box, 0)->valueint, x0);
    ck_assert_int_eq(cJSON_GetArrayItem(box, 1)->valueint, y0);
    ck_assert_int_eq(cJSON_GetArrayItem(box, 2)->valueint, x1 - x0);
    ck_assert_int_eq(cJSON_GetArrayItem(box, 3)->valueint, y1 - y0);
    ck_assert(number(a, "visible") >= 0.1 && number(a, "visible") <= 1);
    ck_assert_int_eq((int)number(a, "iscrowd"), 0);
    ck_assert_int_eq(cJSON_HasObjectItem(a, "side"), (int)number(a, "category_id") == SYNTH_HAND_THING + 1);
}

START_TEST(annotations_agree_with_their_masks)
{
    static const struct { const char *split; int images; } cases[] = { { "train", TRAIN },
                                                                       { "evaluation", PICTURES - TRAIN } };
    double things = 0;

    for (size_t c = 0; c < LT_COUNT(cases); c++) {
        const cJSON *images, *annotations, *a;
        cJSON *j;
        lt_image img;
        int id = 0;
        check_ok(lt_json_read(at(lt_arena_printf(arena, "data/annotations/instances_%s.json", cases[c].split)), &j));
        images = cJSON_GetObjectItem(j, "images");
        annotations = cJSON_GetObjectItem(j, "annotations");
        ck_assert_int_eq(cJSON_GetArraySize(images), cases[c].images);
        ck_assert_int_eq(cJSON_GetArraySize(cJSON_GetObjectItem(j, "categories")), SYNTH_CLASSES);
        check_ok(lt_image_read(arena, at(lt_arena_printf(arena, "data/%s/%s", cases[c].split,
                               cJSON_GetObjectItem(images->child, "file_name")->valuestring)), &img));
        ck_assert(img.width == SIDE && img.height == SIDE && img.channels == 3);
        cJSON_ArrayForEach(a, annotations) {
            ck_assert_int_eq((int)number(a, "id"), ++id);
            ck_assert(number(a, "image_id") >= 1 && number(a, "image_id") <= cases[c].images);
            check_annotation(a);
        }
        things += id;
        cJSON_Delete(j);
    }
    ck_assert_str_eq(figure[0].name, "things an image, mean");
    ck_assert_double_eq_tol(figure[0].value, things / PICTURES, 1e-9);
}
END_TEST

START_TEST(classes_have_the_order_of_ycb)
{
    ck_assert_str_eq(synth_class_name(0), "person");
    ck_assert_str_eq(synth_class_name(1), "hand");
    ck_assert_str_eq(synth_class_name(2), "002_master_chef_can");
    ck_assert_str_eq(synth_class_name(22), "061_foam_brick");
}
END_TEST

/* ---- figures ---- */

START_TEST(figures_of_a_few_things)
{
    const detect_sight one[] = {
        { SYNTH_HAND_THING, true, true, false, 20, 1 }, { SYNTH_HAND_THING, false, false, true, 60, 0.4 },
        { 5, false, false, false, 10, 0.7 },
    };
    detect_tally t = { .arena = arena };
    synth_figure f[DETECT_FIGURES];

    check_ok(detect_tally_add(&t, one, 3));
    check_ok(detect_tally_add(&t, NULL, 0));
    check_ok(detect_tally_figures(&t, f));
    static const double want[DETECT_FIGURES] = { 1.5, 0.5, 1, 0.5, 0.5, 20, 20, 20, 10, 10, 10, 1 / 3., 1 / 3., 1 / 3.,
                                                 0.7, 1 / 3., 1 / 3., 0 };
    for (int i = 0; i < DETECT_FIGURES; i++)
        ck_assert_msg(fabs(f[i].value - want[i]) < 1e-12, "%s: %g, want %g", f[i].name, f[i].value, want[i]);
}
END_TEST

/* ---- parts of a scene ---- */

/* A square of `size` metres before a camera that looks along z, at depth z. */
static void add_square(synth_world *w, lt_mesh *mesh, int kind, int owner, double x, double z, double size)
{
    static int32_t face[2][3] = { { 0, 1, 2 }, { 0, 2, 3 } };
    const int thing = synth_world_thing(w, &(synth_thing){ .kind = kind, .owner = owner });
    synth_instance in = { .mesh = mesh, .R_world_obj = { 1, 0, 0, 0, 1, 0, 0, 0, 1 },
                          .t_world_obj = { x, 0, z }, .material = { .albedo = { 1, 1, 1 } } };

    *mesh = (lt_mesh){ .n_vertices = 4, .n_faces = 2, .vertex = lt_arena_array(arena, 4, 12), .face = face };
    for (int i = 0; i < 4; i++) {
        mesh->vertex[i][0] = (float)(i == 1 || i == 2 ? size / 2 : -size / 2);
        mesh->vertex[i][1] = (float)(i >= 2 ? size / 2 : -size / 2);
    }
    synth_world_place(w, thing, &in);
}

/* A square hides the right half of one behind it; a third, far to the side, is cut by the border; and the first one's
 * owner is all that the first one is. */
START_TEST(what_is_seen_of_squares)
{
    static synth_world w;
    const synth_camera c = { .fx = 64, .fy = 64, .cx = 31.5, .cy = 31.5, .width = 64, .height = 64,
                             .R_cam_world = { 1, 0, 0, 0, 1, 0, 0, 0, 1 } };
    synth_frame *f = synth_frame_new(64, 64);
    synth_room *room = lt_arena_alloc(arena, sizeof(*room));
    lt_mesh mesh[4];
    synth_scene scene;
    synth_seen *s;

    w = (synth_world){ .n_things = 0 };
    add_square(&w, &mesh[0], SYNTH_PERSON_THING, -1, -0.4, 2, 0.25);    /* 8 pixels a side */
    add_square(&w, &mesh[1], SYNTH_HAND_THING, 0, 0, 2, 0.5);           /* 16 */
    add_square(&w, &mesh[2], 4, -1, 0.125, 1, 0.25);                    /* 16, 8 to the right of it */
    add_square(&w, &mesh[3], 5, -1, 1, 2, 0.25);                        /* its middle on the border */
    room->up[2] = 1;
    scene = synth_world_scene(&w, room, &c);
    check_ok(synth_render(&scene, f));
    check_ok(synth_world_look(arena, &w, &c, f, NULL, &s));
    ck_assert_int_eq((int)s[1].whole, 256);
    ck_assert_int_eq((int)s[1].visible, 128);
    ck_assert(s[1].box.x0 == 24 && s[1].box.x1 == 32 && s[1].whole_box.x1 == 40 && !s[1].cut);
    ck_assert_double_eq(synth_seen_share(&s[2]), 1);
    ck_assert_int_eq((int)s[0].whole, 64 + 256);
    ck_assert_int_eq((int)s[0].visible, 64 + 128);
    ck_assert(s[3].cut && s[3].box.x1 == 64 && !s[2].cut);
    synth_frame_free(f);
}
END_TEST

START_TEST(arms_are_as_long_as_they_are)
{
    const synth_person p = { .stature = 1.7, .girth = 1 };
    const synth_stance stance = { .facing = 0.7, .lean = 0.2, .sits = true };
    lt_rng rng = lt_rng_make(1, 2);
    synth_reach r;

    synth_person_reach(&p, &stance, &r);
    ck_assert_double_eq_tol(lt_vec3_distance(r.shoulder[0], r.shoulder[1]), 0.245 * 1.7, 1e-12);
    for (int i = 0; i < 50; i++) {
        double wrist[3], elbow[3];
        for (int k = 0; k < 3; k++)
            wrist[k] = r.shoulder[i % 2][k] + 0.3 * lt_rng_normal(&rng);
        synth_reach_elbow(&r, i % 2, lt_rng_range(&rng, 0, 1), wrist, elbow);
        ck_assert_double_eq_tol(lt_vec3_distance(r.shoulder[i % 2], elbow), r.upper, 1e-9);
        ck_assert_double_eq_tol(lt_vec3_distance(elbow, wrist), r.fore, 1e-9);
    }
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_unchecked_fixture(c, setup, close_scratch);
    tcase_set_timeout(c, 0);
    tcase_add_test(c, every_file_is_in_the_manifest);
    tcase_add_test(c, same_seed_same_bytes);
    tcase_add_test(c, near_hands_change_their_pictures_alone);
    tcase_add_test(c, the_evaluation_seed_is_for_evaluation_alone);
    tcase_add_test(c, annotations_agree_with_their_masks);
    tcase_add_test(c, classes_have_the_order_of_ycb);
    tcase_add_test(c, figures_of_a_few_things);
    tcase_add_test(c, what_is_seen_of_squares);
    tcase_add_test(c, arms_are_as_long_as_they_are);
}

int main(void)
{
    setenv("CK_FORK", "no", 1);         /* the threads that parallel loops leave do not survive a fork */
    return run_suite("detect", add_tests);
}
