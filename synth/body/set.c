/* SPDX-License-Identifier: Apache-2.0 */
/* Places are prepared and their pictures taken on all threads, some places at a time; then recorded in order. */
#include "synth/body/set.h"

#include "libtensor/base/parallel.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "synth/body/crop.h"
#include "synth/world/props.h"
#include "synth/write/manifest.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    PLACES = 4,                                 /* at a time; no part of the result */
    PICTURES = 25,                              /* taken in a place */
    QUALITY = 0x42515541,
    FIGURES = 9,
};

/* What becomes of a picture; filled by whichever thread takes it. */
typedef struct {
    synth_file file;
    lt_status status;
    char line[512];
} shot;

typedef struct {
    const synth_options *opt;
    lt_arena *arena, *place_arena[PLACES];
    int64_t n, n_evaluation;
    int threads;
    lt_hand_model *hand;
    synth_body body;
    synth_props props;
    synth_crop_place *place;                    /* (PLACES) */
    lt_status status[PLACES];                   /* of preparing a place */
    char line[PLACES][512];
    synth_frame **small, **frame;               /* one a thread, ... */
    lt_arena **scratch;                         /* ... for the picture that it takes */
    int64_t first;                              /* number of the first place of those that are in work */
    shot *shot;                                 /* (PLACES * PICTURES) */
    body_row *truth;                    /* (n) evaluation first */
    synth_manifest manifest;
} run;

static lt_status report(const run *r, const char *step, int64_t done)
{
    const synth_options *o = r->opt;

    if (o->progress && !o->progress(o->progress_ctx, step, done, r->n))
        return lt_error(LT_ESTOPPED, "%s: stopped after %lld of %lld pictures; it is not complete", o->out,
                        (long long)done, (long long)r->n);
    return LT_OK;
}

/* ---- preparing ----------------------------------------------------------------------------------------- */

static int64_t evaluation_places(const run *r) { return lt_ceil_div(r->n_evaluation, PICTURES); }

static int64_t places(const run *r)
{
    return evaluation_places(r) + lt_ceil_div(r->n - r->n_evaluation, PICTURES);
}

/* The number of a place's picture k, -1: it takes no more. Places are of one split, so that people are. */
static int64_t picture_number(const run *r, int64_t place, int64_t k)
{
    const int64_t e = evaluation_places(r), from = place < e ? 0 : r->n_evaluation;
    const int64_t i = from + (place < e ? place : place - e) * PICTURES + k;

    return i < (place < e ? r->n_evaluation : r->n) ? i : -1;
}

static void place_task(void *ctx, int64_t i)
{
    run *r = ctx;

    lt_arena_reset(r->place_arena[i]);
    r->place[i] = (synth_crop_place){ .body = &r->body, .hand = r->hand, .prop = r->props.pair, .seed = r->opt->seed,
                                      .number = r->first + i };
    r->status[i] = synth_crop_place_new(r->place_arena[i], &r->place[i]);
    if (r->status[i])
        snprintf(r->line[i], sizeof(r->line[i]), "%s", lt_last_error());
}

static lt_status get_memory(run *r)
{
    r->shot = lt_arena_array(r->arena, PLACES * PICTURES, sizeof(*r->shot));
    r->place = lt_arena_array(r->arena, PLACES, sizeof(*r->place));
    r->frame = lt_arena_array(r->arena, (size_t)r->threads, sizeof(*r->frame));
    r->small = lt_arena_array(r->arena, (size_t)r->threads, sizeof(*r->small));
    r->scratch = lt_arena_array(r->arena, (size_t)r->threads, sizeof(*r->scratch));
    r->truth = lt_arena_array(r->arena, (size_t)r->n, sizeof(*r->truth));
    bool ok = r->shot && r->place && r->frame && r->small && r->scratch && r->truth;
    for (int i = 0; ok && i < r->threads; i++) {
        r->frame[i] = synth_frame_new(BODY_PICTURE_WIDTH, BODY_PICTURE_HEIGHT);
        r->small[i] = synth_frame_new(SYNTH_BODY_LOOK_WIDTH, SYNTH_BODY_LOOK_HEIGHT);
        r->scratch[i] = lt_arena_new();
        ok = r->frame[i] && r->small[i] && r->scratch[i];
    }
    for (int i = 0; ok && i < PLACES; i++)
        ok = (r->place_arena[i] = lt_arena_new()) != NULL;
    return ok ? LT_OK : lt_error(LT_ENOMEM, "synth: no memory for pictures");
}

