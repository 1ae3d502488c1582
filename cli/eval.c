/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/cli.h"
#include "cli/eval_file.h"

#include "data/kind.h"
#include "estimate/metric.h"
#include "eval/bench/bench.h"
#include "eval/tables/claims.h"
#include "eval/tables/filled.h"
#include "eval/tables/require.h"
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

enum { PICTURES = 12, REQUIREMENTS = 64, LPIPS_FILES = 2 };
enum { DATA = 256, SPLIT, MODELS, HAND, LIMIT, JSON, SUBMIT, NO_BENCH, MAX_PA, CLAIMS, SETUP, FILTER, PRED,
       REQUIRE, TABLES, SET, MESHES, LPIPS };

typedef struct {
    const char *checkpoint, *data, *split, *setup, *filter, *models, *hand, *out, *submit, *pred;
    int batch, limit, meshes;      /* meshes: -1 where nothing was said */
    eval_requirement require[REQUIREMENTS];
    int n_require;
    const char *lpips[LPIPS_FILES];
    int n_lpips;
    cli_overrides over;
    const char *runs;               /* of --claims or --tables */
    bool json, no_bench, claims, tables;
} eval_args;

static const struct argp_option options[] = {
    { "data", DATA, "DIR", 0, "the dataset, " CLI_KINDS "; default the run's", 0 },
    { "split", SPLIT, "NAME", 0, "evaluation (default; DexYCB: test), val, or train", 0 },
    { "setup", SETUP, "NAME", 0, CLI_SETUPS "; default the run's", 0 },
    { "filter", FILTER, "NAME", 0, CLI_FILTERS "; default the run's", 0 },
    { "models", MODELS, "DIR", 0, "the objects' models; default the run's, else in the dataset's folder, or "
      "beside it", 0 },
    { "hand", HAND, "FILE", 0, "hand model (MANO_RIGHT.pkl, npz or embedded); default the one of the training; with "
      "--pred $PALMAR_HAND, else the embedded one", 0 },
    { "out", 'o', "DIR", 0, "where the tables, scores, errors by sample, joint, object and sequence, and pictures go; "
      "default eval in the run's folder", 0 },
    { "submit", SUBMIT, "FILE", 0, "write a result file for the official scorer instead of scoring. HO3D: pred.json or "
      "pred.zip; DexYCB: .txt hand joints, .csv object poses, .json detections", 0 },
    { "pred", PRED, "FILE|DIR", 0, "score a result file instead of a checkpoint. HO3D: pred.json or pred.zip; DexYCB: "
      "text of hand joints (HPE) or BOP's csv; detections: COCO's json; tracks: a folder of MOTChallenge's results", 0 },
    { "batch", 'b', "N", 0, "images at a time; default 8", 0 },
    { "limit", LIMIT, "N", 0, "score N samples spread over the split; default all", 0 },
    { "meshes", MESHES, "N", 0,
      "of a run of hogs: frames of each object whose surfaces are made and scored; default 1, 0 none", 0 },
    { "lpips", LPIPS, "FILE", 0,
      "of a run of hogs or splats: LPIPS's weights; given twice where AlexNet's and the channels' are two files; "
      "default those of the run, else a random trunk, and the scores say so", 0 },
    { "set", SET, "KEY=VALUE", 0, "another value for a key of a tracker, as data.max_age=60; may be given again", 0 },
    { "require", REQUIRE, "KEY>=X", 0, "exit with 1 when the model's score is less, or with KEY<=X more; KEY as in "
      "scores.json; may be given again", 0 },
    { "max-pa-mpjpe", MAX_PA, "MM", 0, "the same as --require pa_mpjpe_mm<=MM", 0 },
    { "no-bench", NO_BENCH, NULL, 0, "leave the time columns of Table 5 empty", 0 },
    { "claims", CLAIMS, "RUNS", OPTION_ARG_OPTIONAL,
      "instead of scoring: what the papers' ablations claim, and whether it "
      "held in the scored runs in folder RUNS", 0 },
    { "tables", TABLES, "RUNS", 0, "instead of scoring: the papers' tables with a row for each scored run in folder "
      "RUNS", 0 },
    { "threads", 't', "N", 0, "default: the CPUs this process may use", 0 },
    { "json", JSON, NULL, 0, "print scores.json instead of the tables", 0 },
    { 0 },
};

