/* SPDX-License-Identifier: Apache-2.0 */
/* Moments are filmed on all threads, some at a time, by all cameras; then their lines are written in order. */
#include "synth/workplace/workplace.h"

#include "libtensor/base/parallel.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "synth/preset.h"
#include "synth/workplace/export.h"
#include "synth/workplace/truth.h"
#include "synth/world/props.h"
#include "synth/write/growing.h"

#include <math.h>
#include <string.h>

enum {
    SENSOR = 0x574b5345, DEPTH = 0x574b4450,
    BATCH = 24,                                 /* moments at a time; no part of the result */
    FIGURES = 7, MOST_SECONDS = 3600,
    FILES = 3,                                  /* of a camera's frame */
};

static const double FARTHEST = 5;               /* metres that depth is measured */

/* What becomes of a moment; filled by whichever thread films it. */
typedef struct {
    bool there[RECORDING_CAMERAS];              /* the camera kept the frame */
    double stamp[RECORDING_CAMERAS];
    synth_file file[RECORDING_CAMERAS][FILES];
    lt_arena *arena;                            /* of what is exported */
    export_view view[RECORDING_CAMERAS];
    synth_growing truth;                        /* what does not depend on other moments */
    workplace_tally tally;
    lt_outcome outcome;
} shot;

typedef struct {
    const synth_options *opt;
    lt_arena *arena;
    int threads, frames, cameras, shrink;
    workplace_script script;
    synth_room *room;
    recording_rig rig;
    synth_camera camera[RECORDING_CAMERAS];
    synth_sensor sensor[RECORDING_CAMERAS];
    workplace_clock clock;
    recording_writer *out;
    workplace_export export;
    synth_frame **frame;                        /* one a thread, ... */
    lt_arena **scratch;                         /* ... for the moment that it films */
    shot *shot;                                 /* (BATCH) */
    int first;                                  /* the moment that shot 0 is of */
    synth_growing lines;                        /* truth.ndjson */
    workplace_tally tally;
    int64_t kept;                               /* frames that were written */
    synth_manifest manifest;
} run;

static lt_status report(const run *r, const char *step, int64_t done)
{
    return synth_tell(r->opt, step, "moments", done, r->frames);
}

/* ---- preparing ---------------------------------------------------------------------------------------------- */

static lt_status get_memory(run *r)
{
    const recording_camera *c = &r->rig.camera[0];
    bool ok;

    r->frame = lt_arena_array(r->arena, (size_t)r->threads, sizeof(*r->frame));
    r->scratch = lt_arena_array(r->arena, (size_t)r->threads, sizeof(*r->scratch));
    r->shot = lt_arena_array(r->arena, BATCH, sizeof(*r->shot));
    ok = r->frame && r->scratch && r->shot;
    for (int i = 0; ok && i < r->threads; i++) {
        r->frame[i] = synth_frame_new(c->width, c->height);
        r->scratch[i] = lt_arena_new();
        ok = r->frame[i] && r->scratch[i];
    }
    for (int i = 0; ok && i < BATCH; i++)
        ok = (r->shot[i].arena = lt_arena_new()) != NULL;
    return ok ? LT_OK : lt_error(LT_ENOMEM, "synth: no memory for frames");
}

static lt_status make_folders(const run *r)
{
    lt_status st = LT_OK;

    for (int c = 0; c < r->cameras && !st; c++) {
        const char *path = lt_arena_printf(r->arena, "%s/masks/%s", r->opt->out, r->rig.camera[c].name);

        st = path ? lt_make_dirs(path) : lt_error(LT_ENOMEM, "%s: no memory", r->opt->out);
    }
    return st;
}

static void choose_sensors(run *r)
{
    for (int c = 0; c < r->cameras; c++) {
        r->camera[c] = workplace_camera(&r->rig.camera[c]);
        r->sensor[c] = synth_sensor_random(r->opt->seed, lt_rng_mix(SENSOR, (uint64_t)c));
        r->sensor[c].exposure = 0.5f * (1 + r->sensor[c].exposure);
    }
}

static lt_status prepare(run *r)
{
    lt_status st = report(r, "script", 0);

    st = st ? st : workplace_script_new(r->arena, &r->script);
    st = st ? st : workplace_room(r->arena, &r->script, &r->room);
    if (st)
        return st;
    workplace_rig(&r->script, r->cameras, r->shrink, &r->rig);
    workplace_clock_draw(r->opt->seed, r->cameras, &r->clock);
    choose_sensors(r);
    st = get_memory(r);
    st = st ? st : make_folders(r);
    st = st ? st : recording_create(r->opt->out, &r->rig, &r->out);
    st = st ? st : export_open(&r->export, r->opt, &r->rig);
    return st ? st : synth_growing_open(&r->lines, "truth.ndjson");
}

