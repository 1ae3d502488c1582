/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/eval_args.h"
#include "cli/eval_file.h"

#include "data/kind.h"
#include "estimate/metric.h"
#include "eval/bench/bench.h"
#include "eval/tables/claims.h"
#include "eval/tables/filled.h"
#include "eval/tables/runs.h"
#include "eval/tables/scores_file.h"
#include "libtensor/base/printable.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "tasks/action/task.h"
#include "tasks/detect/evaluate.h"
#include "tasks/hand_object/config.h"
#include "tasks/hand_object/evaluate.h"
#include "tasks/hand_object/pictures.h"
#include "tasks/hand_object/task.h"
#include "tasks/reid/scores.h"
#include "tasks/reid/task.h"
#include "tasks/tasks.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <string.h>

enum { PICTURES = 12 };

static bool show_progress(void *ctx, int64_t done, int64_t total)
{
    (void)ctx;
    cli_progress("scored", done, total);
    return !cli_stop_requested();
}

static double latency(const model *m)
{
    bench *b;
    bench_result r;

    if (bench_new(&(bench_options){ .m = m, .batch = 1, .runs = 10, .seconds = 5 }, &b))
        return 0;
    r = bench_run(b);
    bench_free(b);
    return 1e-3 * r.median_ms;
}

static lt_status print(const evaluation *e, bool json)
{
    return json ? cli_print_json(evaluation_json(e), "the scores") : evaluation_print(e, stdout, EVAL_TEXT);
}

static lt_status ledger(const eval_args *a)
{
    eval_claims *c;
    lt_status st = eval_claims_read(a->runs, &c);

    if (st)
        return st;
    if (a->json)
        st = cli_print_json(eval_claims_json(c), "the scores");
    else
        eval_claims_print(c, stdout);
    eval_claims_free(c);
    return st;
}

static lt_status tables_of_runs(const eval_args *a)
{
    eval_filled *f;
    lt_status st = eval_filled_read(a->runs, &f);

    if (st)
        return st;
    st = a->json ? cli_print_json(eval_filled_json(f), "the tables") : eval_filled_print(f, stdout, EVAL_TEXT);
    eval_filled_free(f);
    return st;
}

static double score_of(const void *e, const char *key)
{
    return evaluation_score(e, EVALUATE_MODEL, key);
}

static lt_status write_files(const cli_checkpoint *c, const evaluate_options *o, const evaluation *e,
                             const char *folder)
{
    const char *pictures = lt_path_join(c->arena, folder, "pictures.png");
    lt_status st = pictures ? evaluation_write(e, folder) : lt_error(LT_ENOMEM, "no memory to write the scores");

    if (st == LT_OK)
        st = evaluate_pictures(o, PICTURES, pictures);
    if (st == LT_OK)
        fprintf(stderr, "tables, scores, errors per sample, pictures: %s\n", folder);
    return st;
}

/* A model that is no better than a pose that sees no image has learnt nothing that the labels' mean does not say. */
static void compare_with_mean(const evaluation *e)
{
    static const struct { const char *what, *key; } of[] = { { "hand", "pa_mpjpe_mm" }, { "object", "add_mm" } };

    for (size_t i = 0; i < LT_COUNT(of); i++) {
        const double ours = evaluation_score(e, EVALUATE_MODEL, of[i].key);
        const double mean = evaluation_score(e, EVALUATE_MEAN_POSE, of[i].key);

        if (ours >= mean)
            fprintf(stderr, "the %s is no better than the mean of the training labels: %s %.1f %s, the mean pose's "
                    "%.1f; train for longer, or on more\n", of[i].what, metric_find(of[i].key)->name, ours,
                    metric_find(of[i].key)->unit, mean);
    }
}

/* Tables and pictures into --out, or into "eval" of the run that the checkpoint lies in. */
static lt_status score(const eval_args *a, const cli_checkpoint *c, evaluate_options *o)
{
    const char *folder = a->out ? a->out : lt_path_join(c->arena, c->run, "eval");
    evaluation *e;
    lt_status st = !folder ? lt_error(LT_ENOMEM, "no memory to write the scores")
                   : a->out ? lt_make_dirs(folder) : lt_make_own_folder(folder);

    if (st)
        return st;
    lt_atomic_sweep(folder);
    o->seconds_per_image = a->no_bench ? 0 : latency(o->m);
    st = evaluate(o, &e);
    if (st)
        return st;
    if (o->training && !evaluation_summary(e, EVALUATE_MEAN_POSE).label)
        fprintf(stderr, "no mean-pose row: %s: no label of the training split can be read\n", o->data->root);
    st = write_files(c, o, e, folder);                  /* first: whoever reads what is printed may stop at any line */
    if (st == LT_OK)
        st = print(e, a->json);
    if (st == LT_OK)
        compare_with_mean(e);
    if (st == LT_OK)
        st = eval_require(a->require, a->n_require, score_of, e);
    evaluation_free(e);
    return st;
}

