/* SPDX-License-Identifier: Apache-2.0 */
/*
 * While some takes are filmed the next ones are prepared, and frames of different takes stand side by side: so no
 * thread waits for the end of a take. What was filmed is recorded in the frames' order.
 */
#include "synth/film.h"

#include "libtensor/base/parallel.h"
#include "synth/preset.h"

#include <stdio.h>
#include <string.h>

enum {
    TAKES_A_THREAD = 3,             /* prepared at a time; no part of the result */
    FRAMES_A_THREAD = 8,            /* filmed at a time; no part of the result */
    MOTIONS = 4,                    /* drawn for a take at most where hand and object must be apart */
    LIGHT_EVERY = 6,                /* frames whose light is looked at */
    TAKE = 0x54414b45, QUALITY = 0x4a504547,
};

/* A take under way. */
typedef struct {
    const synth_run *run;
    const synth_take *take;
    lt_arena *arena;                /* of the stage; its memory is used again for a later one */
    synth_stage stage;
    void *own;                      /* the layout's */
    lt_outcome outcome;             /* of preparing it */
} filming;

typedef struct {
    filming *take;                  /* room for TAKES_A_THREAD */
    int n;
} batch;

/* What each thread draws into. */
typedef struct {
    synth_frame *frame;
    float *depth;
} easel;

/* What becomes of a frame; filled by whichever thread draws it. */
typedef struct {
    const filming *of;
    const easel *easels;
    int64_t number;                 /* in its take: camera * frames + frame */
    synth_shot filmed;
    synth_visibility visibility;
    double light[2];                /* synth_stage_light_parts, where it is looked at */
    synth_file file[SYNTH_FRAME_FILES];
    int n_files;
    lt_outcome outcome;
} shot;

typedef struct {
    synth_run *run;
    int threads;
    easel *easel;                   /* one a thread */
    batch batch[2];
    shot *shot;                     /* FRAMES_A_THREAD */
} studio;

lt_status synth_report(synth_run *r, const char *step)
{
    return synth_tell(r->session.opt, step, "frames", r->done, r->total);
}

/* ---- preparing a take ---- */

static const synth_prop *find_prop(const synth_run *r, const synth_take *take, int object)
{
    int i = 0;

    while (r->prop[i].id != object)
        i++;
    return take->left ? &r->mirrored[i] : &r->prop[i];
}

/* What the layout wants of a take; cameras: room for them. */
static synth_setting setting_of(const synth_run *r, const synth_take *take, synth_camera *cameras)
{
    synth_setting s = { .depth_unit = r->layout->depth_unit, .shrink = r->session.cast.shrink,
                        .apart = r->session.cast.hogs };

    if (r->layout->cameras(&r->session, take, cameras))
        s.camera = cameras;
    for (int i = 0; i < take->n_others; i++)
        s.other[s.n_others++] = find_prop(r, take, take->other[i]);
    return s;
}

static lt_status prepare(filming *f)
{
    const synth_run *r = f->run;
    const synth_take *take = f->take;
    const int number = (int)(take - r->session.cast.take);
    const synth_subject *who = &r->session.subject[take->subject];
    const synth_prop *what = find_prop(r, take, take->object);
    synth_grasp *grasp = lt_arena_array(f->arena, (size_t)take->rounds, sizeof(*grasp));
    const synth_options *opt = r->session.opt;
    const synth_light_spec light = { .varied = !opt->still_light, .jitter = opt->jitter, .seed = opt->seed,
                                     .stream = lt_rng_mix(TAKE, (uint64_t)number), .frames = take->frames };
    synth_camera cameras[SYNTH_MAX_CAMERAS];
    synth_stage_spec spec = {
        .hand = r->session.hand, .subject = who, .prop = what, .grasp = grasp, .n_grasps = take->rounds,
        .n_frames = take->frames, .n_cameras = r->session.cast.n_cameras, .number = number,
        .setting = setting_of(r, take, cameras), .seed = opt->seed,
    };
    lt_status st = grasp ? LT_ENUMERIC : lt_error(LT_ENOMEM, "synth: no memory for a take");

    spec.setting.light = r->session.cast.hogs ? &light : NULL;
    for (int i = 0; st == LT_ENUMERIC && i < MOTIONS; i++) {
        spec.stream = synth_round_stream(light.stream, i);
        st = synth_choose_grasps(f->arena, &spec, grasp);
        if (!st)
            st = synth_stage_new(f->arena, &spec, &f->stage);
        if (!r->session.cast.hogs)
            break;
    }
    return st;
}

