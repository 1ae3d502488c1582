/* SPDX-License-Identifier: Apache-2.0 */
/* Places are prepared and their pictures taken on all threads, some places at a time; then recorded in order. */
#include "synth/body/set.h"

#include "libtensor/base/parallel.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "synth/body/crop.h"
#include "synth/preset.h"
#include "synth/world/props.h"

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
    lt_outcome outcome;
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
    lt_outcome outcome[PLACES];                 /* of preparing a place */
    synth_frame **small, **frame;               /* one a thread, ... */
    lt_arena **scratch;                         /* ... for the picture that it takes */
    int64_t first;                              /* number of the first place of those that are in work */
    shot *shot;                                 /* (PLACES * PICTURES) */
    body_row *truth;                    /* (n) evaluation first */
    synth_manifest manifest;
} run;

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
    lt_outcome_keep(&r->outcome[i], synth_crop_place_new(r->place_arena[i], &r->place[i]));
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

static lt_status prepare(run *r)
{
    static const char *const folder[] = { "train", "evaluation" };
    lt_status st = get_memory(r);

    if (!st)
        st = synth_folders(r->opt->out, folder, LT_COUNT(folder));
    if (!st)
        st = synth_hand_new(r->arena, SYNTH_HAND_MANO_LIKE, &r->hand);
    if (!st)
        st = synth_body_new(r->arena, r->hand, &r->body);
    if (!st)
        st = synth_tell(r->opt, "objects", "pictures", 0, r->n);
    return st ? st : synth_props_init(&r->props);
}

/* ---- taking pictures ----------------------------------------------------------------------------------- */

static lt_status write_image(const run *r, int64_t number, const synth_frame *f, synth_file *file)
{
    const bool evaluation = number < r->n_evaluation;
    lt_rng rng = lt_rng_make(r->opt->seed, lt_rng_mix(QUALITY, (uint64_t)number));
    const int quality = 82 + (int)lt_rng_below(&rng, 14);
    char within[48];

    snprintf(within, sizeof(within), "%s/%06lld.jpg", evaluation ? "evaluation" : "train",
             (long long)(evaluation ? number : number - r->n_evaluation) + 1);
    return synth_jpeg(r->opt->out, within, f, quality, file);
}

static void take_task(void *ctx, int64_t i)
{
    const run *r = ctx;
    const int64_t number = picture_number(r, r->first + i / PICTURES, i % PICTURES);
    shot *s = &r->shot[i];
    const int thread = lt_thread_index();
    lt_status st = LT_OK;

    if (number >= 0) {
        lt_arena_reset(r->scratch[thread]);
        st = synth_crop_take(r->scratch[thread], &r->place[i / PICTURES], number, r->small[thread], r->frame[thread],
                             &r->truth[number]);
        st = st ? st : write_image(r, number, r->frame[thread], &s->file);
    }
    lt_outcome_keep(&s->outcome, st);
}

static lt_status record(run *r, int64_t i)
{
    const shot *s = &r->shot[i];
    const lt_status st = lt_outcome_tell(&s->outcome);

    if (st || picture_number(r, r->first + i / PICTURES, i % PICTURES) < 0)
        return st;
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
            st = lt_outcome_tell(&r->outcome[i]);
        if (!st)
            lt_parallel_for(n * PICTURES, take_task, r);
        for (int64_t i = 0; !st && i < n * PICTURES; i++) {
            st = record(r, i);
            done += picture_number(r, r->first + i / PICTURES, i % PICTURES) >= 0;
        }
        if (!st)
            st = synth_tell(r->opt, "pictures", "pictures", done, r->n);
    }
    return st;
}

/* ---- files --------------------------------------------------------------------------------------------- */

static lt_status write_rows(run *r, const char *within, int64_t first, int64_t n)
{
    char *path = lt_path_join(r->arena, r->opt->out, within);
    const lt_status st = path ? body_rows_write(r->arena, path, r->truth + first, n)
                              : lt_error(LT_ENOMEM, "%s: no memory", within);

    return st ? st : synth_manifest_file(&r->manifest, r->opt->out, within);
}

static lt_status write_body(run *r)
{
    char *path = lt_path_join(r->arena, r->opt->out, "body.npz");
    const lt_status st = path ? body_file_write(path, r->body.model) : lt_error(LT_ENOMEM, "body.npz: no memory");

    return st ? st : synth_manifest_file(&r->manifest, r->opt->out, "body.npz");
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
    const synth_result result = { "images", r->n, figure, FIGURES, false };
    lt_status st = write_rows(r, "evaluation.npz", 0, r->n_evaluation);

    if (!st)
        st = write_rows(r, "train.npz", r->n_evaluation, r->n - r->n_evaluation);
    if (!st)
        st = write_body(r);
    measure(r, figure);
    return st ? st : synth_finish(&r->manifest, r->opt, r->hand, &result);
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
    lt_status st = r.arena ? prepare(&r) : lt_error(LT_ENOMEM, "synth: no memory");

    r.manifest = (synth_manifest){ .arena = r.arena, .layout = "body crops", .axes = "x right, y down, z forward",
                                   .width = BODY_PICTURE_WIDTH, .height = BODY_PICTURE_HEIGHT };
    if (!st)
        st = take_all(&r);
    if (!st)
        st = finish(&r, figures);
    *n = FIGURES;
    clean_up(&r);
    return st;
}
