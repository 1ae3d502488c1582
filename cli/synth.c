/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/cli.h"

#include "synth/generate.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SEED = 256, FRAMES, PNG, ALIAS, LAYOUT, LIGHT, JITTER, CLIPS, DIFFICULTY, NEAR, CAMERAS, SECONDS, EXPORT };

static const struct argp_option options[] = {
    { "preset", 'p', "NAME", 0,
      "tiny (where none is named), small, or the one called default: subjects, objects, sequences; "
      "demo: as many grasps as some minutes can make; pretrain: as many grasps as frames, for first weights; "
      "hogs: two hands, four objects, light and initial poses written down, 320 x 240; "
      "detect: single pictures for detectors, as COCO has them; "
      "track: films for trackers, as MOTChallenge has them; "
      "actions: clips of skeletons that do ten things, for networks that tell them apart; "
      "body: pictures of persons at tables, for networks for whole bodies; "
      "turntable: 60 photos of one still object, with cameras, as nerfstudio has them; "
      "world: persons who act at a table, as four cameras with depth record them, with all that is true", 0 },
    { "layout", LAYOUT, "NAME", 0, "ho3d (default), or dexycb: several cameras on a ring, both hands, things on the "
      "table", 0 },
    { "out", 'o', "DIR", 0, "where to write; a folder that is not there yet, or empty", 0 },
    { "seed", SEED, "N", 0, "the same seed gives the same files; default 0", 0 },
    { "frames", FRAMES, "N", 0, "in all, dealt evenly to the sequences; default the preset's; detect, body: pictures; "
      "world: moments, in place of --seconds", 0 },
    { "cameras", CAMERAS, "N", 0, "world: 1 to 4 (default): front, two above the table, side", 0 },
    { "seconds", SECONDS, "S", 0, "world: how long it is; default 20", 0 },
    { "export", EXPORT, "FORMATS", 0, "world: coco, bop, or coco,bop: the same frames for other programs too, in "
      "folders of these names: persons, hands and objects as COCO has them, poses of objects as BOP has them, masks of "
      "what is seen and amodal ones", 0 },
    { "clips", CLIPS, "N", 0, "actions: in all, 100 for each repetition; default 2000", 0 },
    { "difficulty", DIFFICULTY, "X", 0, "actions: 0 to 1: how much joints are off, how often the object is missed, how "
      "late reaching and receiving part; default: where a baseline of speeds is right in 70 % of the windows; world: "
      "how late these two part", 0 },
    { "near", NEAR, "SHARE", 0, "detect: 0 to 1: share of pictures that show a hand or two from near by, larger than "
      "the usual ones; default 0", 0 },
    { "png", PNG, NULL, 0, "ho3d: lossless images, and masks, as v2 has them; default JPEG as in v3", 0 },
    { "light", LIGHT, "WHAT", 0, "hogs: varied (default), or fixed, the same in all frames", 0 },
    { "jitter", JITTER, NULL, 0, "hogs: multiply each frame's channels by 0.7 to 1.3", 0 },
    { "alias-ycb", ALIAS, NULL, 0, "name the objects as the real ones, without \"syn_\"", 0 },
    { "threads", 't', "N", 0, "default: the CPUs this process may use", 0 },
    { 0 },
};

static bool show_progress(void *ctx, const char *step, int64_t done, int64_t total)
{
    (void)ctx;
    cli_progress(step, done, total);
    return !cli_stop_requested();
}

/* Names between commas */
static void parse_export(struct argp_state *state, const char *arg, synth_options *o)
{
    for (const char *name = arg, *end; name; name = end ? end + 1 : NULL) {
        end = strchr(name, ',');
        const size_t n = end ? (size_t)(end - name) : strlen(name);

        if (n == 4 && strncmp(name, "coco", n) == 0)
            o->coco = true;
        else if (n == 3 && strncmp(name, "bop", n) == 0)
            o->bop = true;
        else
            argp_error(state, "--export: found \"%s\", want coco, bop or coco,bop", arg);
    }
}

