/* SPDX-License-Identifier: Apache-2.0 */
/* Films are prepared some at a time, and filmed one after the other, some frames at a time; then recorded in order. */
#include "synth/track/track.h"

#include "libtensor/base/parallel.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/coco_rle.h"
#include "libtensor/io/image/image.h"
#include "synth/preset.h"
#include "synth/track/events.h"
#include "synth/track/noise.h"
#include "synth/track/script.h"
#include "synth/world/props.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    SCRIPTS = 4, FRAMES = 50,                   /* at a time; no part of the result */
    LEAST = 40,                                 /* pixels of a thing that is in the truth */
    CLASSES = 2,                                /* of a film, at most */
    MOST_FRAMES = 3000, QUALITY = 90,
    SENSOR = 0x53454e53, DETECTIONS = 0x44455445,
};

/* What becomes of a frame; filled by whichever thread films it. */
typedef struct {
    lt_arena *arena;
    int n[CLASSES];
    synth_mot_truth truth[CLASSES][SYNTH_THINGS];
    synth_file file;
    lt_outcome outcome;
} shot;

typedef struct {
    const synth_options *opt;
    lt_arena *arena, *script_arena[SCRIPTS];
    int frames, threads, first_film;            /* frames: of a film */
    lt_hand_model *hand;
    synth_props props;
    track_script script[SCRIPTS];
    lt_outcome outcome[SCRIPTS];                /* of writing one */
    synth_frame **frame;                        /* one a thread */
    shot shot[FRAMES];
    const track_script *now;                    /* what is being filmed, from frame first on */
    int first;
    synth_mot mot[CLASSES];
    track_watch watch[CLASSES];
    track_events events;
    track_noise noise;
    int64_t done;
    synth_manifest manifest;
} run;

/* A film's classes. */
static int classes_of(const track_script *s)
{
    return s->hall ? 1 : 2;
}

static const char *class_name(const track_script *s, int c)
{
    return s->hall ? "person" : c ? "object" : "hand";
}

/* The class of a thing, -1: none of the film's. */
static int class_of(const track_script *s, int kind)
{
    if (s->hall)
        return kind == SYNTH_PERSON_THING ? 0 : -1;
    return kind == SYNTH_HAND_THING ? 0 : kind > SYNTH_HAND_THING ? 1 : -1;
}

static lt_status report(const run *r, const char *step)
{
    return synth_tell(r->opt, step, "frames", r->done, (int64_t)TRACK_FILMS * r->frames);
}

/* ---- preparing ---- */

static void script_task(void *ctx, int64_t i)
{
    run *r = ctx;

    lt_arena_reset(r->script_arena[i]);
    r->script[i] = (track_script){ .hand = r->hand, .prop = r->props.pair, .seed = r->opt->seed, .frames = r->frames };
    lt_outcome_keep(&r->outcome[i], track_script_new(r->script_arena[i], r->first_film + (int)i, &r->script[i]));
}

static lt_status prepare(run *r)
{
    lt_status st = LT_OK;

    r->frame = lt_arena_array(r->arena, (size_t)r->threads, sizeof(*r->frame));
    for (int i = 0; r->frame && i < r->threads; i++)
        if (!(r->frame[i] = synth_frame_new(TRACK_WIDTH, TRACK_HEIGHT)))
            st = LT_ENOMEM;
    for (int i = 0; i < FRAMES; i++)
        if (!(r->shot[i].arena = lt_arena_new()))
            st = LT_ENOMEM;
    for (int i = 0; i < SCRIPTS; i++)
        if (!(r->script_arena[i] = lt_arena_new()))
            st = LT_ENOMEM;
    if (st || !r->frame)
        return lt_error(LT_ENOMEM, "synth: no memory for films");
    st = synth_hand_new(r->arena, SYNTH_HAND_MANO_LIKE, &r->hand);
    if (!st)
        st = report(r, "objects");
    return st ? st : synth_props_init(&r->props);
}

/* ---- filming a frame ---- */

static bool is_person(const synth_thing *t)
{
    return t->kind == SYNTH_PERSON_THING;
}

static lt_status list_truth(const run *r, shot *s, const synth_world *w, const synth_frame *f)
{
    synth_seen *seen;
    const lt_status st = synth_world_look(s->arena, w, &r->now->stage.camera, f, r->now->hall ? is_person : NULL,
                                          &seen);

    memset(s->n, 0, sizeof(s->n));
    for (int i = 0; !st && i < w->n_things; i++) {
        const int c = class_of(r->now, w->thing[i].kind);

        if (c < 0 || seen[i].whole < LEAST)
            continue;
        s->truth[c][s->n[c]] = (synth_mot_truth){
            .id = w->thing[i].identity + (w->thing[i].kind <= SYNTH_HAND_THING), .box = seen[i].whole_box,
            .visible = synth_seen_share(&seen[i]), .counts = lt_rle_encode(s->arena, seen[i].mask, f->height, f->width),
        };
        if (!s->truth[c][s->n[c]++].counts)
            return lt_error(LT_ENOMEM, "synth: no memory for masks");
    }
    return st;
}

