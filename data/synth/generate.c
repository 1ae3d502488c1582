/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Prepares a few takes at a time, each on a thread of its own; films them one after the other, a take's frames on
 * all threads; and writes what was filmed.
 */
#include "data/synth/generate.h"

#include "data/synth/calibration.h"
#include "data/synth/cast.h"
#include "data/synth/manifest.h"
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
    const synth_options *opt;
    lt_arena *arena;                /* lives as long as the run */
    synth_cast cast;
    lt_hand_model *hand;
    uint8_t part[LT_HAND_VERTICES];
    synth_subject *subject;
    synth_prop *prop;               /* cast.n_objects of them */
    easel *easel;
    int n_easels;
    synth_manifest manifest;
    synth_stats stats;
    synth_truth truth;
    FILE *list[2];                  /* train.txt, evaluation.txt */
    lt_atomic_file list_file[2];
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
    if (r->opt->progress && !r->opt->progress(r->opt->progress_ctx, step, r->done, r->total))
        return lt_error(LT_ESTOPPED, "%s: stopped after %lld of %lld frames; it is not complete", r->opt->out,
                        (long long)r->done, (long long)r->total);
    return LT_OK;
}

static lt_status make_easels(run *r)
{
    r->n_easels = lt_threads();
    r->easel = lt_arena_array(r->arena, (size_t)r->n_easels, sizeof(*r->easel));
    for (int i = 0; r->easel && i < r->n_easels; i++) {
        easel *e = &r->easel[i];
        e->frame = synth_frame_new(SYNTH_WIDTH, SYNTH_HEIGHT);
        e->depth = lt_arena_array(r->arena, (size_t)SYNTH_WIDTH * SYNTH_HEIGHT, sizeof(*e->depth));
        if (!e->frame || !e->depth)
            return lt_error(LT_ENOMEM, "synth: no memory to draw into");
    }
    return r->easel ? LT_OK : lt_error(LT_ENOMEM, "synth: no memory to draw into");
}

static lt_status make_cast(run *r)
{
    lt_status st = synth_cast_plan(r->opt->preset, r->opt->frames, &r->cast);

    if (!st)
        st = synth_hand_new(r->arena, SYNTH_HAND_MANO_LIKE, &r->hand);
    if (st)
        return st;
    synth_hand_parts(r->hand, r->part);
    for (int i = 0; i < r->cast.n_takes; i++)
        r->total += r->cast.take[i].frames * r->cast.n_cameras;
    r->subject = lt_arena_array(r->arena, (size_t)r->cast.n_subjects, sizeof(*r->subject));
    r->prop = lt_arena_array(r->arena, (size_t)r->cast.n_objects, sizeof(*r->prop));
    if (!r->subject || !r->prop)
        return lt_error(LT_ENOMEM, "synth: no memory for the cast");
    for (int i = 0; i < r->cast.n_subjects; i++)
        synth_subject_draw(r->hand, r->opt->seed, i, &r->subject[i]);
    return LT_OK;
}

static lt_status make_props(run *r)
{
    for (int i = 0; i < r->cast.n_objects; i++) {
        synth_prop *p = &r->prop[i];
        synth_file file[4];
        lt_status st = report(r, "objects");
        if (!st)
            st = synth_prop_new(r->arena, r->cast.object[i], r->opt->alias_ycb,
                                lt_rng_mix(r->opt->seed, LABEL), p);
        if (!st)
            st = synth_write_model(r->opt->out, p->name, &p->mesh, (const uint8_t (*)[3])p->rgb,
                                   SYNTH_TEXTURE, p->points, SYNTH_POINTS, file);
        if (!st)
            st = synth_manifest_add(&r->manifest, file, 4);
        if (st)
            return st;
    }
    return LT_OK;
}

