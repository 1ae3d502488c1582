/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/cli.h"
#include "cli/info/data.h"
#include "cli/info/detection.h"
#include "cli/info/file.h"
#include "data/detection/detection.h"

#include <config.h>
#include "estimate/starter.h"
#include "estimate/weights/weights.h"
#include "libtensor/base/parallel.h"
#include "libtensor/base/printable.h"
#include "libtensor/graph/plan.h"
#include "libtensor/io/text/json.h"
#include "libtensor/kernels/kernels.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { VARIANT = 256, SET, DATA, SYSTEM, JSON, SAMPLES, SETUP, HAND, HAND_LEFT, INIT };

typedef struct {
    const char *model, *config, *data, *setup, *hand, *hand_left, *file, *init;
    cli_overrides over;
    int samples;
    bool system, json;
} info_args;

static const struct argp_option options[] = {
    { "model", 'm', "NAME", 0,
      "parameters and multiply-adds of a model, by block: hocat, unified, resnet50, efficientnet_b0, vit, lpips, "
      "pointnet2, gpm, csp_seg, reid, osx or action", 0 },
    { "variant", VARIANT, "NAME", 0, "of that model", 0 },
    { "config", 'c', "FILE|NAME|RUN", 0, "a config whose \"model\" group to use; default the paper's size", 0 },
    { "set", SET, "KEY=VALUE", 0, "override a key of the config; may be repeated", 0 },
    { "init", INIT, "FILE", 0, "with --model: what --init FILE of palmar train would load, miss and leave over", 0 },
    { "data", DATA, "DIR", 0, "a dataset: version, splits, objects, a self-test on some samples; of pictures with "
      "objects their counts", 0 },
    { "samples", SAMPLES, "N", 0, "how many samples of each split the self-test reads; default 20; 0: all", 0 },
    { "setup", SETUP, "NAME", 0, "with --data, the splits that are tested; " CLI_SETUPS "; default the first", 0 },
    { "hand", HAND, "FILE", 0, "with --data: hand model (MANO_RIGHT.pkl or npz); default $PALMAR_HAND, else the "
      "embedded one", 0 },
    { "hand-left", HAND_LEFT, "FILE", 0,
      "with --data, DexYCB: MANO_LEFT.pkl; default the right one's mirror image", 0 },
    { "system", SYSTEM, NULL, 0, "this machine and this program", 0 },
    { "json", JSON, NULL, 0, "as JSON", 0 },
    { 0 },
};

static error_t parse(int key, char *arg, struct argp_state *state)
{
    info_args *a = state->input;

    switch (key) {
    case 'm': a->model = arg; break;
    case 'c': a->config = cli_find_config(state, arg); break;
    case INIT: a->init = arg; break;
    case DATA: a->data = arg; break;
    case SETUP: a->setup = arg; break;
    case HAND: a->hand = arg; break;
    case HAND_LEFT: a->hand_left = arg; break;
    case SAMPLES: a->samples = cli_number(state, "samples", arg, 0, 1000000); break;
    case SYSTEM: a->system = true; break;
    case JSON: a->json = true; break;
    case VARIANT: cli_override_variant(state, &a->over, arg); break;
    case SET: cli_override(state, &a->over, arg); break;
    case ARGP_KEY_ARG:
        if (a->file)
            argp_error(state, "one file at a time");
        a->file = arg;
        break;
    case ARGP_KEY_END:
        if (!a->model && !a->data && !a->file && !a->system)
            argp_error(state, "of what? give a file, --model, --data or --system");
        if (a->init && !a->model)
            argp_error(state, "--init goes with --model");
        break;
    default: return ARGP_ERR_UNKNOWN;
    }
    return 0;
}

static const struct argp argp = {
    options, parse, "[FILE|starter]",
    "Tell what is in a model, a checkpoint (ours or PyTorch's), a dataset, a hand file, safetensors or their index, an "
    ".npz, a .npy or a pickle, whatever it is called; \"starter\" is the small models that come with palmar.\v"
    "  palmar info --model hocat --variant full --json\n"
    "  palmar info runs/tiny/checkpoints/last.safetensors\n"
    "  palmar info --model resnet50 --init resnet50-0676ba61.pth\n"
    "  palmar info --data HO3D_v3\n"
    "  palmar info MANO_RIGHT.pkl\n"
    "  palmar info starter", NULL, cli_help_kinds, NULL,
};

