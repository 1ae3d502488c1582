/* SPDX-License-Identifier: Apache-2.0 */
/* Still scenes on the trainer, from the generator's turntable: the same bits on any number of threads and after any
 * stop, also where Gaussians are added; scores, pictures and files of a run; and what is wrong is said. */
#include "estimate/posed/turntable.h"
#include "libtensor/base/parallel.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/mesh/ply.h"
#include "synth/generate.h"
#include "tasks/splats/task.h"
#include "tests/scratch.h"
#include "train/trainer.h"

#include <cjson/cJSON.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

enum { VIEWS = 9, HELD_OUT = 2, ITERATIONS = 220, CONTROL = 100 };

static const task *const tasks[] = { &splats_task, NULL };

static void setup(void)
{
    static const char config[] = "{ \"model\": { \"name\": \"splats\", \"gaussians\": 1000, \"cap\": 1500 }, "
        "\"data\": { \"iterations\": 220, \"downscale\": 4 }, \"optim\": { \"batch\": 1 }, "
        "\"train\": { \"validate_every\": 0, \"checkpoint_minutes\": 0, \"log_every\": 1 } }";
    synth_options o = { .preset = SYNTH_TURNTABLE, .seed = 5, .frames = VIEWS };

    open_scratch();
    o.out = at("data");
    check_ok(synth_generate(&o, NULL, NULL));
    check_ok(lt_write_file(at("static.json"), config, sizeof(config) - 1));
}

static train_options options(const char *out, const char *more)
{
    const char **set = lt_arena_array(arena, 2, sizeof(*set));

    set[0] = lt_arena_printf(arena, "data.dir=%s", at("data"));
    set[1] = more;
    return (train_options){ .tasks = tasks, .config = at("static.json"), .set = set, .n_set = more ? 2 : 1,
                            .out = at(out), .quiet = true };
}

static void raise_at(void *ctx, int64_t step, lt_params *params)
{
    (void)params;
    if (step == *(const int64_t *)ctx)
        raise(SIGTERM);
}