/* ---- filming a moment ----------------------------------------------------------------------------------------- */

static lt_status measure_depth(const run *r, int c, int k, lt_arena *arena, const synth_frame *f, uint16_t **out)
{
    const size_t n = (size_t)f->width * (size_t)f->height;
    float *metres = lt_arena_array(arena, n, sizeof(*metres));
    const uint64_t stream = lt_rng_mix(lt_rng_mix(DEPTH, (uint64_t)c), (uint64_t)k);

    *out = lt_arena_array(arena, n, sizeof(**out));
    if (!metres || !*out)
        return lt_error(LT_ENOMEM, "synth: no memory for depth");
    synth_sensor_depth(f, r->camera[c].fx, WORKPLACE_DEPTH_STEP, FARTHEST, r->opt->seed, stream, metres);
    for (size_t i = 0; i < n; i++)
        (*out)[i] = (uint16_t)lrint(metres[i] / WORKPLACE_DEPTH_STEP);
    return LT_OK;
}

static lt_status write_mask(const run *r, int c, int k, lt_arena *arena, const synth_frame *f)
{
    const lt_image img = { f->width, f->height, 1, 8, f->label };
    const char *path = lt_arena_printf(arena, "%s/masks/%s/%06d.png", r->opt->out, r->rig.camera[c].name, k + 1);

    return path ? lt_png_write(path, &img) : lt_error(LT_ENOMEM, "%s: no memory", r->opt->out);
}

static lt_status describe(const run *r, int c, int k, synth_file out[FILES])
{
    static const char *const form[FILES] = { "%s/%06d.jpg", "%s/%06d.z16", "masks/%s/%06d.png" };
    lt_status st = LT_OK;

    for (int i = 0; i < FILES && !st; i++) {
        char within[128];

        snprintf(within, sizeof(within), form[i], r->rig.camera[c].name, k + 1);
        st = synth_describe_file(r->opt->out, within, &out[i]);
    }
    return st;
}

/* One camera's frame: drawn, measured, written. */
static lt_status shoot(const run *r, const workplace_scene *scene, int c, shot *s, const synth_seen **seen)
{
    synth_frame *f = r->frame[lt_thread_index()];
    lt_arena *scratch = r->scratch[lt_thread_index()];
    const lt_image colour = { f->width, f->height, 3, 8, &f->rgb[0][0] };
    recording_pictures pictures = { .colour = &colour };
    synth_sensor sensor = r->sensor[c];
    synth_seen *all = NULL;
    uint16_t *depth = NULL;
    lt_status st = workplace_scene_draw(scene, r->room, &r->camera[c], f);

    st = st ? st : synth_world_look(scratch, &scene->world, &r->camera[c], f, NULL, &all);
    st = st ? st : measure_depth(r, c, scene->k, scratch, f, &depth);
    if (st)
        return st;
    sensor.stream = lt_rng_mix(sensor.stream, (uint64_t)scene->k);
    synth_sensor_image(&sensor, f);
    pictures.depth = depth;
    *seen = all;
    st = recording_store(r->out, c, scene->k + 1, &pictures);
    st = st ? st : write_mask(r, c, scene->k, scratch, f);
    st = st ? st : describe(r, c, scene->k, s->file[c]);
    return st ? st : export_shoot(&r->export, s->arena, scratch, scene, c, all, depth, &s->view[c]);
}

static lt_status film(const run *r, int k, shot *s)
{
    workplace_views views = { { NULL } };
    lt_arena *scratch = r->scratch[lt_thread_index()];
    workplace_scene *scene;
    lt_status st;

    lt_arena_reset(scratch);
    lt_arena_reset(s->arena);
    st = workplace_scene_at(scratch, &r->script, r->room, k, &scene);

    for (int c = 0; c < r->cameras && !st; c++) {
        s->there[c] = workplace_stamp(&r->clock, c, k, &s->stamp[c]);
        if (s->there[c])
            st = shoot(r, scene, c, s, &views.seen[c]);
    }
    st = st ? st : synth_growing_open(&s->truth, "truth");
    if (!st)
        truth_print(s->truth.stream, scene, &r->rig, &views, &s->tally);
    return st;
}