/* One "key  value" a line, lists of objects as rows */
static void print_text(const cJSON *v, int indent)
{
    const cJSON *item;

    cJSON_ArrayForEach(item, v) {
        if (item->string && strcmp(item->string, "notes") == 0)     /* behind all the rest */
            continue;
        char *text = cJSON_IsObject(item) || cJSON_IsArray(item) ? NULL : cJSON_PrintUnformatted(item);

        lt_say(stdout, "%*s%-24s %s", indent, "", item->string ? item->string : "-",
               cJSON_IsString(item) ? item->valuestring : text ? text : "");
        cJSON_free(text);
        if (cJSON_IsObject(item) || cJSON_IsArray(item))
            print_text(item, indent + 2);
    }
}

static void print(const cJSON *root, bool json)
{
    const cJSON *note;

    if (json) {
        lt_json_print(stdout, root);
        putchar('\n');
    } else {
        print_text(root, 0);
        cJSON_ArrayForEach(note, cJSON_GetObjectItemCaseSensitive(root, "notes"))
            lt_say(stdout, "%-24s %s", "note", cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(note, "text")));
    }
}

/* ---- a model ------------------------------------------------------------------------------------------- */

static int64_t count_macs(const model *m)
{
    model_record r = { .g = lt_graph_new(), .batch = 1, .whole_maps = true };
    lt_plan *p = NULL;
    int64_t macs = -1;

    if (r.g) {
        m->cls->record(m, false, &r);
        p = lt_compile(r.g, NULL);
    }
    if (p)
        macs = lt_plan_macs(p);
    lt_plan_free(p);
    lt_graph_free(r.g);
    return macs;
}

static lt_status model_json(const model *m, cJSON *root)
{
    const int64_t macs = count_macs(m);
    const double parameters = (double)lt_params_count(m->params, LT_WEIGHT, "");
    cJSON *blocks;
    char prefix[64];

    if (macs < 0)
        return LT_ENOMEM;
    cJSON_AddStringToObject(root, "model", m->cls->name);
    cJSON_AddStringToObject(root, "variant", m->variant);
    cJSON_AddStringToObject(root, "paper", m->cls->paper);
    cJSON_AddNumberToObject(root, "parameters", parameters);
    cJSON_AddNumberToObject(root, "parameters_mib", 4 * parameters / 1048576);
    cJSON_AddNumberToObject(root, "running_statistics", (double)lt_params_count(m->params, LT_STATISTIC, ""));
    cJSON_AddNumberToObject(root, "macs", (double)macs);
    cJSON_AddNumberToObject(root, "image_size", m->image_size);
    blocks = cJSON_AddObjectToObject(root, "blocks");
    for (int i = 0; m->cls->blocks[i]; i++) {
        int64_t count;

        snprintf(prefix, sizeof(prefix), "%s.", m->cls->blocks[i]);
        count = lt_params_count(m->params, LT_WEIGHT, prefix);
        if (count)                                      /* else it is of another variant */
            cJSON_AddNumberToObject(blocks, m->cls->blocks[i], (double)count);
    }
    cJSON_AddItemToObject(root, "config", lt_config_write(m->cls->keys, m->self));
    return LT_OK;
}

static void add_names(cJSON *root, const char *key, const char **name, int n)
{
    cJSON_AddItemToObject(root, key, cJSON_CreateStringArray(name, n));
}

