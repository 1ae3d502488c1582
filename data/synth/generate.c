/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Prepares a few takes at a time, each on a thread of its own; films them one after the other, a take's frames on
 * all threads; and writes what was filmed.
 */
#include "data/synth/generate.h"

#include "data/synth/layout.h"
#include "data/synth/objects.h"
#include "data/synth/stats.h"
#include "libtensor/base/parallel.h"
#include "libtensor/io/file.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>

enum {
    CHUNK = 8,                      /* frames between two reports of progress; no part of the result */
    AT_A_TIME = 8,                  /* takes prepared; no part of the result */
    GRASPS = 4,                     /* drawn for a take at most: the first that can be taken from the table */
    TAKE = 0x54414b45, LABEL = 0x4c41424c, GRASP = 0x47524153, QUALITY = 0x4a504547,
};

/* What each thread draws into. */
typedef struct {
    synth_frame *frame;
    float *depth;
} easel;

typedef struct {
    synth_session session;
    const synth_layout_ops *layout;
    uint8_t part[LT_HAND_VERTICES];
    synth_prop *prop, *mirrored;    /* cast.n_objects of them; mirrored NULL: no take has a left hand */
    easel *easel;
    int n_easels;
    synth_stats stats;
    int64_t done, total;
} run;

/* ---- preparing ---- */

static lt_status need_empty_folder(const char *path)
{
    DIR *d = opendir(path);
    struct dirent *e;
    lt_status st = LT_OK;

    if (!d && errno == ENOENT)
        return lt_make_dirs(path);
    if (!d)
        return lt_error(LT_EIO, "%s: %s", path, strerror(errno));
    while (!st && (e = readdir(d)))
        if (strcmp(e->d_name, ".") && strcmp(e->d_name, ".."))
            st = lt_error(LT_EINVAL, "%s: is not empty (it holds %s); a dataset wants a folder of its own",
                          path, e->d_name);
    closedir(d);
    return st;
}

static lt_status report(run *r, const char *step)
{
    if (r->session.opt->progress && !r->session.opt->progress(r->session.opt->progress_ctx, step, r->done, r->total))
        return lt_error(LT_ESTOPPED, "%s: stopped after %lld of %lld frames; it is not complete", r->session.opt->out,
                        (long long)r->done, (long long)r->total);
    return LT_OK;
}

static lt_status make_easels(run *r)
{
    r->n_easels = lt_threads();
    r->easel = lt_arena_array(r->session.arena, (size_t)r->n_easels, sizeof(*r->easel));
    for (int i = 0; r->easel && i < r->n_easels; i++) {
        easel *e = &r->easel[i];
        e->frame = synth_frame_new(SYNTH_WIDTH, SYNTH_HEIGHT);
        e->depth = lt_arena_array(r->session.arena, (size_t)SYNTH_WIDTH * SYNTH_HEIGHT, sizeof(*e->depth));
        if (!e->frame || !e->depth)
            return lt_error(LT_ENOMEM, "synth: no memory to draw into");
    }
    return r->easel ? LT_OK : lt_error(LT_ENOMEM, "synth: no memory to draw into");
}

static lt_status make_cast(run *r)
{
    lt_status st = r->layout->plan(r->session.opt, &r->session.cast);
    synth_subject *subject;

    if (!st)
        st = synth_hand_new(r->session.arena, SYNTH_HAND_MANO_LIKE, &r->session.hand);
    if (st)
        return st;
    synth_hand_parts(r->session.hand, r->part);
    for (int i = 0; i < r->session.cast.n_takes; i++)
        r->total += r->session.cast.take[i].frames * r->session.cast.n_cameras;
    subject = lt_arena_array(r->session.arena, (size_t)r->session.cast.n_subjects, sizeof(*subject));
    r->prop = lt_arena_array(r->session.arena, (size_t)r->session.cast.n_objects, sizeof(*r->prop));
    if (!subject || !r->prop)
        return lt_error(LT_ENOMEM, "synth: no memory for the cast");
    for (int i = 0; i < r->session.cast.n_subjects; i++)
        synth_subject_draw(r->session.hand, r->session.opt->seed, i, &subject[i]);
    r->session.subject = subject;
    return LT_OK;
}