static lt_status make_folders(const run *r)
{
    static const char *const folder[] = { "train", "evaluation" };
    lt_status st = LT_OK;

    for (size_t i = 0; !st && i < LT_COUNT(folder); i++) {
        char *path = lt_path_join(r->arena, r->opt->out, folder[i]);
        st = path ? lt_make_dirs(path) : lt_error(LT_ENOMEM, "%s: no memory", r->opt->out);
    }
    return st;
}

static lt_status prepare(run *r)
{
    lt_status st = get_memory(r);

    if (!st)
        st = make_folders(r);
    if (!st)
        st = synth_hand_new(r->arena, SYNTH_HAND_MANO_LIKE, &r->hand);
    if (!st)
        st = synth_body_new(r->arena, r->hand, &r->body);
    if (!st)
        st = report(r, "objects", 0);
    return st ? st : synth_props_init(&r->props);
}

/* ---- taking pictures ----------------------------------------------------------------------------------- */

static lt_status write_image(const run *r, int64_t number, lt_arena *scratch, const synth_frame *f, synth_file *file)
{
    const lt_image img = { f->width, f->height, 3, 8, &f->rgb[0][0] };
    const bool evaluation = number < r->n_evaluation;
    lt_rng rng = lt_rng_make(r->opt->seed, lt_rng_mix(QUALITY, (uint64_t)number));
    const int quality = 82 + (int)lt_rng_below(&rng, 14);
    char within[48], *path;
    lt_status st;

    snprintf(within, sizeof(within), "%s/%06lld.jpg", evaluation ? "evaluation" : "train",
             (long long)(evaluation ? number : number - r->n_evaluation) + 1);
    path = lt_path_join(scratch, r->opt->out, within);
    st = path ? lt_jpeg_write(path, &img, quality) : lt_error(LT_ENOMEM, "%s: no memory", within);
    return st ? st : synth_describe_file(r->opt->out, within, file);
}

static void take_task(void *ctx, int64_t i)
{
    const run *r = ctx;
    const int64_t number = picture_number(r, r->first + i / PICTURES, i % PICTURES);
    shot *s = &r->shot[i];
    const int thread = lt_thread_index();

    s->status = LT_OK;
    if (number < 0)
        return;
    lt_arena_reset(r->scratch[thread]);
    s->status = synth_crop_take(r->scratch[thread], &r->place[i / PICTURES], number, r->small[thread], r->frame[thread],
                                &r->truth[number]);
    if (!s->status)
        s->status = write_image(r, number, r->scratch[thread], r->frame[thread], &s->file);
    if (s->status)
        snprintf(s->line, sizeof(s->line), "%s", lt_last_error());
}

static lt_status record(run *r, int64_t i)
{
    const shot *s = &r->shot[i];

    if (s->status)
        return lt_error(s->status, "%s", s->line);
    if (picture_number(r, r->first + i / PICTURES, i % PICTURES) < 0)
        return LT_OK;
    return synth_manifest_add(&r->manifest, &s->file, 1);
}

static lt_status take_all(run *r)
{
    lt_status st = LT_OK;
    int64_t done = 0;

    for (r->first = 0; !st && r->first < places(r); r->first += PLACES) {
        const int64_t n = lt_min_i64(PLACES, places(r) - r->first);

        lt_parallel_for(n, place_task, r);
        for (int64_t i = 0; !st && i < n; i++)
            if (r->status[i])
                st = lt_error(r->status[i], "%s", r->line[i]);
        if (!st)
            lt_parallel_for(n * PICTURES, take_task, r);
        for (int64_t i = 0; !st && i < n * PICTURES; i++) {
            st = record(r, i);
            done += picture_number(r, r->first + i / PICTURES, i % PICTURES) >= 0;
        }
        if (!st)
            st = report(r, "pictures", done);
    }
    return st;
}

/* ---- files --------------------------------------------------------------------------------------------- */

static lt_status write_rows(run *r, const char *within, int64_t first, int64_t n)
{
    char *path = lt_path_join(r->arena, r->opt->out, within);
    synth_file file;
    lt_status st = path ? body_rows_write(r->arena, path, r->truth + first, n)
                        : lt_error(LT_ENOMEM, "%s: no memory", within);

    if (!st)
        st = synth_describe_file(r->opt->out, within, &file);
    return st ? st : synth_manifest_add(&r->manifest, &file, 1);
}

static lt_status write_body(run *r)
{
    char *path = lt_path_join(r->arena, r->opt->out, "body.npz");
    synth_file file;
    lt_status st = path ? body_file_write(path, r->body.model) : lt_error(LT_ENOMEM, "body.npz: no memory");

    if (!st)
        st = synth_describe_file(r->opt->out, "body.npz", &file);
    return st ? st : synth_manifest_add(&r->manifest, &file, 1);
}