static lt_status open_data(const eval_args *a, const cli_checkpoint *c, const char *split, dataset **out)
{
    dataset_options o = cli_checkpoint_data(c, a->data ? a->data : c->config.data->dir, split);
    char with_setups[DATASET_LIST];
    lt_status st;

    o.models = a->models ? a->models : o.models;
    o.setup = a->setup ? a->setup : o.setup;
    o.filter = a->filter ? a->filter : o.filter;
    if (!a->submit && o.filter && !strcmp(o.filter, "every"))
        o.filter = "valid";                             /* where there is no hand, none is scored */
    o.vertices = !a->submit;
    st = dataset_open(&o, out);
    if (st == LT_OK && (*out)->partial)
        lt_say(stderr, "%s: %s", o.root, (*out)->partial);
    if (st == LT_OK && (a->setup || a->filter) && !(*out)->kind->setups) {
        dataset_list_kinds(DATASET_WITH_SETUPS, with_setups);
        st = lt_error(LT_EUSAGE, "%s: is %s, and --setup and --filter choose among %s's samples", o.root,
                      (*out)->title, with_setups);
    }
    return st;
}

static lt_status run(const eval_args *a, const cli_checkpoint *c)
{
    dataset *data = NULL, *training = NULL;
    evaluate_options o = {
        .m = &c->m, .hand = c->hand.model, .hand_name = c->hand.name, .checkpoint = c->path, .step = c->step,
        .bilinear = hand_object_config_of(&c->config)->bilinear, .batch = a->batch, .limit = a->limit,
        .progress = show_progress,
    };
    lt_status st;

    if (!a->data)
        lt_say(stderr, "data: %s, which the run was trained on", c->config.data->dir);
    st = open_data(a, c, a->split, &data);
    if (st == LT_OK && !a->submit && open_data(a, c, "train", &training))
        fprintf(stderr, "no mean-pose row: %s\n", lt_last_error());
    o.data = data;
    o.training = training;
    if (st == LT_OK)
        st = a->submit ? evaluate_submission(&o, a->submit) : score(a, c, &o);
    dataset_free(training);
    dataset_free(data);
    return st;
}

/* ---- models of other tasks, which score themselves -------------------------------------------------------------- */

/* Of the first row, where there are several */
static double first_row_score(const void *scores, const char *key)
{
    const cJSON *row = cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(scores, "rows"), 0);

    return eval_number_of(row ? row : scores, key);
}

/* What the options say in the place of the run's configuration */
static lt_status point_at_data(const eval_args *a, cli_checkpoint *c)
{
    if (a->submit || a->setup || a->filter || a->models)
        return lt_error(LT_EUSAGE, "%s: a model of %s: --submit, --setup, --filter and --models are for those of %s",
                        c->path, c->config.task->name, hand_object_task.name);
    if (a->data)
        c->config.data->dir = a->data;
    else
        lt_say(stderr, "data: %s, which the run was trained on", c->config.data->dir);
    return LT_OK;
}

static lt_status evaluate_task(const eval_args *a, cli_checkpoint *c)
{
    const char *folder = a->out ? a->out : lt_path_join(c->arena, c->run, "eval");
    const task_evaluation e = {
        .arena = c->arena, .config = &c->config, .checkpoint = c->path, .step = c->step, .hand = a->hand,
        .split = a->split, .folder = folder, .limit = a->limit, .meshes = a->meshes < 0 ? 1 : a->meshes,
        .lpips = a->lpips, .n_lpips = a->n_lpips, .tables = a->json ? NULL : stdout, .progress = show_progress,
    };
    cJSON *scores = NULL;
    lt_status st = point_at_data(a, c);

    if (!st)
        st = !folder ? lt_error(LT_ENOMEM, "no memory to write the scores")
             : a->out ? lt_make_dirs(folder) : lt_make_own_folder(folder);
    if (st)
        return st;
    lt_atomic_sweep(folder);
    st = c->config.task->evaluate(&e, &scores);
    if (!st)
        fprintf(stderr, "tables, scores, errors per sample, pictures: %s\n", folder);
    if (!st)
        st = eval_require(a->require, a->n_require, first_row_score, scores);
    if (a->json && scores)
        cli_print_json(scores, "the scores");
    else
        cJSON_Delete(scores);
    return st;
}

