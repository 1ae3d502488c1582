/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/cli.h"

#include "libtensor/io/text/json.h"
#include "tasks/tasks.h"
#include "train/ranks/join.h"
#include "train/trainer.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <string.h>

enum { DATA = 256, HAND, BODY, SET, RESUME, INIT, DRY_RUN, KEYS, JSON };

typedef struct {
    train_options o;
    cli_overrides over;
    char data[4096], hand[4096], body[4096];
    bool keys, json;
} train_args;

static const struct argp_option options[] = {
    { "config", 'c', "FILE|NAME", 0, "a JSON file, a run's folder, or a config that comes with palmar: hocat, "
      "unified, hogs, points, action or body, a dash, and full, tiny, cpu, s or another variant; detect-n, "
      "reid, splats-static", 0 },
    { "data", DATA, "DIR", 0, "the dataset: short for --set data.dir=DIR", 0 },
    { "hand", HAND, "FILE", 0, "hand model: short for --set data.hand=FILE", 0 },
    { "body", BODY, "FILE", 0, "body model, of body-tiny and body-s: SMPLX_NEUTRAL.npz or .pkl; short for "
      "--set data.body=FILE", 0 },
    { "set", SET, "KEY=VALUE", 0, "override a key, as optim.lr=3e-4; may be repeated", 0 },
    { "out", 'o', "DIR", 0, "the run's folder", 0 },
    { "resume", RESUME, "FILE|RUN", OPTION_ARG_OPTIONAL,
      "go on from FILE, or a run's last checkpoint; without one, from the newest sound one of --out", 0 },
    { "init", INIT, "FILE|RUN", 0, "initial weights: safetensors, a checkpoint of PyTorch (.pth, .pt), or a run's "
      "folder", 0 },
    { "threads", 't', "N", 0, "default: the CPUs this process may use", 0 },
    { "dry-run", DRY_RUN, NULL, 0, "build everything, check the data, say what it takes, stop", 0 },
    { "json", JSON, NULL, 0, "with --dry-run: bytes of memory and disk, steps, and the seconds that they take, to "
      "stdout", 0 },
    { "quiet", 'q', NULL, 0, "no progress", 0 },
    { "keys", KEYS, NULL, 0, "list every key of a config with its default and meaning", 0 },
    { 0 },
};

static void check(train_args *a, struct argp_state *state)
{
    if (a->keys)
        return;
    if (!a->o.out)
        argp_error(state, "where to? give --out DIR");
    if (!a->o.config && !a->o.resume)
        argp_error(state, "train what? give --config FILE or NAME, or --resume");
    if (a->json && !a->o.dry_run)
        argp_error(state, "--json goes with --dry-run; a run writes log.jsonl");
    if (a->o.resume && a->o.init)
        argp_error(state, "--resume goes on with the run's own weights, --init begins with others; give one of them");
}

/* A folder may be called 2024 or true, which as a value of a config would be no text: ./2024 is. */
static void override_path(train_args *a, struct argp_state *state, const char *key, const char *path, char *room,
                          size_t size)
{
    cJSON *value = cJSON_ParseWithOpts(path, NULL, true);

    if (snprintf(room, size, "%s=%s%s", key, value ? "./" : "", path) >= (int)size)
        argp_error(state, "%s: too long a name", path);
    cJSON_Delete(value);
    cli_override(state, &a->over, room);
}

static error_t parse(int key, char *arg, struct argp_state *state)
{
    train_args *a = state->input;

    switch (key) {
    case 'c': a->o.config = cli_find_config(state, arg); break;
    case 'o': a->o.out = arg; break;
    case 'q': a->o.quiet = true; break;
    case 't': cli_threads(state, arg); break;
    case SET: cli_override(state, &a->over, arg); break;
    case RESUME: a->o.resume = arg ? arg : ""; break;
    case INIT: a->o.init = arg; break;
    case DRY_RUN: a->o.dry_run = true; break;
    case KEYS: a->keys = true; break;
    case JSON: a->json = true; break;
    case DATA: override_path(a, state, "data.dir", arg, a->data, sizeof(a->data)); break;
    case HAND: override_path(a, state, "data.hand", arg, a->hand, sizeof(a->hand)); break;
    case BODY: override_path(a, state, "data.body", arg, a->body, sizeof(a->body)); break;
    case ARGP_KEY_ARG:
        argp_error(state, a->o.resume ? "\"%s\": the run that goes on is named by --out, one of its checkpoints by "
                   "--resume=FILE" : "\"%s\": options only; the data go behind --data", arg);
        break;
    case ARGP_KEY_END: check(a, state); break;
    default: return ARGP_ERR_UNKNOWN;
    }
    return 0;
}

static const struct argp argp = {
    options, parse, NULL,
    "Train a model. The weights after step k depend on config and data alone, not on threads, processes, stops or "
    "resumes.\v"
    "SIGINT, SIGTERM and SIGHUP save and stop; SIGUSR1 saves and goes on.\n\n"
    "  palmar train --config hocat-tiny --data data/tiny --out runs/tiny\n"
    "  palmar train --resume --out runs/tiny\n"
    "  mpirun -n 4 palmar train --config hocat-tiny --set optim.shards=4 --data data/tiny --out runs/tiny",
    NULL, NULL, NULL,
};

static void print_forecast(const train_result *r)
{
    cJSON *o = cJSON_CreateObject();

    cJSON_AddNumberToObject(o, "bytes", (double)r->bytes);
    cJSON_AddNumberToObject(o, "bytes_disk", (double)r->disk_bytes);
    cJSON_AddNumberToObject(o, "steps", (double)r->steps);
    cJSON_AddNumberToObject(o, "eta_s", r->eta_seconds);
    lt_json_print(stdout, o);
    putchar('\n');
    cJSON_Delete(o);
}

int cmd_train(int argc, char **argv)
{
    train_args a = { .o = { .tasks = tasks } };
    train_result r = { .step = 0 };
    lt_status st;

    cli_parse("train", &argp, argc, argv, &a);
    if (a.keys) {
        train_config_help(tasks, stdout);
        return 0;
    }
    a.o.set = a.over.set;
    a.o.n_set = a.over.n;
    st = ranks_join(&a.o.ranks);
    if (st == LT_OK)
        st = train_run(&a.o, &r);
    ranks_leave();
    if (st == LT_OK && a.json && ranks_lead(a.o.ranks))
        print_forecast(&r);
    if (st && ranks_lead(a.o.ranks))
        fprintf(stderr, "palmar: %s\n", lt_last_error());
    return cli_exit_code(st, r.signal);
}
