/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/cli.h"

#include "eval/bench/bench.h"
#include "eval/bench/frames.h"
#include "eval/bench/layers.h"
#include "eval/bench/post.h"
#include "eval/bench/splat.h"
#include "eval/bench/tracks.h"
#include "libtensor/io/text/config.h"
#include "libtensor/kernels/kernels.h"
#include "models/action/action.h"
#include "models/reid/reid.h"

#include <stdio.h>
#include <string.h>

enum { RUNS = 256, SECONDS, JSON, PROFILE, SET, VARIANT, MODE, LAYER, COMPARE, INT8, POST, STREAM };

typedef struct {
    const char *model, *layer, *config, *mode;
    const char *compare;            /* another instruction set; NULL: none */
    cli_overrides over;
    int batch, runs;
    double seconds;
    bool json, profile, int8, post, stream;
} bench_args;

static const struct argp_option options[] = {
    { "model", 'm', "NAME", 0, "hocat (default), unified, resnet50, efficientnet_b0, vit, lpips, pointnet2, gpm, "
      "csp_seg, reid, osx, action, or splat, the rasteriser of Gaussians", 0 },
    { "layer", LAYER, "LAYER", 0, "a single layer instead, with cold weights; see below", 0 },
    { "variant", VARIANT, "NAME", 0, "of the model; default the config's, else full", 0 },
    { "config", 'c', "FILE|NAME|RUN|CHECKPOINT", 0,
      "a config whose \"model\" group to use; default the paper's size", 0 },
    { "set", SET, "KEY=VALUE", 0, "override a key of the config, as model.width=16; may be repeated", 0 },
    { "mode", MODE, "MODE", 0, "infer (default), train, or both", 0 },
    { "batch", 'b', "N", 0, "images at a time; default 1", 0 },
    { "threads", 't', "N", 0, "default: the CPUs this process may use", 0 },
    { "runs", RUNS, "N", 0, "timed runs; default 20", 0 },
    { "seconds", SECONDS, "S", 0, "stop after S seconds with at least three runs; default 20", 0 },
    { "compare", COMPARE, "ISA", 0, "in turn with another instruction set: generic, avx2, avx512, amx", 0 },
    { "int8", INT8, NULL, 0,
      "inference of a model with 8-bit integers, with ranges of the input it is measured with", 0 },
    { "post", POST, NULL, 0, "inference of csp_seg, and boxes and masks of 30 objects out of its maps; of reid, and a "
      "tracker's bookkeeping of 20 tracks", 0 },
    { "stream", STREAM, NULL, 0, "of action: inference of a window, and of one frame of a stream", 0 },
    { "profile", PROFILE, NULL, 0, "time by op and by layer as well", 0 },
    { "json", JSON, NULL, 0, "one JSON object a line instead of a Markdown row", 0 },
    { 0 },
};

static error_t parse(int key, char *arg, struct argp_state *state)
{
    bench_args *a = state->input;

    switch (key) {
    case 'm': a->model = arg; break;
    case 'c': a->config = cli_find_config(state, arg); break;
    case 'b': a->batch = cli_number(state, "batch", arg, 1, 1024); break;
    case 't': cli_threads(state, arg); break;
    case RUNS: a->runs = cli_number(state, "runs", arg, 3, 10000); break;
    case SECONDS: a->seconds = cli_real(state, "seconds", arg, 0, 1e6); break;
    case LAYER: a->layer = arg; break;
    case COMPARE: a->compare = arg; break;
    case JSON: a->json = true; break;
    case PROFILE: a->profile = true; break;
    case INT8: a->int8 = true; break;
    case POST: a->post = true; break;
    case STREAM: a->stream = true; break;
    case SET: cli_override(state, &a->over, arg); break;
    case MODE:
        if (strcmp(arg, "infer") && strcmp(arg, "train") && strcmp(arg, "both"))
            argp_error(state, "--mode: found \"%s\", want infer, train or both", arg);
        a->mode = arg;
        break;
    case VARIANT: cli_override_variant(state, &a->over, arg); break;
    case ARGP_KEY_END:
        if (a->int8 && (a->layer || strcmp(a->mode, "infer")))
            argp_error(state, "--int8: for the inference of a model, without --layer and --mode");
        if (a->post && (a->layer || a->compare || a->batch != 1 || strcmp(a->mode, "infer")))
            argp_error(state, "--post: for the inference of a model, one image at a time, without --layer, --mode and "
                       "--compare");
        if (a->stream && (a->post || a->compare || a->batch != 1 || strcmp(a->mode, "infer") || !a->model
                          || strcmp(a->model, action_class.name)))
            argp_error(state, "--stream: for the inference of --model action, one window at a time, without --post, "
                       "--mode and --compare");
        if (a->layer && (a->model || a->config || a->over.n))
            argp_error(state, "--layer: --model, --variant, --config and --set are for models");
        break;
    default: return ARGP_ERR_UNKNOWN;
    }
    return 0;
}

static char *help_filter(int key, const char *text, void *input)
{
    FILE *f;
    char *out = NULL;
    size_t n;

    (void)input;
    if (key != ARGP_KEY_HELP_EXTRA || (f = open_memstream(&out, &n)) == NULL)
        return (char *)text;
    fprintf(f, "Layers, with what each takes and its defaults:\n");
    layer_list(f);
    fclose(f);
    return out;
}

