/* SPDX-License-Identifier: Apache-2.0 */
/* HOGS on the trainer, from the generator's pictures: the same bits on any number of threads and after any stop, also
 * where Gaussians are added and taken out; and what is wrong with data is said. */
#include "libtensor/base/parallel.h"
#include "libtensor/io/array/safetensors.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "libtensor/io/image/write.h"
#include "libtensor/io/text/json.h"
#include "synth/generate.h"
#include "tasks/hogs/task.h"
#include "tests/scratch.h"
#include "train/trainer.h"

#include <cjson/cJSON.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

enum { SEQUENCES = 32, SKIN = 150, ITERATIONS = 150 };      /* steps of stage 0, and of stage 1 */
enum { CONTROL = SKIN + 100 };                              /* density control is before the step behind it */

static const task *const tasks[] = { &hogs_task, NULL };

static void setup(void)
{
    static const char config[] = "{ \"model\": { \"name\": \"hogs\", \"size\": \"cpu\", \"gaussians\": 200 }, "
        "\"data\": { \"iterations\": 150, \"pose_epochs\": 1 }, \"optim\": { \"batch\": 1 }, "
        "\"train\": { \"validate_every\": 0, \"checkpoint_minutes\": 0, \"log_every\": 1 } }";
    synth_options o = { .preset = SYNTH_HOGS, .seed = 5, .frames = SEQUENCES };

    open_scratch();
    o.out = at("data");
    check_ok(synth_generate(&o, NULL, NULL));
    check_ok(lt_write_file(at("hogs.json"), config, sizeof(config) - 1));
}

static bool is_file(const char *path)
{
    return access(path, R_OK) == 0;
}

static const char *const *set_of(const char *more)
{
    const char **set = lt_arena_array(arena, 2, sizeof(*set));

    set[0] = lt_arena_printf(arena, "data.dir=%s", at("data"));
    set[1] = more;
    return set;
}

static train_options options(const char *out, const char *more)
{
    return (train_options){ .tasks = tasks, .config = at("hogs.json"), .set = set_of(more), .n_set = more ? 2 : 1,
                            .out = at(out), .quiet = true };
}

static int sum_of(const char *run, const char *key)
{
    uint8_t *text;
    size_t n;
    char *line, *rest;
    int sum = 0;

    check_ok(lt_read_file(arena, at(lt_arena_printf(arena, "%s/log.jsonl", run)), LT_FILE_MAX, &text, &n));
    rest = lt_arena_printf(arena, "%.*s", (int)n, (const char *)text);
    while ((line = strsep(&rest, "\n")) && *line) {
        cJSON *o = cJSON_Parse(line);

        ck_assert_ptr_nonnull(o);
        sum += cJSON_IsNumber(cJSON_GetObjectItem(o, key)) ? cJSON_GetObjectItem(o, key)->valueint : 0;
        cJSON_Delete(o);
    }
    return sum;
}

static void raise_at(void *ctx, int64_t step, lt_params *params)
{
    (void)params;
    if (step == *(const int64_t *)ctx)
        raise(SIGTERM);
}

/* On one and two threads; and on three, stopped before and behind density control, and where stages begin */
START_TEST(same_bits)
{
    static const int64_t stops[] = { 60, SKIN + 10, SKIN + 30, CONTROL, CONTROL + 1, SKIN + ITERATIONS };
    train_options o = options("threads1", NULL);
    int64_t stop;

    lt_set_threads(1);
    check_ok(train_run(&o, NULL));
    ck_assert_int_gt(sum_of("threads1", "densified"), 0);
    ck_assert_int_gt(sum_of("threads1", "gaussians"), 0);
    o = options("threads2", NULL);
    lt_set_threads(2);
    check_ok(train_run(&o, NULL));
    same_end("threads1", "threads2");
    lt_set_threads(3);
    o = options("stopped", NULL);
    o.before_step = raise_at;
    o.ctx = &stop;
    for (size_t i = 0; i < LT_COUNT(stops); i++) {
        stop = stops[i];
        ck_assert_int_eq(train_run(&o, NULL), LT_ESTOPPED);
        o.config = NULL;
        o.set = NULL;
        o.n_set = 0;
        o.resume = "";
    }
    stop = -1;
    check_ok(train_run(&o, NULL));
    same_end("threads1", "stopped");
}
END_TEST

/* ---- the trained model ----------------------------------------------------------------------------------- */

static void score(const char *run, const char *folder, int meshes, cJSON **scores)
{
    train_config c;
    const task_evaluation e = { .arena = arena, .config = &c, .checkpoint = last_of(run), .split = "evaluation",
                                .folder = at(folder), .limit = 4, .meshes = meshes };

    check_ok(train_config_load(arena, tasks, at(lt_arena_printf(arena, "%s/config.json", run)), NULL, 0, &c));
    check_ok(lt_make_dirs(e.folder));
    check_ok(hogs_task.evaluate(&e, scores));
    train_config_fini(&c);
}

static double value(const cJSON *o, const char *row, const char *key)
{
    const cJSON *x = cJSON_GetObjectItem(cJSON_GetObjectItem(cJSON_GetObjectItem(o, "rows"), row), key);

    ck_assert_msg(cJSON_IsNumber(x), "no %s of %s", key, row);
    return x->valuedouble;
}

static lt_status export_to(const char *file, const char *format, const char *set, int64_t frame)
{
    train_config c;
    lt_status st;

    check_ok(train_config_load(arena, tasks, at("drawn/config.json"), NULL, 0, &c));
    st = hogs_task.export(&(task_export){ .arena = arena, .config = &c, .checkpoint = last_of("drawn"), .frame = &frame,
                                          .n_frames = 1, .file = at(file), .format = format, .set = set });
    train_config_fini(&c);
    return st;
}

