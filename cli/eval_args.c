/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/eval_args.h"

#include "tasks/hand_object/evaluate.h"
#include "tasks/tasks.h"

#include <stdio.h>
#include <string.h>

enum { DATA = 256, SPLIT, MODELS, HAND, LIMIT, JSON, SUBMIT, NO_BENCH, MAX_PA, CLAIMS, SETUP, FILTER, PRED,
       REQUIRE, TABLES, SET, MESHES, LPIPS };

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
      "text of hand joints (HPE) or BOP's csv; detections: COCO's json; tracks: a folder of MOTChallenge's results",
      0 },
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
    if (a->n_require == EVAL_REQUIREMENTS)
        argp_error(state, "at most %d requirements", EVAL_REQUIREMENTS);
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
    if (a->n_lpips == EVAL_LPIPS_FILES)
        argp_error(state, "--lpips: at most %d files", EVAL_LPIPS_FILES);
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

const struct argp eval_argp = {
    options, parse, "CHECKPOINT|RUN\n--claims[=RUNS]\n--tables=RUNS",
    "Score a trained model and print its paper's tables with our rows beneath the paper's.\v"
    "The zero predictor and the mean-pose predictor stand in the tables for reference. Rows made on "
    "synthetic data say so.\n\n  palmar eval runs/tiny --data data/tiny --require \"pa_mpjpe_mm<=12\"\n"
    "  palmar eval --claims=runs\n  palmar eval --tables=runs", NULL, cli_help_kinds, NULL,
};