static const struct argp argp = {
    options, parse, NULL,
    "Measure latency and memory of a model's inference and training step, or of a single layer.\v"
    "FMA peak is what the machine's multiply-adds reach just before and after: on a shared machine a "
    "timing without it says little. PALMAR_ISA=generic|avx2|avx512|amx chooses the instruction set. A layer is "
    "measured over many copies, each with weights of its own, 100 MB together where it has that many, so that "
    "weights come from memory as in a network; its training is forward and backward.\n\n"
    "  palmar bench --model hocat --variant full --batch 1 --threads 2 --json\n"
    "  palmar bench --model splat --set model.gaussians=10000 --set model.size=224 --mode both\n"
    "  palmar bench --layer conv2d:c=256,o=256,hw=16 --compare avx2", NULL, help_filter, NULL,
};

/* What is measured: a model, or copies of a layer. */
typedef struct {
    model m;
    int copies;
    lt_params *params;
} subject;

static lt_status subject_new(const bench_args *a, const cli_hand *hand, subject *s)
{
    const bool splat = a->model && strcmp(a->model, bench_splat_class.name) == 0;

    *s = (subject){ .copies = 0 };
    if (!a->layer)
        return cli_model_new(splat ? &bench_splat_class : NULL, a->model, a->config, &a->over, hand, &s->params, &s->m);
    s->params = lt_params_new();
    return s->params ? layer_new(a->layer, hand->layer, s->params, &s->m, &s->copies)
                     : lt_error(LT_ENOMEM, "no memory for the layer");
}

static bench_options options_of(const bench_args *a, const subject *s, bool train)
{
    return (bench_options){
        .m = &s->m, .copies = s->copies, .batch = a->batch, .train = train, .runs = a->runs,
        .seconds = a->seconds, .int8 = a->int8, .alone = !a->compare && strcmp(a->mode, "infer") == 0,
    };
}

static void print(const bench_args *a, const bench *b, const bench_result *r, bool heading)
{
    if (a->json)
        bench_print_json(b, r, stdout);
    else
        bench_print(b, r, stdout, heading);
    fflush(stdout);
}

/* What comes behind a network, or beside a window: a frame of a stream */
static lt_status measure_post(const model *m, bench_result *r)
{
    int n;

    if (m->cls == &action_class) {
        r->post = "a frame of a stream, without stream 2";
        return bench_frames(m, &r->post_ms);
    }
    if (m->cls == &reid_class) {
        r->post = "bookkeeping of 20 tracks";
        return bench_tracks(&r->post_ms, &n);
    }
    r->post = "boxes and masks of 30 objects";
    return bench_post(m, &r->post_ms, &n);
}

static lt_status measure(const bench_args *a, const subject *s, bool train, bool heading)
{
    const bench_options o = options_of(a, s, train);
    bench *b;
    bench_result r;
    lt_status st = bench_new(&o, &b);

    if (st)
        return st;
    r = bench_run(b);
    if (a->post || a->stream)
        st = measure_post(&s->m, &r);
    if (st) {
        bench_free(b);
        return st;
    }
    print(a, b, &r, heading);
    bench_print_layers(b, a->json ? stderr : stdout);
    if (a->profile)
        bench_profile(b, a->json ? stderr : stdout);
    bench_free(b);
    return LT_OK;
}

static lt_status other_kernels(const char *name, lt_kernels *k)
{
    lt_isa isa;
    lt_status st = lt_isa_parse(name, &isa);

    if (st == LT_OK)
        st = lt_kernels_get(isa, k);
    return st ? lt_error_prefix(LT_EUSAGE, "--compare") : LT_OK;
}

static lt_status compare(const bench_args *a, const subject *s, bool train, bool heading)
{
    bench_options o = options_of(a, s, train);
    bench *b[2] = { NULL, NULL };
    bench_result r[2];
    lt_kernels other;
    lt_status st = other_kernels(a->compare, &other);

    if (st == LT_OK)
        st = bench_new(&o, &b[0]);
    o.kernels = &other;
    if (st == LT_OK)
        st = bench_new(&o, &b[1]);
    if (st == LT_OK) {
        bench_compare(b[0], b[1], r);
        print(a, b[0], &r[0], heading);
        print(a, b[1], &r[1], false);
        bench_print_ratio(b[0], b[1], r, stdout, a->json);
    }
    bench_free(b[0]);
    bench_free(b[1]);
    lt_kernels_use(NULL);
    return st;
}

int cmd_bench(int argc, char **argv)
{
    bench_args a = { .mode = "infer", .batch = 1, .runs = 20, .seconds = 20 };
    lt_status (*run)(const bench_args *, const subject *, bool, bool);
    cli_hand hand;
    subject s;
    lt_status st;

    cli_parse("bench", &argp, argc, argv, &a);
    st = cli_hand_open(NULL, NULL, &hand);
    if (st)
        return cli_fail(st);
    run = a.compare ? compare : measure;
    st = subject_new(&a, &hand, &s);
    if (st == LT_OK && strcmp(a.mode, "train") != 0)
        st = run(&a, &s, false, true);
    if (st == LT_OK && strcmp(a.mode, "infer") != 0)
        st = run(&a, &s, true, strcmp(a.mode, "train") == 0);
    lt_params_free(s.params);
    cli_hand_close(&hand);
    return st ? cli_fail(st) : 0;
}