/* The film's sensor, with the frame's noise. */
static void develop(const run *r, int k, synth_frame *f)
{
    const uint64_t stream = lt_rng_mix(SENSOR, (uint64_t)(r->now - r->script + r->first_film));
    synth_sensor sensor = synth_sensor_random(r->opt->seed, stream);

    sensor.exposure = 0.5f * (1 + sensor.exposure);
    sensor.stream = lt_rng_mix(stream, (uint64_t)k);
    synth_sensor_image(&sensor, f);
}

static lt_status write_image(const run *r, int k, shot *s, const synth_frame *f)
{
    const track_script *now = r->now;
    char within[128];

    snprintf(within, sizeof(within), "%s/%s_%s/img1/%06d.jpg", now->evaluation ? "evaluation" : "train", now->name,
             class_name(now, 0), k + 1);
    return synth_jpeg(r->opt->out, within, f, QUALITY, &s->file);
}

static lt_status film(const run *r, int k, shot *s)
{
    synth_frame *f = r->frame[lt_thread_index()];
    synth_world *w;
    synth_scene scene;
    lt_status st;

    lt_arena_reset(s->arena);
    w = lt_arena_alloc(s->arena, sizeof(*w));
    st = w ? track_script_pose(s->arena, r->now, k, w) : lt_error(LT_ENOMEM, "synth: no memory for a frame");
    if (st)
        return st;
    scene = synth_world_scene(w, r->now->stage.room, &r->now->stage.camera);
    st = synth_render(&scene, f);
    if (!st)
        st = list_truth(r, s, w, f);
    if (st)
        return st;
    develop(r, k, f);
    return write_image(r, k, s, f);
}

static void film_task(void *ctx, int64_t i)
{
    run *r = ctx;
    shot *s = &r->shot[i];

    lt_outcome_keep(&s->outcome, film(r, r->first + (int)i, s));
}

/* ---- a film ---- */

static lt_status record(run *r, int k, const shot *s)
{
    const uint64_t film = (uint64_t)(r->now - r->script + r->first_film);
    const lt_status st = lt_outcome_tell(&s->outcome);

    if (st)
        return st;
    for (int c = 0; c < classes_of(r->now); c++) {
        lt_rng rng = lt_rng_make(r->opt->seed, lt_rng_mix(lt_rng_mix(DETECTIONS, film), (uint64_t)(CLASSES * k + c)));
        synth_mot_detection found[2 * SYNTH_THINGS];
        const int n = track_detect(&rng, s->truth[c], s->n[c], TRACK_WIDTH, TRACK_HEIGHT, found, &r->noise);
        for (int i = 0; i < s->n[c]; i++)
            synth_mot_add_truth(&r->mot[c], k, &s->truth[c][i], TRACK_WIDTH, TRACK_HEIGHT);
        for (int i = 0; i < n; i++)
            synth_mot_add_detection(&r->mot[c], k, &found[i]);
        track_events_add(&r->events, &r->watch[c], s->truth[c], s->n[c], r->now->time[k]);
    }
    r->done++;
    return synth_manifest_add(&r->manifest, &s->file, 1);
}

/* Its folder for pictures, and what will be written when all are there. */
static lt_status open_film(run *r)
{
    const track_script *s = r->now;
    const char *split = s->evaluation ? "evaluation" : "train";
    char *folder = lt_arena_printf(r->arena, "%s/%s/%s_%s/img1", r->opt->out, split, s->name, class_name(s, 0));
    lt_status st = folder ? lt_make_dirs(folder) : lt_error(LT_ENOMEM, "%s: no memory", s->name);

    memset(r->watch, 0, sizeof(r->watch));
    for (int c = 0; !st && c < classes_of(s); c++) {
        char name[32];
        snprintf(name, sizeof(name), "%s_%s", s->name, class_name(s, c));
        st = synth_mot_open(&r->mot[c], split, name);
    }
    return st;
}

static lt_status close_film(run *r)
{
    const track_script *s = r->now;
    lt_status st = LT_OK;

    for (int c = 0; !st && c < classes_of(s); c++) {
        char images[64] = "img1";
        if (c)
            snprintf(images, sizeof(images), "../%s_%s/img1", s->name, class_name(s, 0));
        st = synth_mot_close(&r->mot[c], r->opt->out, images, s->time, r->frames, TRACK_WIDTH, TRACK_HEIGHT,
                             &r->manifest);
    }
    return st;
}

static lt_status take_film(run *r)
{
    lt_status st = open_film(r);

    for (r->first = 0; !st && r->first < r->frames; r->first += FRAMES) {
        const int n = (int)lt_min_i64(FRAMES, r->frames - r->first);

        lt_parallel_for(n, film_task, r);
        for (int i = 0; !st && i < n; i++)
            st = record(r, r->first + i, &r->shot[i]);
        if (!st)
            st = report(r, "frames");
    }
    return st ? st : close_film(r);
}

