/* SPDX-License-Identifier: Apache-2.0 */
/* COCO's instances and YOLO's text files: what is read, and what is said of files that are none. */
#include "data/detection/detection.h"
#include "libtensor/io/image/image.h"
#include "tests/suite.h"

#include <math.h>
#include <unistd.h>

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

static void put_text(const char *name, const char *text)
{
    put_file(in_folder(name), text, strlen(text));
}

static void folder(const char *name)
{
    ck_assert_int_eq(mkdir(in_folder(name), 0777), 0);
}

static void put_picture(const char *name, int width, int height)
{
    lt_image img;

    check_ok(lt_image_init(arena, width, height, 3, 8, &img));
    check_ok(lt_png_write(in_folder(name), &img));
}

static int pixels(const detection_object *o, int width, int height)
{
    uint8_t *mask = lt_arena_alloc(arena, (size_t)width * (size_t)height);
    int n = 0;

    check_ok(detection_mask(o, width, height, mask));
    for (int i = 0; i < width * height; i++)
        n += mask[i];
    return n;
}

/* ---- COCO ---- */

#define IMAGES "\"images\": [{\"id\": 7, \"file_name\": \"b.png\", \"width\": 4, \"height\": 3}, " \
    "{\"id\": 5, \"file_name\": \"gone.png\", \"width\": 4, \"height\": 3}]"
#define CATEGORIES "\"categories\": [{\"id\": 9, \"name\": \"cup\"}, {\"id\": 2, \"name\": \"hand\"}]"
#define FILE_OF(annotations) "{" IMAGES ", \"annotations\": [" annotations "], " CATEGORIES "}"

static lt_status open_coco(const char *text, detection_set **out)
{
    put_text("annotations/instances_train.json", text);
    return detection_open(arena, scratch_folder, "train", out);
}

static void make_coco(void)
{
    folder("annotations");
    folder("train");
    put_picture("train/b.png", 4, 3);
}

START_TEST(coco)
{
    detection_set *s;
    detection_sample sample;

    make_coco();
    check_ok(open_coco(FILE_OF(
        "{\"image_id\": 7, \"category_id\": 9, \"bbox\": [1, 0, 2, 2], \"area\": 3, \"iscrowd\": 0, "
        "\"segmentation\": [[1, 0, 3, 0, 3, 2, 1, 2]]},"
        "{\"image_id\": 7, \"category_id\": 2, \"bbox\": [0, 0, 9, 9], \"iscrowd\": 1, "
        "\"segmentation\": {\"size\": [3, 4], \"counts\": [4, 3, 5]}},"
        "{\"image_id\": 7, \"category_id\": 2, \"bbox\": [0, 1, 2, 1], "
        "\"segmentation\": {\"size\": [3, 4], \"counts\": \"435\"}},"
        "{\"image_id\": 5, \"category_id\": 2, \"bbox\": [0, 1, 2, 1]},"
        "{\"image_id\": 7, \"category_id\": 2, \"bbox\": [4, 0, 2, 2]}"), &s));
    ck_assert_int_eq(s->count, 1);
    ck_assert_int_eq(s->missing, 1);
    ck_assert_int_eq(s->dropped, 1);
    ck_assert_int_eq(s->classes, 2);
    ck_assert_str_eq(s->class_name[0], "hand");
    ck_assert_int_eq(s->class_id[1], 9);
    ck_assert_ptr_nonnull(strstr(s->first_fault, "annotations[4].bbox: nothing of it is inside \"b.png\""));
    ck_assert_int_eq(s->seed, -1);
    check_ok(detection_read(s, 0, arena, &sample));
    ck_assert_int_eq(sample.n, 3);
    ck_assert_int_eq(sample.object[0].cls, 1);
    ck_assert_int_eq(pixels(&sample.object[0], 4, 3), 4);
    ck_assert(sample.object[1].crowd);
    ck_assert_float_eq(sample.object[1].box[2], 4);
    ck_assert_int_eq(pixels(&sample.object[1], 4, 3), 3);
    ck_assert_int_eq(pixels(&sample.object[2], 4, 3), 3);
    ck_assert_double_eq(sample.object[0].area, 3);
}
END_TEST

/* By info.synthetic of the file itself; a manifest beside it says so too, but never that it is not. */
START_TEST(coco_that_is_synthetic)
{
    static const char *const info[] = { "{\"synthetic\": true}", "{\"synthetic\": 1}", "\"synthetic\"", "[]", "null" };
    detection_set *s;

    make_coco();
    for (size_t i = 0; i < LT_COUNT(info); i++) {
        check_ok(open_coco(lt_arena_printf(arena, "{\"info\": %s, " IMAGES ", \"annotations\": [], " CATEGORIES "}",
                                           info[i]), &s));
        ck_assert(s->synthetic == (i == 0));
    }
    put_text("manifest.json", "{\"synthetic\": true, \"preset\": \"detect\", \"seed\": \"5\"}");
    check_ok(open_coco(FILE_OF(""), &s));
    ck_assert(s->synthetic && s->seed == 5);
}
END_TEST

