/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/cli.h"

#include "cli/export_int8.h"
#include "cli/export_shapes.h"
#include "estimate/checkpoint/checkpoint.h"
#include "estimate/weights/weights.h"
#include "eval/export/export.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { FORMAT = 256, HAND, INIT, SAMPLES, SET, VARIANT, JSON, INT8, HALF, CALIBRATION, CALIBRATION_SAMPLES,
       MESH, FRAMES, RULE, ISO, SET_NAME };

typedef struct {
    const char *checkpoint, *model, *config, *init, *hand, *format, *out, *samples;
    cli_overrides over;
    int batch;
    cli_int8 int8;
    cli_shapes shapes;
    bool half, json;
} export_args;

static const struct argp_option options[] = {
    { "output", 'o', "FILE", 0, "where it goes", 0 },
    { "format", FORMAT, "FORMAT", 0,
      "onnx or safetensors, of Gaussians ply, glb or splat; default FILE's ending. Of meshes ply (the default), obj or "
      "glb", 0 },
    { "mesh", MESH, "DIR", 0, "of a run of hogs: the surfaces of hand and object in frames, as files in DIR", 0 },
    { "frames", FRAMES, "N,N-N", 0,
      "of meshes and Gaussians: which, from 0, of those that the run is validated on; default 0. Several in one glb "
      "are their surfaces, ten a second", 0 },
    { "rule", RULE, "RULE", 0, "of meshes: mean (HOGS, the default) or min (GOF) of the opacity in 16 views", 0 },
    { "iso", ISO, "LEVEL", 0, "of meshes: the opacity at the surface, between 0 and 1; default 0.6", 0 },
    { "set-name", SET_NAME, "NAME", 0,
      "the Gaussians of one set in its canonical place, as hand-01 by subject or object-05 by YCB number", 0 },
    { "batch", 'b', "N", 0, "images in a run of an ONNX file; default 0, any number", 0 },
    { "samples", SAMPLES, "FILE", 0,
      "npz of the inputs that an ONNX file was compared with, and the model's outputs", 0 },
    { "int8", INT8, NULL, 0, "a checkpoint for inference with 8-bit integers; wants --calibration", 0 },
    { "half", HALF, NULL, 0, "safetensors of a checkpoint: weights in half precision, for half of the size", 0 },
    { "calibration", CALIBRATION, "DIR", 0,
      "for --int8: the dataset, " CLI_KINDS ", whose training samples give the ranges, and "
      "whose evaluation samples are scored", 0 },
    { "calibration-samples", CALIBRATION_SAMPLES, "N", 0,
      "for --int8: training samples that are looked at; default 64", 0 },
    { "hand", HAND, "FILE", 0, "hand model (MANO_RIGHT.pkl or npz); default the one it was trained with", 0 },
    { "model", 'm', "NAME", 0,
      "hocat, unified, resnet50, efficientnet_b0, vit, csp_seg or osx, with weights of --init or untrained, instead of "
      "a checkpoint", 0 },
    { "variant", VARIANT, "NAME", 0, "of --model; default the config's, else full", 0 },
    { "config", 'c', "FILE|NAME|RUN", 0,
      "for --model: a config whose \"model\" group to use; default the paper's size", 0 },
    { "set", SET, "KEY=VALUE", 0, "for --model: override a key of the config, as model.width=16", 0 },
    { "init", INIT, "FILE", 0, "for --model: weights by name, from safetensors, .npz or a checkpoint of PyTorch", 0 },
    { "threads", 't', "N", 0, "default: the CPUs this process may use", 0 },
    { "json", JSON, NULL, 0, "what was written and compared as one JSON object", 0 },
    { 0 },
};

static const char *ending(const char *path)
{
    const char *dot = strrchr(path, '.');

    return dot ? dot + 1 : "";
}

static bool is_of_shapes(const export_args *a)
{
    return a->shapes.folder || cli_shapes_format(a->format);
}

