/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/cli.h"

#include "cli/vision_models.h"
#include "estimate/starter.h"
#include "pipeline/watch/watch.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { CALIBRATION = 256, DETECTOR, ESTIMATOR, BODY, REID, ACTION, PROFILE, RECORD, FILM, NO_WINDOW, SECONDS, PACE,
       JSON };

typedef struct {
    const char *source[RECORDING_CAMERAS];
    int n;
    cli_vision_names vision;
    const char *calibration, *estimator, *action, *record, *film;
    watch_profile profile;
    double seconds;
    bool fast, json, quiet, no_window;
} watch_args;

static const struct argp_option options[] = {
    { "calibration", CALIBRATION, "FILE", 0, "the cameras, in the sources' order, as a recording's recording.json has "
      "them: sizes, K, where they stand, the robot's side; of cameras that nothing is said of a guess", 0 },
    { "detector", DETECTOR, "RUN|FILE", 0, "S1: a run of csp_seg or its weights; default the small one that comes with "
      "palmar", 0 },
    { "reid", REID, "RUN|FILE", 0, "S2: a run of reid; default none: tracks go by overlap", 0 },
    { "body", BODY, "RUN|FILE", 0, "S4: a run of osx, which sees whole bodies; default none", 0 },
    { "estimator", ESTIMATOR, "RUN|FILE", 0, "S6: a run of a model of hands and objects, asked while a hand touches "
      "something; default the one that comes with palmar, if any", 0 },
    { "action", ACTION, "RUN|FILE", 0, "S9: a run of action, which tells what a body does; default none", 0 },
    { "profile", PROFILE, "NAME", 0, "cpu (default): in each set one camera of several is searched, and one body of "
      "several estimated, in turn; full: all of them", 0 },
    { "record", RECORD, "DIR", 0, "keep the frames that were looked at and what was said of them: to replay, and for "
      "palmar report", 0 },
    { "film", FILM, "FILE", 0, "a film (.mp4) of the pictures with what is known drawn in; needs OpenCV", 0 },
    { "no-window", NO_WINDOW, NULL, 0, "open no window, also where there is a display; one is closed by q", 0 },
    { "seconds", SECONDS, "S", 0, "end after so many seconds of the cameras' time", 0 },
    { "pace", PACE, "real|fast", 0, "of films and recordings: as their times say, and the newest frame wins "
      "(default); or as fast as can be, and every frame counts", 0 },
    { "json", JSON, NULL, 0, "a line of JSON for each set of frames on standard output, and a last one that sums "
      "up", 0 },
    { "quiet", 'q', NULL, 0, "no progress and no hints", 0 },
    { "threads", 't', "N", 0, "default: the CPUs this process may use", 0 },
    { 0 },
};

static int choose(struct argp_state *state, const char *option, const char *text, const char *first, const char *second)
{
    if (strcmp(text, first) != 0 && strcmp(text, second) != 0)
        argp_error(state, "--%s: found \"%s\", want %s or %s", option, text, first, second);
    return strcmp(text, second) == 0;
}

static error_t parse(int key, char *arg, struct argp_state *state)
{
    watch_args *a = state->input;

    switch (key) {
    case CALIBRATION: a->calibration = arg; break;
    case DETECTOR: a->vision.detector = arg; break;
    case ESTIMATOR: a->estimator = arg; break;
    case BODY: a->vision.body = arg; break;
    case REID: a->vision.reid = arg; break;
    case ACTION: a->action = arg; break;
    case PROFILE: a->profile = choose(state, "profile", arg, "cpu", "full") ? WATCH_FULL : WATCH_CPU; break;
    case RECORD: a->record = arg; break;
    case FILM: a->film = arg; break;
    case NO_WINDOW: a->no_window = true; break;
    case SECONDS: a->seconds = cli_real(state, "seconds", arg, 1e-3, 1e7); break;
    case PACE: a->fast = choose(state, "pace", arg, "real", "fast"); break;
    case JSON: a->json = true; break;
    case 'q': a->quiet = true; break;
    case 't': cli_threads(state, arg); break;
    case ARGP_KEY_ARG:
        if (a->n == RECORDING_CAMERAS)
            argp_error(state, "at most %d sources", RECORDING_CAMERAS);
        a->source[a->n++] = arg;
        break;
    case ARGP_KEY_END:
        if (!a->n)
            argp_error(state, "want a recording, or up to %d films, folders of images or cameras (0, /dev/video0)",
                       RECORDING_CAMERAS);
        break;
    default: return ARGP_ERR_UNKNOWN;
    }
    return 0;
}

static const struct argp argp = {
    options, parse, "RECORDING\nFILM|FOLDER|CAMERA...",
    "Watch people, hands and objects through up to four cameras: who and what is there, where in the world, what "
    "touches what, what is being done.\v"
    "A recording is a folder that --record or palmar synth --preset world made; it is looked at as it was. The newest "
    "frames win: those that come while others are looked at are dropped and counted. What a model is missing for is "
    "left out, and said. Ctrl-C ends it; all files are whole then.\n\n"
    "  palmar synth --preset world --seconds 10 --out data/world\n"
    "  palmar watch data/world --pace fast --film world.mp4 --record sessions/world\n"
    "  palmar watch 0 --json                          a camera of this machine\n"
    "  palmar report sessions/world",
    NULL, NULL, NULL,
};