/* On one, two and four threads; and on three, stopped before and behind density control */
START_TEST(same_bits)
{
    static const int64_t stops[] = { 60, CONTROL, CONTROL + 1, ITERATIONS };
    static const char *const runs[] = { "threads1", "threads2", "threads4" };
    train_options o;
    int64_t stop;

    for (int i = 0; i < 3; i++) {
        o = options(runs[i], NULL);
        lt_set_threads(1 << i);
        check_ok(train_run(&o, NULL));
        same_end("threads1", runs[i]);
    }
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

/* ---- the trained scene ----------------------------------------------------------------------------------- */

static void config_of(const char *run, train_config *c)
{
    check_ok(train_config_load(arena, tasks, at(lt_arena_printf(arena, "%s/config.json", run)), NULL, 0, c));
}

static double score(const char *run, const char *key)
{
    static const char *const texts[] = { "ssim_form", "ssim zero-padded", "lpips", "lpips (random trunk)" };
    train_config c;
    cJSON *scores;
    double x;
    const char *folder = at(lt_arena_printf(arena, "%s/eval", run));

    config_of(run, &c);
    check_ok(lt_make_dirs(folder));
    check_ok(splats_task.evaluate(&(task_evaluation){ .arena = arena, .config = &c, .checkpoint = last_of(run),
                                                      .folder = folder }, &scores));
    for (size_t i = 0; i < LT_COUNT(texts); i += 2)
        ck_assert_str_eq(cJSON_GetStringValue(cJSON_GetObjectItem(scores, texts[i])), texts[i + 1]);
    ck_assert_msg(cJSON_IsNumber(cJSON_GetObjectItem(scores, key)), "no %s", key);
    x = cJSON_GetObjectItem(scores, key)->valuedouble;
    cJSON_Delete(scores);
    train_config_fini(&c);
    return x;
}

static void export_to(const char *run, const char *file, const char *format)
{
    train_config c;

    config_of(run, &c);
    check_ok(splats_task.export(&(task_export){ .arena = arena, .config = &c, .checkpoint = last_of(run),
                                                .file = at(file), .format = format }));
    ck_assert(access(at(file), R_OK) == 0);
    train_config_fini(&c);
}

static void count_exported(const char *file, double want)
{
    lt_ply ply;
    lt_splat *splat;
    size_t n;

    check_ok(lt_ply_read(arena, at(file), &ply));
    check_ok(lt_ply_splats(arena, &ply, &splat, &n));
    ck_assert_uint_eq(n, (size_t)want);
}

/* What the camera sees of posed Gaussians is what the run draws, to a grey level. */
static lt_status compare(void *ctx, const uint8_t *rgb)
{
    const posed_frame *f = ctx;

    for (int64_t i = 0; i < 3 * (int64_t)f->width * f->height; i++)
        ck_assert_int_le(abs(rgb[i] - f->drawn[i]), 1);
    return LT_OK;
}

static int shown;

static lt_status look_at(void *ctx, const posed_frame *f)
{
    lt_mesh m;

    (void)ctx;
    ck_assert_int_eq(f->number, shown++);
    ck_assert_uint_eq(f->n[POSED_HAND], 0);
    ck_assert(f->psnr_db > 15 && f->near > 0);
    check_ok(posed_surface(f, POSED_OBJECT, LT_OPACITY_MEAN, POSED_ISO, arena, &m));
    ck_assert_int_eq(m.n_faces, 0);
    return turntable_draw(f, 1, compare, (void *)f);
}

static void check_posed(train_config *c)
{
    const int64_t beyond = HELD_OUT;
    task_posing p = { .arena = arena, .config = c, .checkpoint = last_of("drawn"), .n_frames = INT64_MAX,
                      .visit = look_at };

    check_ok(splats_task.pose(&p));
    ck_assert_int_eq(shown, HELD_OUT);
    p.frame = &beyond;
    p.n_frames = 1;
    check_error(splats_task.pose(&p), LT_EINVAL, "views that are held out, counted from 0");
}

/* Views that were not learnt from look like themselves, and as many Gaussians as there are come out in each format. */
START_TEST(scored_drawn_exported)
{
    const train_options o = options("drawn", NULL);
    train_config c;
    int64_t written;

    check_ok(train_run(&o, NULL));
    ck_assert(score("drawn", "psnr_db") > 18);
    ck_assert(score("drawn", "lpips_raw01") > 0 && score("drawn", "lpips_sym") > 0);
    ck_assert_double_eq(score("drawn", "views"), HELD_OUT);
    ck_assert(score("drawn", "gaussians") > 1000 && score("drawn", "gaussians") <= 1500);
    ck_assert(access(at("drawn/eval/pictures.png"), R_OK) == 0 && access(at("drawn/eval/table.md"), R_OK) == 0);
    export_to("drawn", "scene.ply", "ply");
    export_to("drawn", "scene.splat", "splat");
    export_to("drawn", "scene.glb", "glb");
    count_exported("scene.ply", score("drawn", "gaussians"));
    config_of("drawn", &c);
    check_ok(splats_task.predict(&(task_prediction){ .arena = arena, .config = &c, .checkpoint = last_of("drawn"),
                                                     .inputs = (const char *const[]){ at("data") }, .n_inputs = 1,
                                                     .out = at("views") }, &written));
    ck_assert_int_eq(written, HELD_OUT);
    ck_assert(access(at("views/images/0008.png"), R_OK) == 0);
    check_posed(&c);
    train_config_fini(&c);
}
END_TEST

/* ---- what is wrong --------------------------------------------------------------------------------------- */

static void refused(const char *more, const char *line)
{
    const train_options o = options("refused", more);

    ck_assert_int_ne(train_run(&o, NULL), LT_OK);
    ck_assert_msg(strstr(lt_last_error(), line), "%s\nwant: %s", lt_last_error(), line);
}

START_TEST(too_large)
{
    refused("model.cap=1000000000", "a smaller model.cap takes less");
}
END_TEST

START_TEST(wrong_sizes)
{
    refused("model.width=64", "pictures of up to 100 x 100, but model.width and .height say 64 x 100");
    refused("model.cap=500", "model.gaussians: 1000, but model.cap allows 500");
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, setup, close_scratch);
    tcase_add_test(tc, same_bits);
    tcase_add_test(tc, scored_drawn_exported);
    tcase_add_test(tc, too_large);
    tcase_add_test(tc, wrong_sizes);
}

int main(void)
{
    return run_suite("splats task", add_tests);
}