/* ---- detections -------------------------------------------------------------------------------------------------- */

/* A file of COCO's results */
static lt_status score_detections(const eval_args *a)
{
    const detect_evaluation e = { .data = a->data, .split = a->split, .pred = a->pred, .batch = a->batch, .threads = 2,
                                  .folder = a->out, .progress = show_progress };
    detect_scores s;
    lt_status st = a->setup || a->models || a->hand
                   ? lt_error(LT_EUSAGE, "detections take --data, --split, --out and --json") : detect_evaluate(&e, &s);

    if (st == LT_OK && a->json)
        st = cli_print_json(detect_scores_json(&s), "the scores");
    else if (st == LT_OK)
        detect_scores_print(&s, stdout);
    return st;
}

/* A folder of MOTChallenge's results */
static lt_status score_tracks(const eval_args *a)
{
    track_score_table t;
    lt_status st = a->setup || a->models || a->hand
                   ? lt_error(LT_EUSAGE, "tracks take --data, --split, --out and --json")
                   : track_score_files(a->data, a->split, a->pred, show_progress, &t);

    if (st == LT_OK && a->out)
        st = lt_make_dirs(a->out);
    if (st == LT_OK && a->out)
        st = scores_file_write(a->out, track_score_json(&t));
    if (st == LT_OK && a->json)
        st = cli_print_json(track_score_json(&t), "the scores");
    else if (st == LT_OK)
        track_score_print(&t, stdout);
    return st;
}

static lt_status score_file(const eval_args *a)
{
    if (mot_probe(a->data))
        return score_tracks(a);
    if (detection_probe(a->data))
        return score_detections(a);
    if (a->json)
        return lt_error(LT_EUSAGE, "--json with --pred is for COCO's and MOTChallenge's results");
    return eval_file(&(eval_file_options){ .pred = a->pred, .data = a->data, .split = a->split, .setup = a->setup,
                                           .models = a->models, .hand = a->hand, .out = a->out,
                                           .progress = show_progress });
}

/* Weights were made under all other keys. */
static lt_status check_overrides(const eval_args *a, const cli_checkpoint *c)
{
    for (int i = 0; i < a->over.n; i++)
        if ((c->config.task != &reid_task && c->config.task != &action_task)
            || strncmp(a->over.set[i], "data.", 5) != 0)
            return lt_error(LT_EUSAGE, "--set %s: want a key of group data, of a run of %s or %s", a->over.set[i],
                            reid_task.name, action_task.name);
    return LT_OK;
}

static bool has_score(const task *t, const char *key)
{
    for (const char *const *own = t->scores; own && *own; own++)
        if (strcmp(*own, key) == 0)
            return true;
    return false;
}

/* By the model's task */
static lt_status score_run(const eval_args *a, cli_checkpoint *c)
{
    lt_status st = check_overrides(a, c);

    if (st)
        return st;
    if (a->meshes >= 0 && !c->config.task->export)
        return lt_error(LT_EUSAGE, "%s: a model of %s, which has no surfaces for --meshes", c->path,
                        c->config.task->name);
    if (a->n_lpips && !has_score(c->config.task, "lpips_sym"))
        return lt_error(LT_EUSAGE, "%s: a model of %s, which draws no pictures for --lpips", c->path,
                        c->config.task->name);
    if (c->config.task->evaluate)
        return evaluate_task(a, c);
    st = cli_checkpoint_load(c, a->hand);
    if (st == LT_OK)
        st = cli_checkpoint_want_hands(c);
    return st ? st : run(a, c);
}

int cmd_eval(int argc, char **argv)
{
    eval_args a = { .split = "evaluation", .batch = 8, .meshes = -1 };
    cli_checkpoint c;
    lt_status st;

    cli_parse("eval", &eval_argp, argc, argv, &a);
    if (a.claims || a.tables) {
        st = a.claims ? ledger(&a) : tables_of_runs(&a);
        return st ? cli_fail(st) : 0;
    }
    cli_catch_signals();
    if (a.pred) {
        st = score_file(&a);
        return st ? cli_fail(st) : 0;
    }
    st = cli_checkpoint_find_with(a.checkpoint, &a.over, &c);
    if (st == LT_OK)
        st = score_run(&a, &c);
    cli_checkpoint_close(&c);
    return st ? cli_fail(st) : 0;
}