/* What would have no effect is refused. */
static void check_together(const eval_args *a, struct argp_state *state)
{
    const bool scoring = a->json || a->limit || a->n_require;

    if ((a->claims || a->tables) && (a->checkpoint || a->pred || a->submit || a->data || a->limit || a->n_require))
        argp_error(state, "%s reads scored runs: it takes no checkpoint, and of the options --json alone",
                   a->claims ? "--claims" : "--tables");
    if (a->claims && a->tables)
        argp_error(state, "--claims or --tables, not both");
    if (!a->claims && !a->tables && !a->checkpoint && !(a->pred && a->data))
        argp_error(state, "want a checkpoint or a run's folder, or --pred FILE and --data DIR");
    if (a->checkpoint && a->pred)
        argp_error(state, "a checkpoint or --pred, not both");
    if (a->pred && (a->limit || a->n_require || a->submit || a->filter || a->over.n || a->n_lpips))
        argp_error(state, "--pred takes --data, --split, --setup, --models, --hand, --out, --json: the whole file is "
                   "scored");
    if (a->filter && !strcmp(a->filter, "every") && !a->submit)
        argp_error(state, "--filter every has frames without a hand, which --submit alone takes: want valid, hfl-net "
                   "or hoisdf");
    if (a->submit && scoring)
        argp_error(state, "--submit writes the whole split and scores nothing: no --limit, --json, --require or "
                   "--max-pa-mpjpe");
}

/* The i-th key of what is scored: of hands and objects, and of tasks that score themselves */
static const char *known_key(int i)
{
    const char *key;
    int n = 0;

    for (int k = 0; (key = evaluate_key_at(k)); k++)
        if (n++ == i)
            return key;
    for (const task *const *t = tasks; *t; t++)
        for (const char *const *own = (*t)->scores; own && *own; own++)
            if (n++ == i)
                return *own;
    return NULL;
}

static void add_requirement(eval_args *a, struct argp_state *state, const char *text)
{
    if (a->n_require == REQUIREMENTS)
        argp_error(state, "at most %d requirements", REQUIREMENTS);
    else if (eval_require_read(text, known_key, &a->require[a->n_require++]))
        argp_error(state, "%s", lt_last_error());
}

static void add_max_pa_mpjpe(eval_args *a, struct argp_state *state, const char *mm)
{
    char text[64];

    snprintf(text, sizeof(text), "pa_mpjpe_mm<=%.17g", cli_real(state, "max-pa-mpjpe", mm, 0, 1e6));
    add_requirement(a, state, text);
}

static void add_lpips(eval_args *a, struct argp_state *state, const char *file)
{
    if (a->n_lpips == LPIPS_FILES)
        argp_error(state, "--lpips: at most %d files", LPIPS_FILES);
    else
        a->lpips[a->n_lpips++] = file;
}

static error_t parse(int key, char *arg, struct argp_state *state)
{
    eval_args *a = state->input;

    switch (key) {
    case 'o': a->out = arg; break;
    case 'b': a->batch = cli_number(state, "batch", arg, 1, 256); break;
    case 't': cli_threads(state, arg); break;
    case DATA: a->data = arg; break;
    case SPLIT: a->split = arg; break;
    case PRED: a->pred = arg; break;
    case SETUP: a->setup = arg; break;
    case FILTER: a->filter = arg; break;
    case MODELS: a->models = arg; break;
    case HAND: a->hand = arg; break;
    case SUBMIT: a->submit = arg; break;
    case LIMIT: a->limit = cli_number(state, "limit", arg, 1, 1000000000); break;
    case MESHES: a->meshes = cli_number(state, "meshes", arg, 0, 100000); break;
    case MAX_PA: add_max_pa_mpjpe(a, state, arg); break;
    case LPIPS: add_lpips(a, state, arg); break;
    case SET: cli_override(state, &a->over, arg); break;
    case REQUIRE: add_requirement(a, state, arg); break;
    case NO_BENCH: a->no_bench = true; break;
    case JSON: a->json = true; break;
    case CLAIMS:
        a->claims = true;
        a->runs = arg;
        break;
    case TABLES:
        a->tables = true;
        a->runs = arg;
        break;
    case ARGP_KEY_ARG:
        if (a->checkpoint)
            argp_error(state, "one checkpoint at a time");
        a->checkpoint = arg;
        break;
    case ARGP_KEY_END:
        check_together(a, state);
        break;
    default: return ARGP_ERR_UNKNOWN;
    }
    return 0;
}

static const struct argp argp = {
    options, parse, "CHECKPOINT|RUN\n--claims[=RUNS]\n--tables=RUNS",
    "Score a trained model and print its paper's tables with our rows beneath the paper's.\v"
    "The zero predictor and the mean-pose predictor stand in the tables for reference. Rows made on "
    "synthetic data say so.\n\n  palmar eval runs/tiny --data data/tiny --require \"pa_mpjpe_mm<=12\"\n"
    "  palmar eval --claims=runs\n  palmar eval --tables=runs", NULL, cli_help_kinds, NULL,
};

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

    cli_parse("eval", &argp, argc, argv, &a);
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
