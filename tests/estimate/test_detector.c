/* SPDX-License-Identifier: Apache-2.0 */
/* Detectors opened from weights, what their classes are called, and files that are none. */
#include "estimate/detection/detector.h"

#include "estimate/detection/class_names.h"
#include "libtensor/io/file.h"
#include "tests/estimate/class_names_vectors.h"
#include "tests/estimate/drawn_detector.h"
#include "tests/suite.h"

enum { WIDTH = 90, HEIGHT = 60 };

static lt_arena *arena;

static const char *in(const char *name)
{
    return lt_path_join(arena, scratch_folder, name);
}

static const char *saved_names(const void *bytes, size_t n)
{
    const char *names;

    put_file(in("names.pt"), bytes, n);
    check_ok(class_names_saved(arena, in("names.pt"), &names));
    return names;
}

START_TEST(names)
{
    const char **name = class_names_of(arena, "left_hand,cup", 2);

    ck_assert_str_eq(name[0], "left_hand");
    ck_assert_str_eq(name[1], "cup");
    ck_assert_str_eq(class_names_of(arena, "a,b", 3)[2], "class 2");
    ck_assert_str_eq(class_names_of(arena, NULL, 1)[0], "class 0");
    name = class_names_of(arena, "", 80);
    ck_assert_str_eq(name[0], "person");
    ck_assert_str_eq(name[41], "cup");
    ck_assert_str_eq(name[79], "toothbrush");
    name = class_names_of(arena, "", 23);
    ck_assert_str_eq(name[0], "person");
    ck_assert_str_eq(name[1], "hand");
    ck_assert_str_eq(name[2], "002_master_chef_can");
    ck_assert_str_eq(name[22], "061_foam_brick");
    ck_assert_str_eq(class_names_join(arena, (const char *const[]){ "hand", "cup, or mug", NULL }, 3),
                     "hand,cup; or mug,");
    ck_assert_str_eq(saved_names(names_by_number, sizeof(names_by_number)), "person,hand,cup; or mug");
    ck_assert_str_eq(saved_names(names_in_order, sizeof(names_in_order)), "left_hand,right_hand");
    ck_assert_ptr_null(saved_names(names_none, sizeof(names_none)));
}
END_TEST

/* A class that every cell sees: its boxes lie in the picture, the surest first. */
START_TEST(finds)
{
    static uint8_t rgb[3 * WIDTH * HEIGHT];
    detect_found *found;
    detector d;
    int n;

    write_detector(in("d.safetensors"), 3, 1);
    check_ok(detector_open(in("d.safetensors"), &d));
    ck_assert_int_eq(d.n, 3);
    ck_assert_str_eq(d.name[1], "class 1");
    check_ok(detector_run(&d, rgb, WIDTH, HEIGHT, &detection_rules_shown, arena, &found, &n));
    ck_assert_int_gt(n, 0);
    for (int i = 0; i < n; i++) {
        const float *b = found[i].box;

        ck_assert_int_eq(found[i].cls, 1);
        ck_assert_double_eq_tol(found[i].score, 0.8808, 1e-3);
        ck_assert(b[0] >= 0 && b[1] >= 0 && b[2] <= WIDTH && b[3] <= HEIGHT);
    }
    detector_close(&d);
    write_detector(in("none.safetensors"), 3, -1);
    check_ok(detector_open(in("none.safetensors"), &d));
    check_ok(detector_run(&d, rgb, WIDTH, HEIGHT, &detection_rules_shown, arena, &found, &n));
    ck_assert_int_eq(n, 0);
    lt_params_first(d.t.params)->data[0] = NAN;
    lt_params_changed(d.t.params);
    check_error(detector_run(&d, rgb, WIDTH, HEIGHT, &detection_rules_shown, arena, &found, &n), LT_ENUMERIC,
                "its weights are damaged");
    detector_close(&d);
}
END_TEST

static void expect_none(const char *name, lt_status st, const char *reason)
{
    detector d;

    check_error(detector_open(in(name), &d), st, reason);
    detector_close(&d);
}

START_TEST(no_detector)
{
    float three[3] = { 0 };
    const int64_t shape[] = { 3 };
    lt_named_array list[] = { { "conv1.bias", lt_array_make(LT_ELEM_F4, 1, shape, three) } };

    expect_none("nowhere.pt", LT_EIO, "nowhere.pt");
    put_file(in("text.pt"), "no weights", 10);
    expect_none("text.pt", LT_EFORMAT, "text.pt");
    put_file(in("names.pt"), names_by_number, sizeof(names_by_number));
    expect_none("names.pt", LT_EINVAL, "no weights of a detector: want a run of csp_seg, or YOLOv8n-seg's");
    check_ok(lt_safetensors_write(in("other.safetensors"), list, 1, NULL, 0));
    expect_none("other.safetensors", LT_EINVAL, "no weights of a detector");
    list[0].name = "model.22.cv3.0.2.bias";
    check_ok(lt_safetensors_write(in("part.safetensors"), list, 1, NULL, 0));
    expect_none("part.safetensors", LT_EINVAL,
                "of the detector's parameters, the first of them backbone.0.conv.weight");
}
END_TEST

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

static void add_tests(TCase *t)
{
    tcase_set_timeout(t, 60);
    tcase_add_checked_fixture(t, setup, teardown);
    tcase_add_test(t, names);
    tcase_add_test(t, finds);
    tcase_add_test(t, no_detector);
}

int main(void)
{
    return run_suite("detector", add_tests);
}