static void prepare_task(void *ctx, int64_t i)
{
    filming *f = &((batch *)ctx)->take[i];

    lt_outcome_keep(&f->outcome, prepare(f));
}

/* ---- filming a frame ---- */

static lt_status film(shot *s)
{
    const filming *f = s->of;
    const easel *e = &s->easels[lt_thread_index()];
    const int camera = (int)(s->number / f->stage.n_kept), k = (int)(s->number % f->stage.n_kept);
    const synth_moment *m = &f->stage.sequence.moment[f->stage.kept[k]];
    lt_rng rng = lt_rng_make(f->stage.seed, lt_rng_mix(f->stage.stream, QUALITY));
    const int quality = 85 + (int)lt_rng_below(&rng, 11);
    synth_posed_hand hand;
    lt_status st;

    synth_stage_pose(&f->stage, m, &hand);
    if (f->stage.lit && f->stage.light.varied && k % LIGHT_EVERY == 0) {
        st = synth_stage_light_parts(&f->stage, camera, k, &hand, e->frame, s->light);
        if (st)
            return st;
    }
    st = synth_stage_film(&f->stage, camera, k, &hand, e->frame, e->depth);
    if (st)
        return st;
    s->filmed = (synth_shot){
        .take = f->take, .stage = &f->stage, .own = f->own, .camera = camera, .k = k, .rgb = &e->frame->rgb[0][0],
        .label = e->frame->label, .depth = e->depth,
        .picture = { .frame = f->stage.kept[k], .evaluation = f->take->evaluation, .rgb = &e->frame->rgb[0][0],
                     .depth = e->depth, .label = e->frame->label },
    };
    synth_annotate(&f->stage, camera, k, &hand, &s->filmed.picture);
    synth_annotate_contact(&f->stage, &s->filmed.picture);
    synth_look(&s->filmed.picture, e->frame, m->phase, f->run->part, &s->visibility);
    return f->run->layout->write(&f->run->session, &s->filmed, quality, s->file, &s->n_files);
}

static void film_task(void *ctx, int64_t i)
{
    shot *s = &((shot *)ctx)[i];

    lt_outcome_keep(&s->outcome, film(s));
}

static int64_t frames_of(const filming *f)
{
    return (int64_t)f->stage.n_cameras * f->stage.n_kept;
}

/* In the frames' order, whichever thread was first; and tell how far we are. */
static lt_status record(synth_run *r, const shot *s)
{
    lt_status st = lt_outcome_tell(&s->outcome);

    if (!st)
        st = synth_manifest_add(&r->session.manifest, s->file, s->n_files);
    if (!st)
        st = synth_stats_add(&r->stats, &s->visibility);
    if (!st)
        st = r->layout->record(&r->session, &s->filmed);
    if (!st && r->session.cast.hogs)
        st = synth_hogs_record(&r->hogs, &r->session,
                               &(synth_hogs_frame){ .shot = &s->filmed, .seen = &s->visibility, .part = s->light });
    r->done += !st;
    if (!st && s->number + 1 == frames_of(s->of))
        st = r->layout->end_take(&r->session, &s->filmed);
    return st ? st : synth_report(r, "frames");
}

/* ---- takes, a batch at a time ---- */

/* The cast's takes from first on; what the batch held before is gone. */
static void fill(studio *s, int first, batch *b)
{
    const synth_cast *cast = &s->run->session.cast;

    b->n = (int)lt_min_i64(TAKES_A_THREAD * s->threads, cast->n_takes - first);
    for (int i = 0; i < b->n; i++) {
        lt_arena_reset(b->take[i].arena);
        b->take[i] = (filming){ .run = s->run, .take = &cast->take[first + i], .arena = b->take[i].arena };
    }
}