static lt_status take_all(run *r)
{
    lt_status st = LT_OK;

    for (r->first_film = 0; !st && r->first_film < TRACK_FILMS; r->first_film += SCRIPTS) {
        const int n = (int)lt_min_i64(SCRIPTS, TRACK_FILMS - r->first_film);

        lt_parallel_for(n, script_task, r);
        for (int i = 0; !st && i < n; i++) {
            r->now = &r->script[i];
            st = lt_outcome_tell(&r->outcome[i]);
            st = st ? st : take_film(r);
        }
    }
    return st;
}

/* ---- the whole ---- */

static void list_figures(const run *r, synth_figure out[TRACK_FIGURES])
{
    const double boxes = (double)r->noise.boxes, corners = (double)r->noise.n_corners;
    const synth_figure all[TRACK_FIGURES] = {
        { "persons to train on", TRACK_TRAIN_PEOPLE, 30, INFINITY },
        { "persons in the evaluation alone", TRACK_NEW_PEOPLE, 10, INFINITY },
        { "crossings a film, mean", (double)r->events.crossings / TRACK_FILMS, 3, INFINITY },
        { "occlusions of 1 to 4 s, in all", (double)r->events.occlusions, 20, INFINITY },
        { "returns to the picture, in all", (double)r->events.returns, 20, INFINITY },
        { "drops of the frame rate a film", TRACK_DROPS, 3, 3 },
        { "detections: missed, share", (double)r->noise.missed / boxes, 0.07, 0.09 },
        { "detections: false boxes, share", (double)r->noise.false_boxes / boxes, 0.025, 0.035 },
        { "detections: a coordinate is off, share of the side", sqrt(r->noise.corners / corners), 0.028, 0.032 },
    };

    memcpy(out, all, sizeof(all));
}

/* Who is whose twin. */
static lt_status write_identities(run *r)
{
    synth_growing g;
    const lt_status st = synth_growing_open(&g, "identities.csv");

    if (st)
        return st;
    fprintf(g.stream, "person,split,shape,clothes,left_hand,right_hand\n");
    for (int i = 0; i < TRACK_PEOPLE; i++) {
        int body, clothes;
        track_identity(i, &body, &clothes);
        fprintf(g.stream, "%d,%s,%d,%d,%d,%d\n", i + 1, i < TRACK_TRAIN_PEOPLE ? "train" : "evaluation", body + 1,
                clothes + 1, 2 * i + 1, 2 * i + 2);
    }
    return synth_growing_write(&g, r->opt->out, "identities.csv", &r->manifest);
}

static lt_status finish(run *r, synth_figure *figure)
{
    const synth_result result = { "frames", r->done, figure, TRACK_FIGURES, .strict = r->frames >= TRACK_FRAMES };
    const lt_status st = write_identities(r);

    list_figures(r, figure);
    return st ? st : synth_finish(&r->manifest, r->opt, r->hand, &result);
}

static void clean_up(run *r)
{
    for (int c = 0; c < CLASSES; c++)
        synth_mot_fini(&r->mot[c]);
    for (int i = 0; r->frame && i < r->threads; i++)
        synth_frame_free(r->frame[i]);
    for (int i = 0; i < FRAMES; i++)
        lt_arena_free(r->shot[i].arena);
    for (int i = 0; i < SCRIPTS; i++)
        lt_arena_free(r->script_arena[i]);
    synth_props_fini(&r->props);
    lt_arena_free(r->arena);
}

lt_status synth_track(const synth_options *options, synth_figure figures[SYNTH_FIGURES], int *n)
{
    lt_arena *arena = lt_arena_new();
    run *r = arena ? lt_arena_alloc(arena, sizeof(*r)) : NULL;
    lt_status st = LT_OK;

    if (!r) {
        lt_arena_free(arena);
        return lt_error(LT_ENOMEM, "synth: no memory");
    }
    *r = (run){ .opt = options, .arena = arena, .threads = lt_threads(),
                .frames = options->frames ? options->frames / TRACK_FILMS : TRACK_FRAMES,
                .manifest = { .arena = arena, .layout = "MOTChallenge", .axes = "pixels", .width = TRACK_WIDTH,
                              .height = TRACK_HEIGHT } };
    if (r->frames < 1 || r->frames > MOST_FRAMES)
        st = lt_error(LT_EINVAL, "%d frames: preset track has %d films, and each needs 1 to %d frames", options->frames,
                      TRACK_FILMS, MOST_FRAMES);
    if (!st)
        st = prepare(r);
    if (!st)
        st = take_all(r);
    if (!st)
        st = finish(r, figures);
    *n = TRACK_FIGURES;
    clean_up(r);
    return st;
}