static lt_status add_init(const char *path, const model *m, cJSON *root)
{
    lt_arena *arena = lt_arena_new();
    weights_report r;
    lt_status st = arena ? weights_init(arena, path, m, &r) : lt_error(LT_ENOMEM, "no memory to read %s", path);

    if (st == LT_OK) {
        cJSON *init = cJSON_AddObjectToObject(root, "init");

        cJSON_AddStringToObject(init, "file", path);
        cJSON_AddStringToObject(init, "format", r.format);
        cJSON_AddStringToObject(init, "names of", r.family);
        cJSON_AddStringToObject(init, "taken from", r.taken);
        if (r.n_also)
            add_names(init, "fits as well", r.also, r.n_also);
        cJSON_AddNumberToObject(init, "loaded", r.n_loaded);
        add_names(init, "not in it", r.missing, r.n_missing);
        add_names(init, "left over", r.left_over, r.n_left_over);
        if (r.note)
            cJSON_AddStringToObject(init, "mind", r.note);
    }
    lt_arena_free(arena);
    return st;
}

static lt_status info_model(const info_args *a, cJSON *root)
{
    lt_params *params = NULL;
    cli_hand hand;
    model m;
    lt_status st = cli_hand_open(NULL, NULL, &hand);

    if (st)
        return st;
    st = cli_model_new(NULL, a->model, a->config, &a->over, &hand, &params, &m);
    if (st == LT_OK)
        st = model_json(&m, root);
    if (st == LT_OK && a->init)
        st = add_init(a->init, &m, root);
    lt_params_free(params);
    cli_hand_close(&hand);
    return st;
}

/* ---- the machine ---------------------------------------------------------------------------------------- */

static void info_system(cJSON *root)
{
    cJSON_AddStringToObject(root, "palmar", PACKAGE_VERSION);
    cJSON_AddStringToObject(root, "cpu", lt_cpu_model());
    cJSON_AddStringToObject(root, "best instruction set", lt_isa_name(lt_cpu_best_isa()));
    cJSON_AddStringToObject(root, "in use", lt_isa_name(lt_k->isa));
    cJSON_AddBoolToObject(root, "8-bit dot products", lt_cpu_has_vnni(lt_cpu_best_isa()));
    cJSON_AddNumberToObject(root, "threads", lt_threads());
    cJSON_AddNumberToObject(root, "FMA peak GFLOP/s", lt_fma_peak_gflops(50));
    cJSON_AddStringToObject(root, "compiler", __VERSION__);
#ifdef HAVE_OPENCV
    cJSON_AddStringToObject(root, "images", "PNG, JPEG, and through OpenCV what it reads");
#else
    cJSON_AddStringToObject(root, "images", "PNG, JPEG");
#endif
}

/* ---- the models that come with palmar ------------------------------------------------------------------- */

static bool is_starter(const char *file)
{
    return strcmp(file, "starter") == 0 && access(file, F_OK) != 0;
}

static lt_status info_starter(cJSON *root)
{
    lt_arena *arena = lt_arena_new();
    char own[4096];
    const char *folder;
    cJSON *cards;
    lt_status st;

    cli_root(own, sizeof(own));
    folder = arena ? starter_folder(arena, own) : NULL;
    st = folder ? starter_cards(arena, folder, &cards) : lt_error(LT_ENOMEM, "no memory for the starter models");
    if (!st) {
        cJSON_AddStringToObject(root, "folder", folder);
        cJSON_AddItemToObject(root, "models", cards);
    }
    lt_arena_free(arena);
    return st;
}

int cmd_info(int argc, char **argv)
{
    info_args a = { .samples = 20 };
    cJSON *root = cJSON_CreateObject();
    lt_status st = root ? LT_OK : lt_error(LT_ENOMEM, "no memory");

    cli_parse("info", &argp, argc, argv, &a);
    if (a.system)
        info_system(root);
    if (st == LT_OK && a.model)
        st = info_model(&a, root);
    if (st == LT_OK && a.data)
        st = detection_probe(a.data) ? info_detection(a.data, root)
             : info_data(&(info_data_options){ a.data, a.setup, a.hand, a.hand_left, a.samples }, root);
    if (st == LT_OK && a.file)
        st = is_starter(a.file) ? info_starter(root) : info_file(a.file, root);
    if (!a.json && !cJSON_GetArraySize(cJSON_GetObjectItem(root, "notes")))
        cJSON_DeleteItemFromObject(root, "notes");      /* people need not read that there are none */
    if (st == LT_OK || cJSON_GetArraySize(root) > 1)
        print(root, a.json);
    cJSON_Delete(root);
    return st ? cli_fail(st) : 0;
}