static void check_usage(export_args *a, struct argp_state *state)
{
    if (!a->checkpoint == !a->model)
        argp_error(state, "want a checkpoint or a run's folder, or --model NAME");
    if (a->checkpoint && (a->config || a->over.n || a->init))
        argp_error(state, "--variant, --config, --set and --init go with --model; a checkpoint has them in it");
    if (!a->out && !a->shapes.folder)
        argp_error(state, "want -o FILE");
    if (!a->format)
        a->format = a->shapes.folder ? "ply" : ending(a->out);
    cli_shapes_check(state, &a->shapes, a->checkpoint, a->out, a->format);
    if (is_of_shapes(a))
        return;
    if (a->int8.wanted != (a->int8.data != NULL) || (a->int8.wanted && !a->checkpoint))
        argp_error(state, "--int8 and --calibration DIR go together, and with a checkpoint or a run's folder");
    if (strcmp(a->format, "onnx") != 0 && strcmp(a->format, "safetensors") != 0)
        argp_error(state, "format \"%s\"; want onnx, safetensors, ply, glb or splat, by --format or as FILE's "
                   "ending", a->format);
    if (strcmp(a->format, "onnx") != 0 && (a->samples || a->batch))
        argp_error(state, "--samples and --batch go with ONNX");
    if (a->half && (!a->checkpoint || a->int8.wanted || strcmp(a->format, "safetensors") != 0))
        argp_error(state, "--half is for safetensors of a checkpoint or a run's folder, without --int8");
    if (a->int8.wanted && strcmp(a->format, "safetensors") != 0)
        argp_error(state, "--int8 is written as safetensors, not as %s", a->format);
}

static error_t parse(int key, char *arg, struct argp_state *state)
{
    export_args *a = state->input;

    switch (key) {
    case 'o': a->out = arg; break;
    case 'b': a->batch = cli_number(state, "batch", arg, 0, 1024); break;
    case 'm': a->model = arg; break;
    case 'c': a->config = cli_find_config(state, arg); break;
    case 't': cli_threads(state, arg); break;
    case FORMAT: a->format = arg; break;
    case HAND: a->hand = arg; break;
    case INIT: a->init = arg; break;
    case SAMPLES: a->samples = arg; break;
    case SET: cli_override(state, &a->over, arg); break;
    case JSON: a->json = true; break;
    case HALF: a->half = true; break;
    case INT8: a->int8.wanted = true; break;
    case CALIBRATION: a->int8.data = arg; break;
    case CALIBRATION_SAMPLES: a->int8.samples = cli_number(state, "calibration-samples", arg, 1, 100000); break;
    case MESH: a->shapes.folder = arg; break;
    case FRAMES: cli_shapes_frames(state, &a->shapes, arg); break;
    case RULE: cli_shapes_rule(state, &a->shapes, arg); break;
    case ISO:
        a->shapes.of_meshes = true;
        a->shapes.iso = cli_real(state, "iso", arg, 1e-6, 1 - 1e-6);
        break;
    case SET_NAME: a->shapes.set = arg; break;
    case VARIANT: cli_override_variant(state, &a->over, arg); break;
    case ARGP_KEY_ARG:
        if (a->checkpoint)
            argp_error(state, "one checkpoint at a time");
        a->checkpoint = arg;
        break;
    case ARGP_KEY_END: check_usage(a, state); break;
    default: return ARGP_ERR_UNKNOWN;
    }
    return 0;
}

static const struct argp argp = {
    options, parse, "[CHECKPOINT|RUN]",
    "Write a model for other programs.\v"
    "onnx is one file of standard operators, with image size, normalisation, joint names and the hand's name in its "
    "metadata. It is read back and run with 16 inputs beside the model; when an output differs by more than 1e-4 of "
    "its largest value, and by more than rounding explains, no file is left. safetensors is the weights alone, those "
    "that eval and predict use, and of a run is still a checkpoint to them. --int8 makes a checkpoint whose inference "
    "reads 8-bit integers in all layers that bear it, for eval and predict; its PA-MPJPE and time are printed beside "
    "the exact model's. Of a run of hogs, --mesh writes surfaces, closed and coloured, and -o Gaussians: a frame as it "
    "is posed, or a set in its canonical place; ply has all numbers, glb KHR_gaussian_splatting, splat the least; a "
    "glb of several frames is their surfaces, which move.\n\n"
    "  palmar export runs/tiny -o tiny.onnx\n"
    "  palmar export runs/tiny/checkpoints/best.safetensors -o weights.safetensors\n"
    "  palmar export runs/tiny --int8 --calibration data/tiny -o tiny-int8.safetensors\n"
    "  palmar export runs/hogs --mesh meshes --frames 0,10 --json\n"
    "  palmar export runs/hogs -o hand.ply --set-name hand-01\n"
    "  palmar export runs/hogs -o moves.glb --frames 0-40\n"
    "  palmar export --model resnet50 --init resnet50.safetensors -o resnet50.onnx", NULL, cli_help_kinds, NULL,
};

static void print_text(const export_args *a, const export_report *r)
{
    printf("%s: %.1f MB", a->out, (double)r->bytes / 1e6);
    if (r->operators)
        printf(", %d operators of set %d, %s", r->operators, r->opset, r->any_batch ? "any batch" : "batch fixed");
    printf("\n");
    if (r->n_outputs)
        printf("read back, %d inputs: largest difference from the model\n  %-12s %10s %10s\n", EXPORT_INPUTS, "output",
               "absolute", "relative");
    for (int i = 0; i < r->n_outputs; i++)
        printf("  %-12s %10.1e %10.1e\n", r->output[i].name, r->output[i].absolute, r->output[i].relative);
}