static lt_status open_lists(run *r)
{
    static const char *const name[2] = { "train.txt", "evaluation.txt" };

    for (int i = 0; i < 2; i++) {
        const char *path = lt_path_join(r->arena, r->opt->out, name[i]);
        const lt_status st = path ? lt_atomic_open(&r->list_file[i], path)
                                  : lt_error(LT_ENOMEM, "synth: no memory");
        if (st)
            return st;
        r->list[i] = r->list_file[i].stream;
    }
    return synth_truth_open(&r->truth, r->opt->out);
}

/* ---- one take ---- */

/* What becomes of a frame; filled by whichever thread draws it. */
typedef struct {
    synth_picture picture;
    synth_visibility visibility;
    synth_file file[SYNTH_FRAME_FILES];
    lt_status status;
    char line[1024];
} shot;

typedef struct {
    run *run;
    const synth_take *take;
    lt_arena *arena;                /* of the stage */
    synth_stage stage;
    lt_status status;               /* of preparing it */
    char line[1024];
    char sequence[SYNTH_MAX_CAMERAS][48];
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
    out->picture = (synth_picture){ .sequence = f->sequence[camera], .frame = f->stage.kept[k],
                                    .evaluation = f->take->evaluation, .rgb = &e->frame->rgb[0][0],
                                    .depth = e->depth, .label = e->frame->label };
    synth_annotate(&f->stage, camera, k, &hand, &out->picture);
    synth_look(&out->picture, e->frame, m->phase, f->run->part, &out->visibility);
    return synth_write_picture(f->run->opt->out, &out->picture, f->run->opt->png, quality, out->file);
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
    st = synth_manifest_add(&r->manifest, s->file, SYNTH_FRAME_FILES);
    if (!st)
        st = synth_stats_add(&r->stats, &s->visibility);
    if (st)
        return st;
    fprintf(r->list[s->picture.evaluation], "%s/%04d\n", s->picture.sequence, s->picture.frame);
    if (s->picture.evaluation)
        synth_truth_add(&r->truth, s->picture.joints, s->picture.vertices);
    r->done++;
    return LT_OK;
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
static lt_status choose_grasp(lt_arena *arena, const run *r, const synth_subject *who, const synth_prop *what,
                              uint64_t stream, synth_grasp *out)
{
    const uint64_t seed = lt_rng_mix(lt_rng_mix(r->opt->seed, GRASP), stream);
    synth_sequence_spec spec = { .object = &what->mesh };
    synth_grasp_ctx *ctx;
    synth_grasp grasp;
    lt_status st = synth_grasp_ctx_new(arena, what->id, &what->mesh, &what->sdf, r->hand, who->beta, &ctx);

    memcpy(spec.rest_wrist, who->rest_wrist, sizeof(spec.rest_wrist));
    spec.grasp = &grasp;
    for (int i = 0; !st && i < GRASPS; i++) {
        st = synth_grasp_sample(ctx, lt_rng_mix(seed, (uint64_t)i), NULL, &grasp);
        if (st)
            break;
        if (i == 0)
            *out = grasp;
        if (synth_fits_table(&spec)) {
            *out = grasp;
            break;
        }
    }
    return st ? lt_error_prefix(st, "%s", what->name) : LT_OK;
}

static const synth_prop *find_prop(const run *r, int object)
{
    int i = 0;

    while (r->prop[i].id != object)
        i++;
    return &r->prop[i];
}

static lt_status make_folders(run *r, filming *f)
{
    for (int c = 0; c < f->stage.n_cameras; c++) {
        lt_status st;
        snprintf(f->sequence[c], sizeof(f->sequence[c]), "%s%d", f->take->base, c);
        st = synth_make_sequence(r->opt->out, f->sequence[c], f->take->evaluation);
        if (st)
            return st;
    }
    if (f->stage.n_cameras == 1)
        return LT_OK;
    return synth_write_calibration(r->opt->out, f->take->base, f->stage.camera, f->stage.n_cameras,
                                   &r->manifest);
}

static lt_status prepare(filming *f)
{
    const run *r = f->run;
    const synth_take *take = f->take;
    const int number = (int)(take - r->cast.take);
    const uint64_t stream = lt_rng_mix(TAKE, (uint64_t)number);
    const synth_subject *who = &r->subject[take->subject];
    const synth_prop *what = find_prop(r, take->object);
    synth_grasp *grasp;
    lt_status st;

    f->arena = lt_arena_new();
    grasp = f->arena ? lt_arena_alloc(f->arena, sizeof(*grasp)) : NULL;
    st = grasp ? choose_grasp(f->arena, r, who, what, stream, grasp)
               : lt_error(LT_ENOMEM, "synth: no memory for a take");
    if (!st)
        st = synth_stage_new(f->arena, r->hand, who, what, grasp, take->frames, number, r->cast.n_cameras,
                             r->opt->seed, stream, &f->stage);
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
    lt_status st = f->status ? lt_error(f->status, "%s", f->line) : make_folders(f->run, f);

    return st ? st : film_all(f);
}

/* ---- the run ---- */

/* Takes first to first + n. */
static lt_status film_some(run *r, int first, int n, filming *some, shot *shots)
{
    lt_status st = LT_OK;

    for (int i = 0; i < n; i++)
        some[i] = (filming){ .run = r, .take = &r->cast.take[first + i], .shot = shots };
    lt_parallel_for(n, prepare_task, some);
    for (int i = 0; i < n; i++) {
        if (!st)
            st = film_take(&some[i]);
        lt_arena_free(some[i].arena);
    }
    return st;
}

static lt_status film_takes(run *r)
{
    shot *shots = lt_arena_array(r->arena, CHUNK, sizeof(*shots));
    filming *some = lt_arena_array(r->arena, AT_A_TIME, sizeof(*some));
    lt_status st = shots && some ? LT_OK : lt_error(LT_ENOMEM, "synth: no memory for %d frames", CHUNK);

    for (int i = 0; !st && i < r->cast.n_takes; i += AT_A_TIME) {
        const int left = r->cast.n_takes - i;

        st = film_some(r, i, left < AT_A_TIME ? left : AT_A_TIME, some, shots);
    }
    return st;
}

/* Lists and truth take their names; then the figures, and the manifest last of all. */
static lt_status finish(run *r)
{
    static const char *const file[] = { "train.txt", "evaluation.txt", "evaluation_xyz.json",
                                        "evaluation_verts.json", "stats.json" };
    lt_status st = LT_OK;

    for (int i = 0; !st && i < 2; i++) {
        r->list[i] = NULL;
        st = lt_atomic_commit(&r->list_file[i]);
    }
    if (!st)
        st = synth_truth_commit(&r->truth);
    if (!st)
        st = synth_stats_write(&r->stats, r->opt->out);
    for (size_t i = 0; !st && i < LT_COUNT(file); i++) {
        synth_file f;
        st = synth_describe_file(r->opt->out, file[i], &f);
        if (!st)
            st = synth_manifest_add(&r->manifest, &f, 1);
    }
    return st ? st : synth_manifest_write(&r->manifest, r->opt, r->hand);
}

static void clean_up(run *r)
{
    for (int i = 0; i < 2; i++)
        if (r->list[i])
            lt_atomic_abort(&r->list_file[i]);
    synth_truth_abort(&r->truth);
    for (int i = 0; r->easel && i < r->n_easels; i++)
        synth_frame_free(r->easel[i].frame);
    lt_arena_free(r->arena);
}

lt_status synth_generate(const synth_options *options, synth_figure figures[SYNTH_FIGURES])
{
    run r = { .opt = options, .arena = lt_arena_new() };
    lt_status st;

    if (!r.arena)
        return lt_error(LT_ENOMEM, "synth: no memory");
    r.manifest.arena = r.stats.arena = r.arena;
    st = make_cast(&r);
    if (!st)
        st = need_empty_folder(options->out);
    if (!st)
        st = make_easels(&r);
    if (!st)
        st = make_props(&r);
    if (!st)
        st = open_lists(&r);
    if (!st)
        st = film_takes(&r);
    if (!st)
        st = finish(&r);
    if (!st && figures)
        synth_stats_figures(&r.stats, figures);
    clean_up(&r);
    return st;
}
