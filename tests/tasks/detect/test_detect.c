/* SPDX-License-Identifier: Apache-2.0 */
/* Training a detector on a few drawn pictures: it learns, and the bits do not depend on threads or stops. */
#include "estimate/detection/detector.h"
#include "libtensor/base/parallel.h"
#include "libtensor/base/rng.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "tasks/detect/evaluate.h"
#include "tasks/detect/task.h"
#include "tests/scratch.h"
#include "train/trainer.h"

#include <signal.h>

static const task *const tasks[] = { &detect_task, NULL };

/* ---- a dataset: a bright square and a dark bar on grey, by class ---- */

enum { PICTURES = 6, SIDE = 64 };

static void draw(lt_image *img, const int box[4], int value)
{
    for (int y = box[1]; y < box[3]; y++)
        memset(img->data + (size_t)(y * SIDE + box[0]) * 3, value, (size_t)(box[2] - box[0]) * 3);
}

static void put_split(const char *split)
{
    FILE *f = fopen(at(lt_arena_printf(arena, "data/annotations/instances_%s.json", split)), "w");
    lt_rng r = lt_rng_make(1, 0);

    fprintf(f, "{\"categories\": [{\"id\": 1, \"name\": \"hand\"}, {\"id\": 2, \"name\": \"bar\"}], \"images\": [");
    for (int i = 0; i < PICTURES; i++)
        fprintf(f, "%s{\"id\": %d, \"file_name\": \"%d.png\", \"width\": 64, \"height\": 64}", i ? ", " : "", i, i);
    fprintf(f, "], \"annotations\": [");
    for (int i = 0; i < PICTURES; i++) {
        const int x = (int)lt_rng_below(&r, 30), y = (int)lt_rng_below(&r, 12);
        const int box[2][4] = { { x, y, x + 24, y + 24 }, { x, 44, x + 32, 56 } };
        lt_image img;

        check_ok(lt_image_init(arena, SIDE, SIDE, 3, 8, &img));
        memset(img.data, 120, (size_t)SIDE * SIDE * 3);
        for (int k = 0; k < 2; k++) {
            const int *b = box[k];

            draw(&img, b, k ? 20 : 240);
            fprintf(f, "%s{\"image_id\": %d, \"category_id\": %d, \"bbox\": [%d, %d, %d, %d], \"segmentation\": "
                    "[[%d, %d, %d, %d, %d, %d, %d, %d]]}", i + k ? ", " : "", i, k + 1, b[0], b[1], b[2] - b[0],
                    b[3] - b[1], b[0], b[1], b[2], b[1], b[2], b[3], b[0], b[3]);
        }
        check_ok(lt_png_write(at(lt_arena_printf(arena, "data/%s/%d.png", split, i)), &img));
    }
    fprintf(f, "]}\n");
    fclose(f);
}

static void setup(void)
{
    static const char config[] = "{ \"model\": { \"name\": \"csp_seg\", \"image_size\": 64, \"classes\": 2 }, "
        "\"optim\": { \"kind\": \"adamw\", \"lr\": 2e-3, \"schedule\": \"constant\", \"batch\": 4, "
        "\"shards\": 2, \"epochs\": 2, \"ema_decay\": 0.999 }, \"train\": { \"checkpoint_minutes\": 0, "
        "\"validate_every\": 0 }, \"data\": { \"optimizer\": \"given\" } }";

    open_scratch();
    check_ok(lt_make_dirs(at("data/annotations")));
    check_ok(lt_make_dirs(at("data/train")));
    check_ok(lt_make_dirs(at("data/evaluation")));
    put_split("train");
    put_split("evaluation");
    check_ok(lt_write_file(at("n.json"), config, sizeof(config) - 1));
}

static const char *dir_key(void)
{
    return lt_arena_printf(arena, "data.dir=%s/data", scratch_folder);
}