static lt_status begin(synth_run *r, batch *b)
{
    lt_status st = LT_OK;

    for (int i = 0; !st && i < b->n; i++) {
        filming *f = &b->take[i];

        st = lt_outcome_tell(&f->outcome);
        if (!st)
            st = r->layout->begin_take(&r->session, f->take, &f->stage, f->arena, &f->own);
    }
    return st;
}

/* The next frames of a batch: from number *number of take *take on. */
static int line_up(studio *s, const batch *b, int *take, int64_t *number)
{
    int n = 0;

    while (n < FRAMES_A_THREAD * s->threads && *take < b->n) {
        s->shot[n++] = (shot){ .of = &b->take[*take], .easels = s->easel, .number = (*number)++ };
        if (*number == frames_of(&b->take[*take])) {
            ++*take;
            *number = 0;
        }
    }
    return n;
}

typedef struct {
    batch *prepare;
    int n_prepare;
    shot *film;
} tasks;

static void do_task(void *ctx, int64_t i)
{
    const tasks *t = ctx;

    if (i < t->n_prepare)
        prepare_task(t->prepare, i);
    else
        film_task(t->film, i - t->n_prepare);
}

/* Film a batch; meanwhile prepare the next one. */
static lt_status film_batch(studio *s, batch *now, batch *next)
{
    tasks t = { .prepare = next, .n_prepare = next->n, .film = s->shot };
    int64_t number = 0;
    int take = 0;
    lt_status st = begin(s->run, now);

    while (!st && take < now->n) {
        const int n = line_up(s, now, &take, &number);

        lt_parallel_for(t.n_prepare + n, do_task, &t);
        t.n_prepare = 0;
        for (int i = 0; !st && i < n; i++)
            st = record(s->run, &s->shot[i]);
    }
    return st;
}

static lt_status film_cast(studio *s)
{
    batch *now = &s->batch[0], *next = &s->batch[1];
    lt_status st = LT_OK;

    fill(s, 0, next);
    lt_parallel_for(next->n, prepare_task, next);
    for (int done = next->n; !st && next->n; done += next->n) {
        batch *const spare = now;

        now = next;
        next = spare;
        fill(s, done, next);
        st = film_batch(s, now, next);
    }
    return st;
}

/* ---- the studio ---- */

static bool make_easel(lt_arena *arena, int shrink, easel *e)
{
    e->frame = synth_frame_new(SYNTH_WIDTH / shrink, SYNTH_HEIGHT / shrink);
    e->depth = lt_arena_array(arena, (size_t)SYNTH_WIDTH * SYNTH_HEIGHT, sizeof(*e->depth));
    return e->frame && e->depth;
}

static bool make_batch(lt_arena *arena, int room, batch *b)
{
    b->take = lt_arena_array(arena, (size_t)room, sizeof(*b->take));
    for (int i = 0; b->take && i < room; i++)
        if (!(b->take[i].arena = lt_arena_new()))
            return false;
    return b->take != NULL;
}

static bool open_studio(studio *s)
{
    lt_arena *arena = s->run->session.arena;

    s->easel = lt_arena_array(arena, (size_t)s->threads, sizeof(*s->easel));
    s->shot = lt_arena_array(arena, (size_t)s->threads * FRAMES_A_THREAD, sizeof(*s->shot));
    for (int i = 0; s->easel && i < s->threads; i++)
        if (!make_easel(arena, s->run->session.cast.shrink, &s->easel[i]))
            return false;
    return s->easel && s->shot && make_batch(arena, s->threads * TAKES_A_THREAD, &s->batch[0]) &&
           make_batch(arena, s->threads * TAKES_A_THREAD, &s->batch[1]);
}

static void close_studio(studio *s)
{
    for (int i = 0; s->easel && i < s->threads; i++)
        synth_frame_free(s->easel[i].frame);
    for (int b = 0; b < 2; b++)
        for (int i = 0; s->batch[b].take && i < s->threads * TAKES_A_THREAD; i++)
            lt_arena_free(s->batch[b].take[i].arena);
}

lt_status synth_film_takes(synth_run *r)
{
    studio s = { .run = r, .threads = lt_threads() };
    const lt_status st = open_studio(&s) ? film_cast(&s) : lt_error(LT_ENOMEM, "synth: no memory to film in");

    close_studio(&s);
    return st;
}