static lt_status make_props(run *r)
{
    for (int i = 0; i < r->session.cast.n_objects; i++) {
        synth_prop *p = &r->prop[i];
        synth_file file[4];
        lt_status st = report(r, "objects");
        if (!st)
            st = synth_prop_new(r->session.arena, r->session.cast.object[i], r->session.opt->alias_ycb,
                                lt_rng_mix(r->session.opt->seed, LABEL), p);
        if (!st)
            st = synth_write_model(r->session.opt->out, p->name, &p->mesh, (const uint8_t (*)[3])p->rgb,
                                   SYNTH_TEXTURE, p->points, SYNTH_POINTS, file);
        if (!st)
            st = synth_manifest_add(&r->session.manifest, file, 4);
        if (st)
            return st;
    }
    return LT_OK;
}

/* Props in the mirror, where a take has a left hand. */
static lt_status mirror_props(run *r)
{
    const int n = r->session.cast.n_objects;
    bool left = false;

    for (int i = 0; i < r->session.cast.n_takes; i++)
        left = left || r->session.cast.take[i].left;
    if (!left)
        return LT_OK;
    r->mirrored = lt_arena_array(r->session.arena, (size_t)n, sizeof(*r->mirrored));
    if (!r->mirrored)
        return lt_error(LT_ENOMEM, "synth: no memory for the cast");
    for (int i = 0; i < n; i++) {
        lt_status st = report(r, "mirrored objects");
        if (!st)
            st = synth_prop_mirror(r->session.arena, &r->prop[i], &r->mirrored[i]);
        if (st)
            return st;
    }
    return LT_OK;
}

/* ---- one take ---- */

/* What becomes of a frame; filled by whichever thread draws it. */
typedef struct {
    synth_shot filmed;
    synth_visibility visibility;
    synth_file file[SYNTH_FRAME_FILES];
    int n_files;
    lt_status status;
    char line[1024];
} shot;

typedef struct {
    run *run;
    const synth_take *take;
    lt_arena *arena;                /* of the stage; its memory is used again for the next one */
    synth_stage stage;
    lt_status status;               /* of preparing it */
    char line[1024];
    shot *shot;                     /* CHUNK of them */
    int64_t first;                  /* number of shot[0]: camera * frames + frame */
} filming;

static lt_status film(const filming *f, int64_t number, const easel *e, shot *out)
{
    const int camera = (int)(number / f->stage.n_kept), k = (int)(number % f->stage.n_kept);
    const synth_moment *m = &f->stage.sequence.moment[f->stage.kept[k]];
    lt_rng rng = lt_rng_make(f->stage.seed, lt_rng_mix(f->stage.stream, QUALITY));
    const int quality = 85 + (int)lt_rng_below(&rng, 11);
    synth_posed_hand hand;
    lt_status st;

    synth_stage_pose(&f->stage, m, &hand);
    st = synth_stage_film(&f->stage, camera, k, &hand, e->frame, e->depth);
    if (st)
        return st;
    out->filmed = (synth_shot){
        .take = f->take, .stage = &f->stage, .camera = camera, .k = k, .rgb = &e->frame->rgb[0][0],
        .label = e->frame->label, .depth = e->depth,
        .picture = { .frame = f->stage.kept[k], .evaluation = f->take->evaluation, .rgb = &e->frame->rgb[0][0],
                     .depth = e->depth, .label = e->frame->label },
    };
    synth_annotate(&f->stage, camera, k, &hand, &out->filmed.picture);
    synth_look(&out->filmed.picture, e->frame, m->phase, f->run->part, &out->visibility);
    return f->run->layout->write(&f->run->session, &out->filmed, quality, out->file, &out->n_files);
}

static void film_task(void *ctx, int64_t i)
{
    const filming *f = ctx;
    shot *s = &f->shot[i];

    s->status = film(f, f->first + i, &f->run->easel[lt_thread_index()], s);
    if (s->status)
        snprintf(s->line, sizeof(s->line), "%s", lt_last_error());
}

/* In the frames' order, whichever thread was first. */
static lt_status record(run *r, const shot *s)
{
    lt_status st;

    if (s->status)
        return lt_error(s->status, "%s", s->line);
    st = synth_manifest_add(&r->session.manifest, s->file, s->n_files);
    if (!st)
        st = synth_stats_add(&r->stats, &s->visibility);
    if (!st)
        st = r->layout->record(&r->session, &s->filmed);
    r->done += !st;
    return st;
}