static error_t parse(int key, char *arg, struct argp_state *state)
{
    synth_options *o = state->input;

    switch (key) {
    case 'p':
        if (synth_parse_preset(arg, &o->preset))
            argp_error(state, "--preset: found \"%s\", want tiny, small, demo, pretrain, default, hogs, detect, track, "
                       "actions, body, turntable or world", arg);
        break;
    case LAYOUT:
        if (synth_parse_layout(arg, &o->layout))
            argp_error(state, "--layout: found \"%s\", want ho3d or dexycb", arg);
        break;
    case 'o': o->out = arg; break;
    case 't': cli_threads(state, arg); break;
    case SEED: o->seed = (uint64_t)cli_whole(state, "seed", arg, 0, 9007199254740992.0); break;
    case FRAMES: o->frames = cli_number(state, "frames", arg, 1, 100000000); break;
    case CLIPS: o->clips = cli_number(state, "clips", arg, 1, 100000000); break;
    case DIFFICULTY: o->difficulty = cli_real(state, "difficulty", arg, 0, 1); break;
    case CAMERAS: o->cameras = cli_number(state, "cameras", arg, 1, 4); break;
    case SECONDS: o->seconds = cli_real(state, "seconds", arg, 0.1, 3600); break;
    case EXPORT: parse_export(state, arg, o); break;
    case NEAR: o->near = cli_real(state, "near", arg, 0, 1); break;
    case PNG: o->png = true; break;
    case ALIAS: o->alias_ycb = true; break;
    case JITTER: o->jitter = true; break;
    case LIGHT:
        if (strcmp(arg, "fixed") && strcmp(arg, "varied"))
            argp_error(state, "--light: found \"%s\", want varied or fixed", arg);
        o->still_light = !strcmp(arg, "fixed");
        break;
    case ARGP_KEY_END:
        if (!o->out)
            argp_error(state, "where to? give --out DIR");
        if (o->png && o->layout == SYNTH_DEXYCB)
            argp_error(state, "--png is for --layout ho3d: DexYCB's images are JPEG");
        if (o->preset != SYNTH_HOGS && (o->still_light || o->jitter))
            argp_error(state, "--light and --jitter are for --preset hogs");
        if (o->preset == SYNTH_HOGS && o->layout != SYNTH_HO3D)
            argp_error(state, "--preset hogs is for --layout ho3d");
        if (o->preset >= SYNTH_DETECT && (o->layout != SYNTH_HO3D || o->png || o->alias_ycb))
            argp_error(state, "--layout, --png and --alias-ycb are not for --preset detect, track, actions, body, "
                       "turntable or world");
        if (o->preset != SYNTH_DETECT && o->near > 0)
            argp_error(state, "--near is for --preset detect");
        if (o->preset != SYNTH_ACTIONS && o->clips)
            argp_error(state, "--clips is for --preset actions");
        if (o->preset != SYNTH_ACTIONS && o->preset != SYNTH_WORLD && o->difficulty >= 0)
            argp_error(state, "--difficulty is for --preset actions and world");
        if (o->preset != SYNTH_WORLD && (o->cameras || o->seconds > 0 || o->coco || o->bop))
            argp_error(state, "--cameras, --seconds and --export are for --preset world");
        if (o->frames && o->seconds > 0)
            argp_error(state, "--frames and --seconds both say how long the world is: give one of them");
        if (o->preset == SYNTH_ACTIONS && o->frames)
            argp_error(state, "--preset actions has --clips, which have 60 to 90 frames each, in place of --frames");
        o->difficulty = o->difficulty < 0 ? SYNTH_DIFFICULTY : o->difficulty;
        break;
    default: return ARGP_ERR_UNKNOWN;
    }
    return 0;
}

static const struct argp argp = {
    options, parse, NULL,
    "Make a synthetic dataset of hands with objects, in the layout of HO3D v3, of DexYCB, of COCO or of MOTChallenge; "
    "pictures of whole bodies; clips of skeletons; or recordings of persons who act.\v"
    "The folder reads like the real dataset; manifest.json holds seed and checksums, stats.json how much is "
    "hidden from view.\n\n  palmar synth --preset tiny --out data/tiny", NULL, NULL, NULL,
};

/* A figure that no frame bears on is NaN: nothing to warn of. */
static void warn_outside(const char *out, const synth_figure *f)
{
    if (!isnan(f->value) && !synth_figure_within(f))
        fprintf(stderr, "palmar: warning: %s/stats.json: %s: %.3f, aimed at %.2f to %.2f\n", out, f->name, f->value,
                f->lo, f->hi);
}

int cmd_synth(int argc, char **argv)
{
    synth_figure figure[SYNTH_FIGURES];
    int n;
    synth_options o = { .preset = SYNTH_TINY, .difficulty = -1, .progress = show_progress };
    lt_status st;

    cli_parse("synth", &argp, argc, argv, &o);
    cli_catch_signals();
    st = synth_generate(&o, figure, &n);
    if (st)
        return cli_fail(st);
    for (int i = 0; i < n; i++)
        warn_outside(o.out, &figure[i]);
    printf("%s\n", o.out);
    return 0;
}