static lt_status print_json(const export_args *a, const export_report *r)
{
    cJSON *root = cJSON_CreateObject(), *list = cJSON_AddArrayToObject(root, "outputs");

    cJSON_AddStringToObject(root, "file", a->out);
    cJSON_AddStringToObject(root, "format", a->format);
    cJSON_AddNumberToObject(root, "bytes", (double)r->bytes);
    cJSON_AddNumberToObject(root, "operators", r->operators);
    for (int i = 0; list && i < r->n_outputs; i++) {
        cJSON *one = cJSON_CreateObject();

        cJSON_AddStringToObject(one, "name", r->output[i].name);
        cJSON_AddNumberToObject(one, "absolute", r->output[i].absolute);
        cJSON_AddNumberToObject(one, "relative", r->output[i].relative);
        cJSON_AddItemToArray(list, one);
    }
    if (!list) {
        cJSON_Delete(root);
        root = NULL;
    }
    return cli_print_json(root, "the report");
}

/* Weights of a checkpoint stay one, for whatever reads checkpoints; its 8-bit ranges stay behind. */
static lt_status write_inference(const export_args *a, const char *from, const model *m, export_report *r)
{
    model floats = *m;
    struct stat s;
    lt_status st;

    floats.int8 = NULL;
    st = checkpoint_save_inference(a->out, from, &floats, a->half);
    *r = (export_report){ .bytes = st == LT_OK && stat(a->out, &s) == 0 ? (size_t)s.st_size : 0 };
    return st;
}

/* from: the checkpoint that m was loaded from, or NULL */
static lt_status write_file(const export_args *a, const char *from, const model *m, const char *hand_name)
{
    const export_options o = { .m = m, .hand_name = hand_name, .batch = a->batch, .samples = a->samples };
    export_report r;
    lt_status st;

    if (strcmp(a->format, "onnx") == 0)
        st = export_onnx(&o, a->out, &r);
    else
        st = from ? write_inference(a, from, m, &r) : export_weights(&o, a->out, &r);
    if (st == LT_OK && a->json)
        return print_json(a, &r);
    if (st == LT_OK)
        print_text(a, &r);
    return st;
}

static lt_status from_checkpoint(const export_args *a)
{
    cli_checkpoint c;
    lt_status st = cli_checkpoint_open(a->checkpoint, a->hand, &c);

    if (st == LT_OK && !a->int8.wanted && c.m.int8)
        fprintf(stderr, "%s: its 8-bit ranges stay behind: what is written computes in floats\n", c.path);
    if (st == LT_OK && a->int8.wanted)
        st = cli_checkpoint_want_hands(&c);
    if (st == LT_OK)
        st = a->int8.wanted ? cli_export_int8(&a->int8, &c, a->out, a->json) : write_file(a, c.path, &c.m, c.hand.name);
    cli_checkpoint_close(&c);
    return st;
}

static lt_status from_name(const export_args *a)
{
    cli_hand hand;
    lt_params *params = NULL;
    weights_report r;
    model m;
    lt_status st = cli_hand_open(a->hand, NULL, &hand);

    if (st == LT_OK)
        st = cli_model_new(NULL, a->model, a->config, &a->over, &hand, &params, &m);
    if (st == LT_OK && a->init)
        st = weights_init(hand.arena, a->init, &m, &r);
    if (st == LT_OK && a->init)
        fprintf(stderr, "%s: %s, names of %s%s%s%s: %d arrays loaded, %d missing, %d left over\n", a->init, r.format,
                r.family, *r.taken ? " behind \"" : "", r.taken, *r.taken ? "\"" : "", r.n_loaded, r.n_missing,
                r.n_left_over);
    else if (st == LT_OK)
        fprintf(stderr, "untrained: --init FILE gives weights\n");
    if (st == LT_OK)
        st = write_file(a, NULL, &m, hand.name);
    lt_params_free(params);
    cli_hand_close(&hand);
    return st;
}

int cmd_export(int argc, char **argv)
{
    export_args a = { .int8 = { .samples = 64 } };
    lt_status st;

    cli_parse("export", &argp, argc, argv, &a);
    if (is_of_shapes(&a))
        st = cli_export_shapes(&a.shapes, a.checkpoint, a.hand, a.out, a.format, a.json);
    else
        st = a.checkpoint ? from_checkpoint(&a) : from_name(&a);
    return st ? cli_fail(st) : 0;
}