static void film_task(void *ctx, int64_t i)
{
    run *r = ctx;
    shot *s = &r->shot[i];

    lt_outcome_keep(&s->outcome, film(r, r->first + (int)i, s));
}

/* ---- its lines ------------------------------------------------------------------------------------------------ */

static void add_tally(workplace_tally *to, const workplace_tally *t)
{
    to->miss += t->miss;
    to->wrists += t->wrists;
    to->seen += t->seen;
    to->people += t->people;
    to->held += t->held;
    to->touched += t->touched;
}

/* Frames come in the order of their stamps. */
static lt_status add_frames(run *r, int k, const shot *s, int64_t line[RECORDING_CAMERAS])
{
    bool done[RECORDING_CAMERAS] = { false };
    lt_status st = LT_OK;

    for (int n = 0; n < r->cameras && !st; n++) {
        int next = -1;

        for (int c = 0; c < r->cameras; c++)
            if (!done[c] && (next < 0 || s->stamp[c] < s->stamp[next]))
                next = c;
        done[next] = true;
        line[next] = -1;
        if (!s->there[next])
            continue;
        r->kept++;
        st = recording_add(r->out, next, k + 1, s->stamp[next], true, &line[next]);
        st = st ? st : synth_manifest_add(&r->manifest, s->file[next], FILES);
    }
    return st;
}

static void print_head(run *r, int k, const shot *s, const int64_t line[RECORDING_CAMERAS])
{
    FILE *f = r->lines.stream;

    fprintf(f, "{\"schema\":\"palmar.truth/1\",\"set\":%d,\"time\":%.6f,\"t\":[", k, workplace_time(k));
    for (int c = 0; c < r->cameras; c++)
        s->there[c] ? fprintf(f, "%s%.6f", c ? "," : "", s->stamp[c]) : fprintf(f, "%snull", c ? "," : "");
    fputs("],\"frames\":[", f);
    for (int c = 0; c < r->cameras; c++)
        line[c] >= 0 ? fprintf(f, "%s%lld", c ? "," : "", (long long)line[c]) : fprintf(f, "%snull", c ? "," : "");
    fputs("],", f);
}

static lt_status record(run *r, int k, shot *s)
{
    int64_t line[RECORDING_CAMERAS];
    lt_status st = lt_outcome_tell(&s->outcome);

    st = st ? st : add_frames(r, k, s, line);
    for (int c = 0; c < r->cameras && !st; c++)
        if (s->there[c])
            st = export_add(&r->export, c, &s->view[c], &r->manifest);
    if (st)
        return st;
    fflush(s->truth.stream);
    print_head(r, k, s, line);
    fwrite(s->truth.text, 1, s->truth.size, r->lines.stream);
    fputs("}\n", r->lines.stream);
    synth_growing_fini(&s->truth);
    add_tally(&r->tally, &s->tally);
    return LT_OK;
}

static lt_status film_all(run *r)
{
    lt_status st = LT_OK;

    for (r->first = 0; !st && r->first < r->frames; r->first += BATCH) {
        const int n = (int)lt_min_i64(BATCH, r->frames - r->first);

        lt_parallel_for(n, film_task, r);
        for (int i = 0; !st && i < n; i++)
            st = record(r, r->first + i, &r->shot[i]);
        st = st ? st : report(r, "moments", r->first + n);
    }
    return st;
}

/* ---- files ------------------------------------------------------------------------------------------------------ */

static void list_figures(const run *r, synth_figure out[FIGURES])
{
    const workplace_tally *t = &r->tally;
    const double frames = (double)r->frames * r->cameras;
    const synth_figure all[FIGURES] = {
        { "persons", r->script.n_people, 1, WORKPLACE_PEOPLE },
        { "objects", r->script.n_objects, 1, WORKPLACE_OBJECTS },
        { "frames that cameras lost, share", frames < 400 ? NAN : 1 - (double)r->kept / frames, 0.002, 0.035 },
        { "wrists off the programs and grasps, mean, metres", t->wrists ? t->miss / t->wrists : NAN, 0, 0.01 },
        { "persons in the front camera, mean visible share", t->people ? t->seen / t->people : NAN, 0.5, 1 },
        { "moments with an object in a hand, share of persons'", t->wrists ? 2.0 * t->held / t->wrists : NAN, 0, 0.7 },
        { "held objects within 5 mm of the hand, share", t->held ? (double)t->touched / t->held : NAN, 0.97, 1 },
    };

    memcpy(out, all, sizeof(all));
}