/* ---- models ---- */

typedef struct {
    cli_vision_models vision;
    trained estimator, action;
    watch_models open;
} models;

static void close_models(models *m)
{
    trained_close(&m->action);
    trained_close(&m->estimator);
    cli_vision_models_close(&m->vision);
}

static lt_status open_models(const watch_args *a, models *m)
{
    lt_status st = cli_vision_models_open(&a->vision, &m->vision);

    m->open = (watch_models){ .detector = m->vision.detector, .body = m->vision.body, .embedder = m->vision.embedder };
    if (!st && a->estimator) {
        st = trained_open(a->estimator, "hand-object", NULL, &m->estimator);
        m->open.estimator = &m->estimator;
    }
    if (!st && a->action) {
        st = trained_open(a->action, "action", NULL, &m->action);
        m->open.action = &m->action;
    }
    return st;
}

/* What is not named comes with palmar, or is missing, and then how it is made is said. */
static lt_status take_starter(lt_arena *arena, watch_args *a)
{
    lt_status st = a->vision.detector ? LT_OK : cli_starter_find(arena, STARTER_DETECTOR, &a->vision.detector);

    if (!st && !a->estimator && cli_starter_find(arena, STARTER_COLOUR, &a->estimator))
        a->estimator = NULL;
    return st;
}

static void hint(const watch_args *a, const char *named, const char *option, const char *what, const char *command)
{
    if (!named && !a->quiet)
        fprintf(stderr, "no --%s, so %s; to train one: %s\n", option, what, command);
}

static void hint_all(const watch_args *a)
{
    hint(a, a->vision.body, "body", "no skeletons", "palmar synth --preset body --out data/body && "
         "palmar train --config body-tiny --data data/body --out runs/body");
    hint(a, a->estimator, "estimator", "no poses of hands and objects",
         "palmar synth --preset pretrain --out data/pretrain && "
         "palmar train --config unified-tiny --data data/pretrain --out runs/hands");
    hint(a, a->action, "action", "no actions", "palmar synth --preset actions --out data/actions && "
         "palmar train --config action-small --data data/actions --out runs/action");
    hint(a, a->vision.reid, "reid", "tracks go by overlap alone", "palmar synth --preset track --out data/track && "
         "palmar train --config reid --data data/track --out runs/reid");
}

/* ---- cameras ---- */

/* One recording, with all its cameras; or sources that are a camera each */
static lt_status open_cameras(lt_arena *arena, const watch_args *a, recording *r, watch_options *o)
{
    lt_status st = LT_OK;

    if (a->n == 1 && recording_probe(a->source[0])) {
        if (a->calibration)
            return lt_error(LT_EUSAGE, "--calibration: %s is a recording, which has its own", a->source[0]);
        st = recording_open(arena, a->source[0], r);
        o->rig = r->rig;
        o->replayed = r;
        for (int c = 0; c < o->rig.n && !st; c++)
            st = watch_recording_camera(arena, r, c, &o->camera[c]);
        return st;
    }
    if (a->calibration)
        st = recording_rig_read(arena, a->calibration, &o->rig);
    return st ? st : watch_cameras_open(arena, a->source, a->n, &o->rig, o->camera);
}

static bool stop(void)
{
    return cli_stop_requested();
}

static void progress(int64_t sets, double t)
{
    static int64_t last;

    if (sets - last < 30)
        return;
    last = sets;
    fprintf(stderr, "%lld sets of frames, %.1f s\n", (long long)sets, t);
}

static lt_status run(lt_arena *arena, const watch_args *a, const models *m)
{
    watch_options o = {
        .models = m->open, .profile = a->profile, .fast = a->fast, .seconds = a->seconds, .record = a->record,
        .film = a->film, .window = !a->no_window, .lines = a->json ? stdout : NULL, .messages = stderr, .stop = stop,
        .progress = a->quiet || a->json ? NULL : progress,
    };
    watch_summary sum;
    recording r = { .n_sets = 0 };
    lt_status st = open_cameras(arena, a, &r, &o);

    st = st ? st : watch_run(&o, &sum);
    for (int c = 0; c < RECORDING_CAMERAS; c++)
        watch_camera_close(&o.camera[c]);
    if (!st && !a->quiet && !a->json)
        printf("%lld sets of frames, %.1f a second; %lld frames captured, %lld taken, %lld dropped; age %.0f ms, 95 %% "
               "within %.0f ms\n", (long long)sum.sets, sum.fps, (long long)sum.captured, (long long)sum.taken,
               (long long)sum.dropped, sum.age_p50_ms, sum.age_p95_ms);
    return st;
}

int cmd_watch(int argc, char **argv)
{
    static watch_args a;
    static models m;
    lt_arena *arena = lt_arena_new();
    lt_status st;

    cli_parse("watch", &argp, argc, argv, &a);
    cli_catch_signals();
    st = arena ? take_starter(arena, &a) : lt_error(LT_ENOMEM, "no memory to begin");
    if (!st)
        hint_all(&a);
    st = st ? st : open_models(&a, &m);
    st = st ? st : run(arena, &a, &m);
    close_models(&m);
    lt_arena_free(arena);
    return st ? cli_fail(st) : 0;
}