/* ---- figures ------------------------------------------------------------------------------------------- */

static void measure(const run *r, synth_figure out[FIGURES])
{
    double cut = 0, sits = 0, holding = 0, left = 0, held = 0, in = 0, seen = 0, hand = 0, face = 0, away = 0;
    const double n = (double)r->n;

    for (int64_t i = 0; i < r->n; i++) {
        const body_row *t = &r->truth[i];

        cut += t->cut;
        sits += t->sits;
        left += t->holds[0] > 0;
        held += (t->holds[0] > 0) + (t->holds[1] > 0);
        holding += t->holds[0] > 0 || t->holds[1] > 0;
        for (int k = 0; k < BODY_NODES; k++) {
            in += t->seen[k] & 1;
            seen += t->seen[k] >> 1;
        }
        for (int k = 0; k < 2; k++)
            hand += sqrt((t->boxes[k][2] - t->boxes[k][0]) * (t->boxes[k][3] - t->boxes[k][1])) / (2 * n);
        face += sqrt((t->boxes[2][2] - t->boxes[2][0]) * (t->boxes[2][3] - t->boxes[2][1])) / n;
        away += t->trans[2] / n;
    }
    const synth_figure all[FIGURES] = {
        { "persons that the edge of the wider picture cuts off", cut / n, 0.4, 0.95 },
        { "persons who sit", sits / n, 0.45, 0.75 },
        { "persons who hold something", holding / n, 0.35, 0.75 },
        { "left hands, share of those that hold something", held > 0 ? left / held : NAN, 0.35, 0.65 },
        { "nodes in the picture, mean share", in / n / BODY_NODES, 0.7, 0.98 },
        { "nodes that nothing else hides, mean share", seen / n / BODY_NODES, 0.55, 0.95 },
        { "side of a hand, mean, pixels", hand, 14, 45 },
        { "side of a face, mean, pixels", face, 18, 60 },
        { "distance, mean, metres", away, 0.8, 2 },
    };
    memcpy(out, all, sizeof(all));
}

/* ---- the whole ----------------------------------------------------------------------------------------- */

static lt_status finish(run *r, synth_figure figure[FIGURES])
{
    synth_file stats;
    lt_status st = write_rows(r, "evaluation.npz", 0, r->n_evaluation);

    if (!st)
        st = write_rows(r, "train.npz", r->n_evaluation, r->n - r->n_evaluation);
    if (!st)
        st = write_body(r);
    measure(r, figure);
    if (!st)
        st = synth_figures_write(r->opt->out, "images", r->n, figure, FIGURES);
    if (!st)
        st = synth_describe_file(r->opt->out, "stats.json", &stats);
    if (!st)
        st = synth_manifest_add(&r->manifest, &stats, 1);
    return st ? st : synth_manifest_write(&r->manifest, r->opt, r->hand);
}

static void clean_up(run *r)
{
    for (int i = 0; i < r->threads; i++) {
        synth_frame_free(r->frame ? r->frame[i] : NULL);
        synth_frame_free(r->small ? r->small[i] : NULL);
        lt_arena_free(r->scratch ? r->scratch[i] : NULL);
    }
    synth_props_fini(&r->props);
    for (int i = 0; i < PLACES; i++)
        lt_arena_free(r->place_arena[i]);
    lt_arena_free(r->arena);
}

lt_status synth_body_set(const synth_options *options, synth_figure figures[SYNTH_FIGURES], int *n)
{
    const int64_t pictures = options->frames ? options->frames : BODY_PICTURES;
    run r = { .opt = options, .arena = lt_arena_new(), .threads = lt_threads(), .n = pictures,
              .n_evaluation = lt_min_i64(BODY_EVALUATION, pictures / 5) };
    synth_figure figure[FIGURES];
    lt_status st = r.arena ? prepare(&r) : lt_error(LT_ENOMEM, "synth: no memory");

    r.manifest = (synth_manifest){ .arena = r.arena, .layout = "body crops", .axes = "x right, y down, z forward",
                                   .width = BODY_PICTURE_WIDTH, .height = BODY_PICTURE_HEIGHT };
    if (!st)
        st = take_all(&r);
    if (!st)
        st = finish(&r, figure);
    if (!st && figures) {
        memcpy(figures, figure, sizeof(figure));
        *n = FIGURES;
    }
    clean_up(&r);
    return st;
}