static lt_status finish(run *r, synth_figure figure[FIGURES])
{
    static const char *const files[] = { "recording.json", "frames.jsonl", "world.json" };
    const char *world = lt_path_join(r->arena, r->opt->out, "world.json");
    lt_status st = recording_close(r->out);

    r->out = NULL;
    st = st ? st : synth_growing_write(&r->lines, r->opt->out, "truth.ndjson", &r->manifest);
    if (!st)
        st = world ? truth_world(world, &r->script, r->room, &r->rig, &r->clock, r->sensor)
                   : lt_error(LT_ENOMEM, "%s: no memory", r->opt->out);
    for (size_t i = 0; i < LT_COUNT(files) && !st; i++)
        st = synth_manifest_file(&r->manifest, r->opt->out, files[i]);
    st = st ? st : export_close(&r->export, &r->script, &r->manifest);
    list_figures(r, figure);
    return st ? st : synth_finish(&r->manifest, r->opt, r->script.hand,
                                  &(synth_result){ "moments", r->frames, figure, FIGURES, false });
}

static void clean_up(run *r)
{
    recording_close(r->out);
    export_fini(&r->export);
    synth_growing_fini(&r->lines);
    for (int i = 0; i < r->threads; i++) {
        synth_frame_free(r->frame ? r->frame[i] : NULL);
        lt_arena_free(r->scratch ? r->scratch[i] : NULL);
    }
    for (int i = 0; r->shot && i < BATCH; i++) {
        synth_growing_fini(&r->shot[i].truth);
        lt_arena_free(r->shot[i].arena);
    }
    lt_arena_free(r->arena);
}

static int frames_of(const synth_options *o)
{
    const double seconds = o->seconds > 0 ? o->seconds : WORKPLACE_SECONDS;

    return o->frames ? o->frames : (int)fmax(1, rint(fmin(seconds, 2 * MOST_SECONDS) * WORKPLACE_FPS));
}

lt_status workplace_film(const synth_options *o, const workplace_means *means, int shrink,
                         synth_figure figures[SYNTH_FIGURES], int *n)
{
    lt_arena *arena = lt_arena_new();
    run *r = arena ? lt_arena_alloc(arena, sizeof(*r)) : NULL;
    lt_status st;

    if (!r) {
        lt_arena_free(arena);
        return lt_error(LT_ENOMEM, "synth: no memory");
    }
    *r = (run){ .opt = o, .arena = arena, .threads = lt_threads(), .frames = frames_of(o), .shrink = shrink,
                .cameras = o->cameras ? o->cameras : RECORDING_CAMERAS,
                .script = { .body = means->body, .hand = means->hand, .prop = means->prop, .seed = o->seed,
                            .frames = frames_of(o), .difficulty = o->difficulty } };
    r->manifest = (synth_manifest){ .arena = arena, .layout = "recording", .axes = "z up, the table's top at 0",
                                    .width = WORKPLACE_WIDTH / shrink, .height = WORKPLACE_HEIGHT / shrink };
    st = prepare(r);
    st = st ? st : film_all(r);
    st = st ? st : finish(r, figures);
    *n = FIGURES;
    clean_up(r);
    return st;
}

lt_status synth_workplace(const synth_options *o, synth_figure figures[SYNTH_FIGURES], int *n)
{
    lt_arena *arena;
    synth_props props = { .arena = { NULL } };
    synth_body body;
    lt_hand_model *hand;
    int cast[WORKPLACE_CAST];
    lt_status st;

    if (o->cameras > RECORDING_CAMERAS || frames_of(o) > MOST_SECONDS * WORKPLACE_FPS)
        return lt_error(LT_EINVAL, "%d cameras, %d moments: preset world has 1 to %d cameras and an hour at most, "
                        "%d moments", o->cameras, frames_of(o), RECORDING_CAMERAS, MOST_SECONDS * WORKPLACE_FPS);
    arena = lt_arena_new();
    st = arena ? synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand) : lt_error(LT_ENOMEM, "synth: no memory");
    st = st ? st : synth_body_new(arena, hand, &body);
    workplace_cast(o->seed, cast);
    st = st ? st : synth_tell(o, "objects", "moments", 0, frames_of(o));
    st = st ? st : synth_props_init_some(&props, cast, WORKPLACE_CAST);
    st = st ? st : workplace_film(o, &(workplace_means){ &body, hand, props.pair }, 1, figures, n);
    synth_props_fini(&props);
    lt_arena_free(arena);
    return st;
}