static const struct { const char *text, *reason; } bad_coco[] = {
    { "[]", "want the lists images, annotations and categories" },
    { "{\"images\": [], \"annotations\": [], \"categories\": []}", "categories: there are none" },
    { FILE_OF("{\"image_id\": 8, \"category_id\": 2, \"bbox\": [0, 0, 1, 1]}"),
      "annotations[0]: no image has the id 8" },
    { FILE_OF("{\"image_id\": 7, \"category_id\": 3, \"bbox\": [0, 0, 1, 1]}"),
      "annotations[0]: no category has the id 3" },
    { FILE_OF("{\"image_id\": 7, \"category_id\": 2, \"bbox\": [0, 0, 1]}"),
      "annotations[0].bbox: want x, y, width, height" },
    { FILE_OF("{\"image_id\": 7.5, \"category_id\": 2}"), "annotations[0]: image_id, category_id: want whole numbers" },
    { FILE_OF("{\"image_id\": 7, \"category_id\": 2, \"bbox\": [0, 0, 1, 1], \"segmentation\": [[1, 2, 3, 4]]}"),
      "annotations[0].segmentation[0]: want x y of three corners and more" },
    { FILE_OF("{\"image_id\": 7, \"category_id\": 2, \"bbox\": [0, 0, 1, 1], \"segmentation\": "
              "{\"size\": [3, 5], \"counts\": \"435\"}}"), "annotations[0].segmentation.size: want [3, 4]" },
    { FILE_OF("{\"image_id\": 7, \"category_id\": 2, \"bbox\": [0, 0, 1, 1], \"segmentation\": "
              "{\"size\": [3, 4], \"counts\": [4, 3]}}"), "annotations[0].segmentation.counts: want runs" },
    { "{\"images\": [{\"id\": 1, \"file_name\": \"../b.png\"}], \"annotations\": [], " CATEGORIES "}",
      "images[0].file_name: want the name of a file" },
    { "{\"images\": [{\"id\": 1, \"file_name\": \"b.png\", \"width\": 0, \"height\": 3}], \"annotations\": [], "
      CATEGORIES "}", "width and height: want whole numbers" },
    { "{\"images\": [{\"id\": 1, \"file_name\": \"b.png\", \"width\": 4, \"height\": 3}, {\"id\": 1, \"file_name\": "
      "\"b.png\", \"width\": 4, \"height\": 3}], \"annotations\": [], " CATEGORIES "}",
      "images: the id 1 is there twice" },
    { "{\"images\": [{\"id\": 1, \"file_name\": \"a.png\", \"width\": 4, \"height\": 3}], \"annotations\": [], "
      CATEGORIES "}", "no image of \"train\" can be used; the first: " },
};

START_TEST(coco_that_is_none)
{
    detection_set *s;
    lt_status st;

    make_coco();
    st = open_coco(bad_coco[_i].text, &s);
    ck_assert_int_eq(st, LT_EFORMAT);
    check_error(st, LT_EFORMAT, bad_coco[_i].reason);
    ck_assert_ptr_null(strchr(lt_last_error(), '\n'));
}
END_TEST

START_TEST(another_size)
{
    detection_set *s;
    detection_sample sample;

    make_coco();
    put_picture("train/b.png", 5, 3);
    check_ok(open_coco(FILE_OF(""), &s));
    check_error(detection_read(s, 0, arena, &sample), LT_EFORMAT, "has 5 x 3 pixels");
    check_error(detection_open(arena, in_folder("train"), "train", &s), LT_EIO, "no annotations/instances_train.json");
}
END_TEST

/* ---- YOLO ---- */

static void make_yolo(const char *yaml)
{
    folder("images");
    folder("images/a");
    folder("labels");
    folder("labels/a");
    put_text("data.yaml", yaml);
    put_picture("images/a/one.png", 10, 8);
    put_picture("images/a/two.png", 10, 8);
    put_picture("images/a/three.png", 10, 8);
    put_text("labels/a/one.txt", "1 0.5 0.5 0.4 0.5\n0 0.1 0.125 0.5 0.125 0.5 0.625 0.1 0.625\n1 0.5 0.5 0.4 0.5\n\n");
    put_text("labels/a/three.txt", "2 0.5 0.5 0.4 0.5\n");
}