static lt_status train(const char *out, const char *const *more, int n_more, const char *resume,
                       void (*before_step)(void *, int64_t, lt_params *))
{
    const char *set[8] = { dir_key() };
    train_options o = { .tasks = tasks, .config = resume ? NULL : at("n.json"), .out = at(out), .quiet = true,
                        .resume = resume, .before_step = before_step, .set = set, .n_set = resume ? 0 : 1 + n_more };

    for (int i = 0; i < n_more; i++)
        set[1 + i] = more[i];
    return train_run(&o, NULL);
}

START_TEST(threads_do_not_matter)
{
    for (int threads = 1; threads <= 3; threads++) {
        const char *out = lt_arena_printf(arena, "threads%d", threads);

        lt_set_threads(threads);
        check_ok(train(out, NULL, 0, NULL, NULL));
        same_end("threads1", out);
    }
}
END_TEST

static void stop_at_second(void *ctx, int64_t step, lt_params *params)
{
    (void)ctx, (void)params;
    if (step == 2)
        raise(SIGTERM);
}

START_TEST(stops_do_not_matter)
{
    check_ok(train("whole", NULL, 0, NULL, NULL));
    ck_assert_int_eq(train("stopped", NULL, 0, NULL, stop_at_second), LT_ESTOPPED);
    check_ok(train("stopped", NULL, 0, "", NULL));
    same_end("whole", "stopped");
}
END_TEST

/* The run as a detector: it knows what its classes are called, and sees one of each in a picture. */
static void check_finds(const char *run)
{
    detection_set *set;
    detection_sample sample;
    detect_found *found;
    detector d;
    int n;

    check_ok(detector_open(at(run), &d));
    ck_assert_int_eq(d.n, 2);
    ck_assert_str_eq(d.name[0], "hand");
    ck_assert_str_eq(d.name[1], "bar");
    check_ok(detection_open(arena, at("data"), "train", &set));
    check_ok(detection_read(set, 0, arena, &sample));
    check_ok(detector_run(&d, sample.rgb.data, SIDE, SIDE, &detection_rules_shown, arena, &found, &n));
    ck_assert_int_eq(n, 2);
    for (int i = 0; i < n; i++) {
        const float *truth = sample.object[found[i].cls].box;

        ck_assert_int_eq(sample.object[found[i].cls].cls, found[i].cls);
        for (int k = 0; k < 4; k++)
            ck_assert_float_eq_tol(found[i].box[k], truth[k], 4);
    }
    detector_close(&d);
}

/* Pictures that it has seen, after a hundred steps: nearly all boxes and masks are found. */
START_TEST(it_learns)
{
    static const char *const more[] = { "optim.epochs=100", "optim.shards=1", "optim.ema_decay=0", "data.mosaic=0",
                                        "data.scale=0.1", "train.validate_every=100" };
    char *text;
    const char *last = NULL, *box, *mask;
    size_t n;

    check_ok(train("learns", more, LT_COUNT(more), NULL, NULL));
    check_ok(lt_read_file(arena, at("learns/log.jsonl"), LT_FILE_MAX, (uint8_t **)&text, &n));
    for (const char *p = strstr(text, "\"map50_box\""); p; p = strstr(p + 1, "\"map50_box\""))
        last = p;
    ck_assert_ptr_nonnull(last);
    box = strchr(last, ':') + 1;
    mask = strchr(strstr(last, "\"map50_mask\""), ':') + 1;
    ck_assert_msg(strtod(box, NULL) > 0.9 && strtod(mask, NULL) > 0.9, "%.200s", last);
    check_finds("learns");
}
END_TEST

START_TEST(refused)
{
    static const char *const five[] = { "model.classes=5" };
    static const char manifest[] = "{\"synthetic\": true, \"preset\": \"detect\", \"seed\": \"1000\"}";

    check_error(train("a", five, 1, NULL, NULL), LT_EINVAL, "model.classes: 5, but ");
    check_ok(lt_write_file(at("data/manifest.json"), manifest, sizeof(manifest) - 1));
    check_error(train("b", NULL, 0, NULL, NULL), LT_EINVAL, "is the set that detectors are compared on (seed 1000)");
}
END_TEST