static lt_status film_all(filming *f)
{
    const int64_t n = (int64_t)f->stage.n_cameras * f->stage.n_kept;
    lt_status st = LT_OK;

    for (f->first = 0; !st && f->first < n; f->first += CHUNK) {
        const int64_t now = lt_min_i64(CHUNK, n - f->first);
        lt_parallel_for(now, film_task, f);
        for (int64_t i = 0; !st && i < now; i++)
            st = record(f->run, &f->shot[i]);
        if (!st)
            st = report(f->run, "frames");
    }
    return st;
}

/* A grasp that can be taken from the table, where one of a few can; else the first. */
static lt_status choose_grasp(const synth_grasp_ctx *ctx, const synth_subject *who, const synth_prop *what,
                              uint64_t seed, synth_grasp *out)
{
    synth_grasp grasp;
    synth_sequence_spec spec = { .grasp = &grasp, .object = &what->mesh };

    memcpy(spec.rest_wrist, who->rest_wrist, sizeof(spec.rest_wrist));
    for (int i = 0; i < GRASPS; i++) {
        const lt_status st = synth_grasp_sample(ctx, lt_rng_mix(seed, (uint64_t)i), NULL, &grasp);
        if (st)
            return lt_error_prefix(st, "%s", what->name);
        if (i == 0)
            *out = grasp;
        if (synth_fits_table(&spec)) {
            *out = grasp;
            return LT_OK;
        }
    }
    return LT_OK;
}

/* One grasp for each round of a take. */
static lt_status choose_grasps(lt_arena *arena, const run *r, const synth_subject *who, const synth_prop *what,
                               uint64_t stream, int n, synth_grasp *out)
{
    const uint64_t seed = lt_rng_mix(r->session.opt->seed, GRASP);
    synth_grasp_ctx *ctx;
    lt_status st = synth_grasp_ctx_new(arena, what->id, &what->mesh, &what->sdf, r->session.hand, who->beta, &ctx);

    if (!st && what->mirrored)
        synth_grasp_ctx_mirror(ctx);
    for (int i = 0; !st && i < n; i++)
        st = choose_grasp(ctx, who, what, lt_rng_mix(seed, synth_round_stream(stream, i)), &out[i]);
    return st;
}

static const synth_prop *find_prop(const run *r, const synth_take *take, int object)
{
    int i = 0;

    while (r->prop[i].id != object)
        i++;
    return take->left ? &r->mirrored[i] : &r->prop[i];
}

/* What the layout wants of a take; cameras: room for them. */
static synth_setting setting_of(const run *r, const synth_take *take, synth_camera *cameras)
{
    synth_setting s = { .depth_unit = r->layout->depth_unit };

    if (r->layout->cameras(&r->session, take, cameras))
        s.camera = cameras;
    for (int i = 0; i < take->n_others; i++)
        s.other[s.n_others++] = find_prop(r, take, take->other[i]);
    return s;
}

static lt_status prepare(filming *f)
{
    const run *r = f->run;
    const synth_take *take = f->take;
    const int number = (int)(take - r->session.cast.take);
    const uint64_t stream = lt_rng_mix(TAKE, (uint64_t)number);
    const synth_subject *who = &r->session.subject[take->subject];
    const synth_prop *what = find_prop(r, take, take->object);
    synth_camera cameras[SYNTH_MAX_CAMERAS];
    const synth_setting setting = setting_of(r, take, cameras);
    synth_grasp *grasp;
    lt_status st;

    grasp = lt_arena_array(f->arena, (size_t)take->rounds, sizeof(*grasp));
    st = grasp ? choose_grasps(f->arena, r, who, what, stream, take->rounds, grasp)
               : lt_error(LT_ENOMEM, "synth: no memory for a take");
    if (!st)
        st = synth_stage_new(f->arena, r->session.hand, who, what, grasp, take->rounds, take->frames, number,
                             r->session.cast.n_cameras, &setting, r->session.opt->seed, stream, &f->stage);
    return st;
}

static void prepare_task(void *ctx, int64_t i)
{
    filming *f = (filming *)ctx + i;

    f->status = prepare(f);
    if (f->status)
        snprintf(f->line, sizeof(f->line), "%s", lt_last_error());
}