/* Surfaces of three frames in one file; how they move is tested where GLB is. At a level that a young model reaches. */
static void animated(void)
{
    static const int64_t frame[] = { 0, 1, 2 };
    train_config c;
    uint8_t *bytes;
    size_t n;
    cJSON *root;

    check_ok(train_config_load(arena, tasks, at("drawn/config.json"), NULL, 0, &c));
    check_ok(hogs_task.export(&(task_export){ .arena = arena, .config = &c, .checkpoint = last_of("drawn"),
                                              .frame = frame, .n_frames = 3, .file = at("moves.glb"), .format = "glb",
                                              .rule = LT_OPACITY_MEAN, .iso = 0.05, .animated = true }));
    train_config_fini(&c);
    check_ok(lt_read_file(arena, at("moves.glb"), LT_FILE_MAX, &bytes, &n));
    ck_assert(n > 20 && memcmp(bytes, "glTF", 4) == 0);
    root = cJSON_ParseWithLength((const char *)bytes + 20, n - 20);
    ck_assert_int_eq(cJSON_GetArraySize(cJSON_GetObjectItem(root, "animations")), 1);
    cJSON_Delete(root);
}

/* Gaussians of a frame and of a set in each format; frames and sets that there are not */
static void exported(void)
{
    check_ok(export_to("frame.ply", "ply", NULL, 1));
    check_ok(export_to("frame.splat", "splat", NULL, 0));
    check_ok(export_to("hand.glb", "glb", "hand-00", 0));
    ck_assert(is_file(at("frame.ply")) && is_file(at("frame.splat")) && is_file(at("hand.glb")));
    check_error(export_to("x.ply", "ply", NULL, 8), LT_EINVAL, "has 8 with poses, counted from 0");
    check_error(export_to("x.ply", "ply", "hand-77", 0), LT_EINVAL, "no set \"hand-77\"; it has hand-0");
}

/* All rows and keys are there, twice the same; initial poses are scored as the generator measured them. */
START_TEST(scored_and_drawn)
{
    static const char *const keys[] = { "psnr_db", "ssim", "lpips_raw01", "lpips_sym", "psnr_fg_db", "oce_mm", "mce_mm",
                                        "adds_mm", "penetration_mm", "intersection_cm3", "contact_share" };
    const train_options o = options("drawn", "data.iterations=30");
    train_config c;
    cJSON *a, *b;
    int64_t written;

    check_ok(train_run(&o, NULL));
    score("drawn", "eval1", 0, &a);
    score("drawn", "eval2", 1, &b);
    ck_assert_int_gt(cJSON_GetObjectItem(b, "mesh_samples")->valueint, 0);
    ck_assert_int_gt(cJSON_GetObjectItem(b, "sequence_samples")->valueint, 0);
    ck_assert_int_eq(cJSON_GetObjectItem(a, "sequence_samples")->valueint, 0);
    for (size_t i = 0; i < LT_COUNT(keys); i++)
        ck_assert_double_eq(value(a, "model", keys[i]), value(b, "model", keys[i]));
    ck_assert(value(a, "model", "psnr_db") > 5);
    ck_assert(value(a, "initial", "mce_mm") > 5 && value(a, "initial", "mce_mm") < 60);
    ck_assert(value(a, "mean", "mce_mm") > 0);
    ck_assert(is_file(at("eval1/pictures.png")) && is_file(at("eval1/per-sample.csv")));
    cJSON_Delete(a);
    cJSON_Delete(b);
    check_ok(train_config_load(arena, tasks, at("drawn/config.json"), NULL, 0, &c));
    check_ok(hogs_task.predict(&(task_prediction){ .arena = arena, .config = &c, .checkpoint = last_of("drawn"),
                                                   .inputs = (const char *const[]){ at("data") }, .n_inputs = 1,
                                                   .out = at("frames") }, &written));
    ck_assert_int_eq(written, 8);
    train_config_fini(&c);
    exported();
    animated();
}
END_TEST

/* ---- what is wrong --------------------------------------------------------------------------------------- */

static void refused(const char *more, const char *line)
{
    const train_options o = options("refused", more);

    ck_assert_int_ne(train_run(&o, NULL), LT_OK);
    ck_assert_msg(strstr(lt_last_error(), line), "%s\nwant: %s", lt_last_error(), line);
}

START_TEST(sets_of_another_run)
{
    refused("model.hands=3", "model.hands and model.objects are 3 and 4, but the data have 2 subjects and 4 objects");
}
END_TEST

START_TEST(frames_of_another_size)
{
    refused("model.width=640", "320 x 240 pixels, expected 640 x 240 as the model draws them; frames of one run are of "
            "one size");
}
END_TEST

/* A sequence whose masks are black: nothing could be learnt from it. */
START_TEST(empty_masks)
{
    const char *name = "SYN0MB00";
    lt_image black;
    lt_arena *a = lt_arena_new();

    check_ok(lt_image_init(a, 80, 60, 3, 8, &black));
    for (int frame = 0; frame < 100; frame++) {
        const char *path = at(lt_arena_printf(arena, "data/train/%s/seg/%04d.png", name, frame));

        if (is_file(path))
            check_ok(lt_png_write(path, &black));
    }
    refused(NULL, "masks of sequence SYN0MB00 are empty in all of 5 frames that were looked at; leave it out, or take "
            "data.masks=initial");
    lt_arena_free(a);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, setup, close_scratch);
    tcase_add_test(tc, same_bits);
    tcase_add_test(tc, scored_and_drawn);
    tcase_add_test(tc, sets_of_another_run);
    tcase_add_test(tc, frames_of_another_size);
    tcase_add_test(tc, empty_masks);
}

int main(void)
{
    return run_suite("hogs task", add_tests);
}