/* ---- a file of results ---- */

START_TEST(results)
{
    static const char text[] = "[{\"image_id\": 0, \"category_id\": 1, \"bbox\": [0, 0, 64, 64], \"score\": 0.5}]";
    const detect_evaluation e = { .data = at("data"), .split = "evaluation", .pred = at("pred.json") };
    detect_scores s;

    check_ok(lt_write_file(at("pred.json"), text, sizeof(text) - 1));
    check_ok(detect_evaluate(&e, &s));
    ck_assert_double_eq(s.value[1], 0);
    ck_assert_int_eq(s.images, PICTURES);
    check_ok(lt_write_file(at("pred.json"), "[{\"image_id\": 9}]", 17));
    check_error(detect_evaluate(&e, &s), LT_EFORMAT, "[0]: want numbers image_id, category_id and score");
    check_ok(lt_write_file(at("pred.json"), "{}", 2));
    check_error(detect_evaluate(&e, &s), LT_EFORMAT, "want a list of results");
}
END_TEST

static const char *text_of(const char *name)
{
    uint8_t *bytes;
    size_t n;

    check_ok(lt_read_file(arena, at(name), LT_FILE_MAX, &bytes, &n));
    return (const char *)bytes;
}

/* A hand that is right, one taken for a bar, a bar where nothing is; what is not sure does not count. */
START_TEST(breakdown)
{
    const detect_evaluation e = { .data = at("data"), .split = "evaluation", .pred = at("pred.json"),
                                  .folder = at("left") };
    detection_set *set;
    const float *a, *b;
    detect_scores s;
    const char *text;

    check_ok(detection_open(arena, at("data"), "evaluation", &set));
    a = set->image[0].object[0].box;
    b = set->image[1].object[0].box;
    text = lt_arena_printf(arena, "[{\"image_id\": 0, \"category_id\": 1, \"bbox\": [%g, %g, 24, 24], \"score\": 0.9},"
                           "{\"image_id\": 0, \"category_id\": 1, \"bbox\": [%g, %g, 24, 24], \"score\": 0.2},"
                           "{\"image_id\": 1, \"category_id\": 2, \"bbox\": [%g, %g, 24, 24], \"score\": 0.8},"
                           "{\"image_id\": 1, \"category_id\": 2, \"bbox\": [0, 0, 2, 2], \"score\": 0.7}]",
                           (double)a[0], (double)a[1], (double)a[0], (double)a[1], (double)b[0], (double)b[1]);
    check_ok(lt_write_file(at("pred.json"), text, strlen(text)));
    check_ok(detect_evaluate(&e, &s));
    ck_assert_str_eq(text_of("left/confusion.csv"), "truth,\"hand\",\"bar\",\"missed\"\n\"hand\",1,1,4\n\"bar\",0,0,6\n"
                     "\"nothing\",0,1,0\n");
    text = text_of("left/per-image.csv");
    ck_assert_ptr_nonnull(strstr(text, "\n\"0.png\",1,1,0,1,0\n\"1.png\",3,0,1,1,1\n\"2.png\",2,0,0,2,0\n"));
    ck_assert_ptr_nonnull(strstr(text_of("left/table.md"), "| hand | 0.168 | 0.168 | 0.168 |"));        /* 17 of 101 */
    ck_assert_ptr_nonnull(strstr(text_of("left/curves.json"), "\"hands\""));
    ck_assert(exists(at("left/pictures.png")) && exists(at("left/scores.json")));
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 300);
    tcase_add_checked_fixture(tc, setup, close_scratch);
    tcase_add_test(tc, threads_do_not_matter);
    tcase_add_test(tc, stops_do_not_matter);
    tcase_add_test(tc, it_learns);
    tcase_add_test(tc, refused);
    tcase_add_test(tc, results);
    tcase_add_test(tc, breakdown);
}

int main(void)
{
    return run_suite("detect", add_tests);
}