START_TEST(yolo)
{
    detection_set *s;
    detection_sample sample;

    make_yolo("train: images/a\nval: ../images/a\nnc: 2\nnames:\n  0: hand\n  1: cup\ndownload: rm -r /\n");
    check_ok(detection_open(arena, scratch_folder, "train", &s));
    ck_assert_str_eq(s->title, "YOLO");
    ck_assert_int_eq(s->count, 2);
    ck_assert_int_eq(s->corrupt, 1);
    ck_assert_int_eq(s->dropped, 1);
    ck_assert_int_eq(s->empty, 1);
    ck_assert_str_eq(s->class_name[1], "cup");
    ck_assert_ptr_nonnull(strstr(s->first_fault, "labels/a/three.txt:1: class 2, want a whole number from 0 to 1"));
    check_ok(detection_read(s, 0, arena, &sample));
    ck_assert_int_eq(sample.n, 2);
    ck_assert_float_eq_tol(sample.object[0].box[0], 3, 1e-5f);
    ck_assert_float_eq_tol(sample.object[0].box[3], 6, 1e-5f);
    ck_assert_int_eq(sample.object[0].mask, DETECTION_NO_MASK);
    ck_assert_float_eq_tol(sample.object[1].box[2], 5, 1e-5f);
    ck_assert_int_eq(pixels(&sample.object[0], 10, 8), 16);
    ck_assert_int_eq(pixels(&sample.object[1], 10, 8), 5 * 5);      /* 4 x 4, and where the edges pass */
    check_ok(detection_open(arena, in_folder("data.yaml"), "evaluation", &s));
    ck_assert_int_eq(s->count, 2);
}
END_TEST

static const struct { const char *yaml, *labels; lt_status status; const char *reason; } bad_yolo[] = {
    { "train: images/a\nnc: 3\nnames: [a, b]\n", NULL, LT_EFORMAT, "data.yaml:2: nc is 3, but there are 2 names" },
    { "train: images/b\nnames: [a, b]\n", NULL, LT_EIO, "images/b: no such folder or file" },
    { "val: images/a\nnames: [a, b]\n", NULL, LT_EFORMAT, "train: is not there" },
    { "train: images/a\n", NULL, LT_EFORMAT, "names: want a list" },
    { "train: images/a\nnames:\n  1: a\n  1: b\n", NULL, LT_EFORMAT, "comes twice" },
    { "train: images/a/one.png\nnames: [a]\n", NULL, LT_EFORMAT, "no image of \"train\"" },
    { "", "0 0.5 0.5 0.4\n", LT_EFORMAT, "one.txt:1: 4 numbers, want 5 of a box" },
    { "", "0 0.5 0.5 0.4 0.2 0.9\n", LT_EFORMAT, "one.txt:1: 6 numbers: results with a score, not labels" },
    { "", "0 0.5 0.5 0.4 0.5\n0 5 5 4 2\n", LT_EFORMAT, "one.txt:2: 5, want shares of width and height from 0 to 1, "
      "not pixels" },
    { "", "0 0.5 0.5 nan 0.2\n", LT_EFORMAT, "one.txt:1: \"nan 0.2\" is no number" },
    { "", "0.5 0.5 0.5 0.4 0.2\n", LT_EFORMAT, "one.txt:1: class 0.5, want a whole number from 0 to 0" },
};

START_TEST(yolo_that_is_none)
{
    const char *yaml = bad_yolo[_i].yaml, *labels = bad_yolo[_i].labels;
    detection_set *s;

    make_yolo(labels ? "train: list.txt\nnames: [a]\n" : yaml);
    put_text("list.txt", "./images/a/one.png\n");
    if (labels)
        put_text("labels/a/one.txt", labels);
    check_error(detection_open(arena, scratch_folder, "train", &s), bad_yolo[_i].status, bad_yolo[_i].reason);
    ck_assert_ptr_null(strchr(lt_last_error(), '\n'));
}
END_TEST

/* Two triangles that share a corner, one of them beyond the picture */
START_TEST(polygons)
{
    static const float point[] = { 0, 0, 4, 0, 0, 4, 4, 4, 40, 4, 4, 40 };
    static const int corners[] = { 3, 3 };
    const detection_object o = { .mask = DETECTION_POLYGONS, .point = point, .corners = corners, .n_polygons = 2 };
    uint8_t mask[64];

    check_ok(detection_mask(&o, 8, 8, mask));
    for (int i = 0; i < 64; i++) {
        const double x = i % 8 + 0.5, y = i / 8 + 0.5;

        if (fabs(x + y - 4) > 1e-9)
            ck_assert_int_eq(mask[i], x + y < 4 || (x > 4 && y > 4));
    }
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, setup, teardown);
    tcase_add_test(tc, coco);
    tcase_add_test(tc, coco_that_is_synthetic);
    tcase_add_loop_test(tc, coco_that_is_none, 0, (int)LT_COUNT(bad_coco));
    tcase_add_test(tc, another_size);
    tcase_add_test(tc, yolo);
    tcase_add_loop_test(tc, yolo_that_is_none, 0, (int)LT_COUNT(bad_yolo));
    tcase_add_test(tc, polygons);
}

int main(void)
{
    return run_suite("detection", add_tests);
}