static lt_status film_take(filming *f)
{
    run *r = f->run;
    lt_status st = f->status ? lt_error(f->status, "%s", f->line)
                             : r->layout->begin_take(&r->session, f->take, &f->stage);

    if (!st)
        st = film_all(f);
    return st ? st : r->layout->end_take(&r->session, f->take);
}

/* ---- the run ---- */

/* Takes first to first + n. */
static lt_status film_some(run *r, int first, int n, filming *some)
{
    lt_status st = LT_OK;

    for (int i = 0; i < n; i++)
        some[i].take = &r->session.cast.take[first + i];
    lt_parallel_for(n, prepare_task, some);
    for (int i = 0; i < n; i++) {
        if (!st)
            st = film_take(&some[i]);
        lt_arena_reset(some[i].arena);
    }
    return st;
}

/* All takes, in rooms for AT_A_TIME of them and CHUNK frames. */
static lt_status film_with(run *r, filming *some, shot *shots)
{
    lt_status st = LT_OK;

    for (int i = 0; i < AT_A_TIME; i++) {
        some[i] = (filming){ .run = r, .shot = shots, .arena = lt_arena_new() };
        if (!some[i].arena)
            st = lt_error(LT_ENOMEM, "synth: no memory for a take");
    }
    for (int i = 0; !st && i < r->session.cast.n_takes; i += AT_A_TIME)
        st = film_some(r, i, (int)lt_min_i64(AT_A_TIME, r->session.cast.n_takes - i), some);
    for (int i = 0; i < AT_A_TIME; i++)
        lt_arena_free(some[i].arena);
    return st;
}

static lt_status film_takes(run *r)
{
    shot *shots = lt_arena_array(r->session.arena, CHUNK, sizeof(*shots));
    filming *some = lt_arena_array(r->session.arena, AT_A_TIME, sizeof(*some));

    return shots && some ? film_with(r, some, shots) : lt_error(LT_ENOMEM, "synth: no memory for %d frames", CHUNK);
}

/* The layout's last files; then the figures, and the manifest last of all. */
static lt_status finish(run *r)
{
    synth_file stats;
    lt_status st = r->layout->close(&r->session);

    if (!st)
        st = synth_stats_write(&r->stats, r->session.opt->out);
    if (!st)
        st = synth_describe_file(r->session.opt->out, "stats.json", &stats);
    if (!st)
        st = synth_manifest_add(&r->session.manifest, &stats, 1);
    return st ? st : synth_manifest_write(&r->session.manifest, r->session.opt, r->session.hand);
}

static void clean_up(run *r)
{
    r->layout->abort(&r->session);
    for (int i = 0; r->easel && i < r->n_easels; i++)
        synth_frame_free(r->easel[i].frame);
    lt_arena_free(r->session.arena);
}

lt_status synth_parse_layout(const char *name, synth_layout *out)
{
    static const char *const known[] = { "ho3d", "dexycb" };

    for (size_t i = 0; i < LT_COUNT(known); i++)
        if (!strcmp(name, known[i])) {
            *out = (synth_layout)i;
            return LT_OK;
        }
    return lt_error(LT_EINVAL, "no layout \"%s\": ho3d or dexycb", name);
}

lt_status synth_generate(const synth_options *options, synth_figure figures[SYNTH_FIGURES])
{
    run r = { .session = { .opt = options, .arena = lt_arena_new() },
              .layout = options->layout == SYNTH_DEXYCB ? &synth_layout_dexycb : &synth_layout_ho3d };
    lt_status st;

    if (!r.session.arena)
        return lt_error(LT_ENOMEM, "synth: no memory");
    r.session.manifest.arena = r.stats.arena = r.session.arena;
    st = make_cast(&r);
    if (!st)
        st = need_empty_folder(options->out);
    if (!st)
        st = make_easels(&r);
    if (!st)
        st = make_props(&r);
    if (!st)
        st = mirror_props(&r);
    if (!st)
        st = r.layout->open(&r.session);
    if (!st)
        st = film_takes(&r);
    if (!st)
        st = finish(&r);
    if (!st && figures)
        synth_stats_figures(&r.stats, figures);
    clean_up(&r);
    return st;
}
