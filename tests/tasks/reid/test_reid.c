/* SPDX-License-Identifier: Apache-2.0 */
/* Learning who is who from a few drawn films: bits do not depend on threads or stops, and trackers that ask keep
 * ids. */
#include "libtensor/base/parallel.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "tasks/reid/follow.h"
#include "tasks/reid/looks.h"
#include "tasks/reid/scores.h"
#include "tasks/reid/task.h"
#include "tests/scratch.h"
#include "train/trainer.h"

#include <math.h>
#include <signal.h>
#include <unistd.h>

static const task *const tasks[] = { &reid_task, NULL };

/* ---- films: two meet, and turn round ---- */

enum { WIDTH = 160, HEIGHT = 80, FRAMES = 24, TALL = 48, WIDE = 24 };

typedef struct { const char *split, *name; uint8_t colour[2][3]; } film;

static const film films[] = {
    { "train", "a_person", { { 220, 40, 40 }, { 40, 40, 220 } } },
    { "train", "b_person", { { 40, 200, 40 }, { 230, 230, 40 } } },
    { "evaluation", "c_person", { { 230, 120, 30 }, { 30, 160, 200 } } },
};

static int left_of(int who, int k)
{
    const int x = 4 + (int)lround(66 * sin(M_PI * k / (FRAMES - 1)));

    return who ? WIDTH - WIDE - x : x;
}

/* The second hides the first. */
static double visible(int who, int k)
{
    const int both = WIDE - abs(left_of(0, k) - left_of(1, k));

    return who == 0 && both > 0 ? 1 - both / (double)WIDE : 1;
}

static void draw(lt_image *img, int x, int y, const uint8_t colour[3])
{
    for (int r = y; r < y + TALL; r++)
        for (int c = x; c < x + WIDE; c++)
            memcpy(img->data + 3 * (size_t)(r * WIDTH + c), colour, 3);
}

static void put_film(const film *of)
{
    const char *folder = at(lt_arena_printf(arena, "data/%s/%s", of->split, of->name));
    FILE *gt, *det, *info;

    check_ok(lt_make_dirs(lt_arena_printf(arena, "%s/gt", folder)));
    check_ok(lt_make_dirs(lt_arena_printf(arena, "%s/det", folder)));
    check_ok(lt_make_dirs(lt_arena_printf(arena, "%s/img1", folder)));
    gt = fopen(lt_arena_printf(arena, "%s/gt/gt.txt", folder), "w");
    det = fopen(lt_arena_printf(arena, "%s/det/det.txt", folder), "w");
    info = fopen(lt_arena_printf(arena, "%s/seqinfo.ini", folder), "w");
    fprintf(info, "[Sequence]\nframeRate=10\nseqLength=%d\nimWidth=%d\nimHeight=%d\nimExt=.png\n", FRAMES, WIDTH,
            HEIGHT);
    for (int k = 0; k < FRAMES; k++) {
        lt_image img;

        check_ok(lt_image_init(arena, WIDTH, HEIGHT, 3, 8, &img));
        memset(img.data, 110, 3 * (size_t)WIDTH * HEIGHT);
        for (int who = 0; who < 2; who++) {
            const int x = left_of(who, k), y = 12 + 4 * who;

            draw(&img, x, y, of->colour[who]);
            fprintf(gt, "%d,%d,%d,%d,%d,%d,1,1,%.2f\n", k + 1, who + 1, x + 1, y + 1, WIDE, TALL, visible(who, k));
            fprintf(det, "%d,-1,%d,%d,%d,%d,%.2f,-1,-1,-1\n", k + 1, x + 1, y + 1, WIDE, TALL,
                    (0.9 - 0.1 * who) * visible(who, k));
        }
        check_ok(lt_png_write(lt_arena_printf(arena, "%s/img1/%06d.png", folder, k + 1), &img));
    }
    fclose(gt);
    fclose(det);
    fclose(info);
}

static void setup(void)
{
    static const char config[] = "{ \"model\": { \"name\": \"reid\", \"dropout\": 0.1 }, \"optim\": { \"kind\": "
        "\"adam\", \"lr\": 1e-3, \"schedule\": \"constant\", \"batch\": 6, \"shards\": 2, \"steps\": 4 }, \"train\": { "
        "\"checkpoint_minutes\": 0, \"validate_every\": 0 }, \"data\": { \"every\": 4, \"visible\": 0.5 } }";

    open_scratch();
    for (size_t i = 0; i < LT_COUNT(films); i++)
        put_film(&films[i]);
    check_ok(lt_write_file(at("reid.json"), config, sizeof(config) - 1));
}

