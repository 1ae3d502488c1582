/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/cli.h"

#include "eval/bench.h"
#include "libtensor/io/config.h"

#include <stdio.h>
#include <string.h>

enum { MAX_SET = 64 };
enum { RUN_ONLY = 256, SECONDS, JSON, PROFILE, SET, VARIANT, MODE };

typedef struct {
    const char *model, *config, *mode;
    const char *set[MAX_SET];
    int n_set, batch, runs;
    double seconds;
    bool json, profile;
    char variant[64];
} bench_args;

static const struct argp_option options[] = {
    { "model", 'm', "NAME", 0, "hocat", 0 },
    { "variant", VARIANT, "NAME", 0, "of the model; default the config's, else full", 0 },
    { "config", 'c', "FILE", 0, "a config whose \"model\" group to use; default the paper's size", 0 },
    { "set", SET, "KEY=VALUE", 0, "override a key of the config, as model.width=16; may be repeated", 0 },
    { "mode", MODE, "MODE", 0, "infer (default), train, or both", 0 },
    { "batch", 'b', "N", 0, "images at a time; default 1", 0 },
    { "threads", 't', "N", 0, "default: the CPUs this process may use", 0 },
    { "runs", RUN_ONLY, "N", 0, "timed runs; default 20", 0 },
    { "seconds", SECONDS, "S", 0, "stop after S seconds with at least three runs; default 20", 0 },
    { "profile", PROFILE, NULL, 0, "time by op and by layer as well", 0 },
    { "json", JSON, NULL, 0, "one JSON object a line instead of a Markdown row", 0 },
    { 0 },
};

static void add_set(bench_args *a, struct argp_state *state, const char *text)
{
    if (a->n_set == MAX_SET)
        argp_error(state, "at most %d overrides", MAX_SET);
    a->set[a->n_set++] = text;
}

static error_t parse(int key, char *arg, struct argp_state *state)
{
    bench_args *a = state->input;

    switch (key) {
    case 'm': a->model = arg; break;
    case 'c': a->config = arg; break;
    case 'b': a->batch = cli_number(state, "batch", arg, 1, 1024); break;
    case 't': cli_threads(state, arg); break;
    case RUN_ONLY: a->runs = cli_number(state, "runs", arg, 3, 10000); break;
    case SECONDS: a->seconds = cli_real(state, "seconds", arg, 0, 1e6); break;
    case JSON: a->json = true; break;
    case PROFILE: a->profile = true; break;
    case SET: add_set(a, state, arg); break;
    case MODE:
        if (strcmp(arg, "infer") && strcmp(arg, "train") && strcmp(arg, "both"))
            argp_error(state, "--mode: found \"%s\", want infer, train or both", arg);
        a->mode = arg;
        break;
    case VARIANT:
        snprintf(a->variant, sizeof(a->variant), "model.variant=%s", arg);
        add_set(a, state, a->variant);
        break;
    default: return ARGP_ERR_UNKNOWN;
    }
    return 0;
}

static const struct argp argp = {
    options, parse, NULL,
    "Measure latency and memory of a model's inference and training step.\v"
    "FMA peak is what the machine's multiply-adds reach just before and after: on a shared machine a "
    "timing without it says little. PALMAR_ISA=generic|avx2|avx512 chooses the instruction set.\n\n"
    "  palmar bench --model hocat --variant full --batch 1 --threads 2 --json", NULL, NULL, NULL,
};

static lt_status measure(const bench_args *a, const model *m, bool train, bool heading)
{
    const bench_options o = { .m = m, .batch = a->batch, .train = train, .runs = a->runs, .seconds = a->seconds };
    bench *b;
    bench_result r;
    lt_status st = bench_new(&o, &b);

    if (st)
        return st;
    r = bench_run(b);
    if (a->json)
        bench_print_json(b, &r, stdout);
    else
        bench_print(b, &r, stdout, heading);
    fflush(stdout);
    if (a->profile)
        bench_profile(b, a->json ? stderr : stdout);
    bench_free(b);
    return LT_OK;
}

int cmd_bench(int argc, char **argv)
{
    bench_args a = { .model = "hocat", .mode = "infer", .batch = 1, .runs = 20, .seconds = 20 };
    cli_hand hand;
    lt_params *params = NULL;
    model m;
    lt_status st;

    cli_parse("bench", &argp, argc, argv, &a);
    st = cli_hand_open(NULL, NULL, &hand);
    if (st)
        return cli_fail(st);
    st = cli_model_new(a.model, a.config, a.set, a.n_set, &hand, &params, &m);
    if (st == LT_OK && strcmp(a.mode, "train") != 0)
        st = measure(&a, &m, false, true);
    if (st == LT_OK && strcmp(a.mode, "infer") != 0)
        st = measure(&a, &m, true, strcmp(a.mode, "train") == 0);
    lt_params_free(params);
    cli_hand_close(&hand);
    return st ? cli_fail(st) : 0;
}