static lt_status train(const char *out, const char *more, const char *resume,
                       void (*before_step)(void *, int64_t, lt_params *), train_result *result)
{
    const char *set[] = { lt_arena_printf(arena, "data.dir=%s/data", scratch_folder), more, "train.validate_steps=40" };
    train_options o = { .tasks = tasks, .config = resume ? NULL : at("reid.json"), .out = at(out), .quiet = true,
                        .resume = resume, .before_step = before_step, .set = set, .n_set = resume ? 0 : more ? 3 : 1 };

    return train_run(&o, result);
}

START_TEST(threads_do_not_matter)
{
    for (int threads = 1; threads <= 3; threads++) {
        const char *out = lt_arena_printf(arena, "threads%d", threads);

        lt_set_threads(threads);
        check_ok(train(out, NULL, NULL, NULL, NULL));
        same_end("threads1", out);
    }
}
END_TEST

static void stop_at_third(void *ctx, int64_t step, lt_params *params)
{
    (void)ctx, (void)params;
    if (step == 3)
        raise(SIGTERM);
}

START_TEST(stops_do_not_matter)
{
    check_ok(train("whole", NULL, NULL, NULL, NULL));
    ck_assert_int_eq(train("stopped", NULL, NULL, stop_at_third, NULL), LT_ESTOPPED);
    check_ok(train("stopped", NULL, "", NULL, NULL));
    same_end("whole", "stopped");
}
END_TEST

/* ---- trackers ---- */

static track_scores score(const char *run, track_method method)
{
    tracker_options options = tracker_defaults;
    mot_set set;
    mot_frame *results;
    track_score_table table;
    embedder *e;

    check_ok(embedder_open(at(run), &e));
    check_ok(mot_open(arena, at("data"), "evaluation", &set));
    options.method = method;
    options.fps = set.sequence[0].fps;
    check_ok(follow(arena, &set.sequence[0], e, &options, 1, NULL, NULL, &results));
    embedder_free(e);
    check_ok(lt_make_dirs(at("results/data")));
    check_ok(mot_write(at("results/data/c_person.txt"), results, FRAMES));
    check_ok(track_score_files(at("data"), "evaluation", at("results"), NULL, &table));
    ck_assert_int_eq(table.sequences, 1);
    check_ok(track_score_page(&table, scratch_folder));
    ck_assert(access(at("table.md"), R_OK) == 0);
    return track_scores_of(&table.row[0].counts);
}

/* Who was never seen is known again after forty steps, and is followed better for it than by overlap alone. */
START_TEST(it_learns)
{
    track_scores asks, overlaps;
    train_result r;

    check_ok(train("learns", "optim.steps=40", NULL, NULL, &r));
    ck_assert_double_eq(r.best, 1);
    asks = score("learns", TRACK_DEEPSORT);
    overlaps = score("learns", TRACK_IOU);
    ck_assert_msg(asks.switches < overlaps.switches && asks.hota > overlaps.hota + 0.05, "HOTA %g, by overlap %g",
                  asks.hota, overlaps.hota);
}
END_TEST

/* ---- looks ---- */

START_TEST(identities)
{
    looks l;

    check_ok(looks_open(arena, at("data"), "train", 4, 0.3, &l));
    ck_assert_int_eq(l.identities, 4);              /* of two films that are no synthetic set */
    ck_assert_int_eq(l.n, 2 * 2 * FRAMES / 4 - 2);  /* one is hidden in frame 12 */
    check_ok(lt_write_file(at("data/manifest.json"), "{\"synthetic\": true}", 19));
    check_ok(looks_open(arena, at("data"), "train", 4, 0.3, &l));
    ck_assert_int_eq(l.identities, 2);              /* of one */
    check_error(looks_open(arena, at("data"), "train", 4, 1.1, &l), LT_EINVAL, "no box of the train split is scored");
    check_error(looks_open(arena, at("none"), "train", 4, 0.3, &l), LT_EIO, "No such file");
}
END_TEST

START_TEST(refused)
{
    track_score_table table;
    train_result r;

    check_error(train("few", "model.identities=3", NULL, NULL, &r), LT_EINVAL, "model.identities: 3, but ");
    check_error(track_score_files(at("data"), "evaluation", at("none"), NULL, &table), LT_EIO, "none/c_person.txt");
    check_ok(lt_make_dirs(at("bad")));
    check_ok(lt_write_file(at("bad/c_person.txt"), "1,1,2,3,4,5\n1,1,9,9,4,5\n", 24));
    check_error(track_score_files(at("data"), "evaluation", at("bad"), NULL, &table), LT_EINVAL,
                "c_person: frame 1: identity 1 is there twice");
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 300);
    tcase_add_checked_fixture(tc, setup, close_scratch);
    tcase_add_test(tc, threads_do_not_matter);
    tcase_add_test(tc, stops_do_not_matter);
    tcase_add_test(tc, it_learns);
    tcase_add_test(tc, identities);
    tcase_add_test(tc, refused);
}

int main(void)
{
    return run_suite("reid", add_tests);
}
