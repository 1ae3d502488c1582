/* SPDX-License-Identifier: Apache-2.0 */
/* Places are prepared and their pictures taken on all threads, some places at a time; then recorded in order. */
#include "synth/detect/detect.h"

#include "libtensor/base/parallel.h"
#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "synth/detect/layout.h"
#include "synth/detect/tally.h"
#include "synth/preset.h"
#include "synth/world/props.h"
#include "synth/write/coco.h"

#include <math.h>
#include <string.h>

enum {
    PLACES = 4,                                 /* at a time; no part of the result */
    PICTURES = 25,                              /* taken in a place */
    QUALITY = 0x4a504547,
};

/* What becomes of a picture; filled by whichever thread takes it. */
typedef struct {
    lt_arena *arena;
    bool evaluation, near;
    synth_coco_image image;
    detect_sight sight[SYNTH_THINGS];
    synth_file file;
    lt_outcome outcome;
} shot;

typedef struct {
    const synth_options *opt;
    lt_arena *arena, *place_arena[PLACES];
    int64_t n, n_evaluation;
    int threads;
    lt_hand_model *hand;
    synth_props props;
    detect_place place[PLACES];
    lt_outcome outcome[PLACES];                 /* of preparing a place */
    synth_frame **frame;                        /* one a thread */
    int64_t first;                              /* number of the first picture of those that are taken now */
    shot *shot;                                 /* (PLACES * PICTURES) */
    synth_coco coco[2];                         /* train, evaluation */
    detect_tally tally;
    synth_manifest manifest;
} run;

/* ---- preparing ---- */

static void place_task(void *ctx, int64_t i)
{
    run *r = ctx;

    lt_arena_reset(r->place_arena[i]);
    r->place[i] = (detect_place){ .hand = r->hand, .prop = r->props.pair, .seed = r->opt->seed,
                                   .near = r->opt->near };
    lt_outcome_keep(&r->outcome[i], detect_place_new(r->place_arena[i], r->first / PICTURES + i, &r->place[i]));
}

static bool make_arenas(lt_arena **list, int n)
{
    for (int i = 0; i < n; i++)
        if (!(list[i] = lt_arena_new()))
            return false;
    return true;
}

static lt_status get_memory(run *r)
{
    r->shot = lt_arena_array(r->arena, PLACES * PICTURES, sizeof(*r->shot));
    r->frame = lt_arena_array(r->arena, (size_t)r->threads, sizeof(*r->frame));
    if (!r->shot || !r->frame || !make_arenas(r->place_arena, PLACES))
        return lt_error(LT_ENOMEM, "synth: no memory for pictures");
    for (int i = 0; i < r->threads; i++)
        if (!(r->frame[i] = synth_frame_new(DETECT_SIDE, DETECT_SIDE)))
            return lt_error(LT_ENOMEM, "synth: no memory for pictures");
    for (int i = 0; i < PLACES * PICTURES; i++)
        if (!(r->shot[i].arena = lt_arena_new()))
            return lt_error(LT_ENOMEM, "synth: no memory for pictures");
    return LT_OK;
}

static lt_status prepare(run *r)
{
    static const char *const folder[] = { "annotations", "train", "evaluation" };
    lt_status st = get_memory(r);

    if (!st)
        st = synth_folders(r->opt->out, folder, LT_COUNT(folder));
    if (!st)
        st = synth_hand_new(r->arena, SYNTH_HAND_MANO_LIKE, &r->hand);
    if (!st)
        st = synth_coco_open(&r->coco[0], "annotations/instances_train.json");
    if (!st)
        st = synth_coco_open(&r->coco[1], "annotations/instances_evaluation.json");
    if (!st)
        st = synth_tell(r->opt, "objects", "pictures", 0, r->n);
    return st ? st : synth_props_init(&r->props);
}

/* ---- taking a picture ---- */

static double side_of(const synth_pixels *b)
{
    return sqrt((double)(b->x1 - b->x0) * (b->y1 - b->y0));
}

/* What is seen goes into the image's list. */
static lt_status annotate(shot *s, const detect_picture *p, const synth_frame *f)
{
    synth_seen *seen;
    lt_status st = synth_world_look(s->arena, &p->world, &p->camera, f, NULL, &seen);

    for (int i = 0; !st && i < p->world.n_things; i++) {
        const synth_thing *t = &p->world.thing[i];
        const int n = s->image.n;

        if (!synth_coco_counts(&seen[i]))
            continue;
        st = synth_coco_see(s->arena, t, &seen[i], NULL, &s->image);
        s->sight[n] = (detect_sight){ .kind = t->kind, .left = t->left, .bare = p->bare[i], .cut = seen[i].cut,
                                      .side = side_of(&seen[i].box), .visible = synth_seen_share(&seen[i]) };
    }
    return st;
}

static lt_status write_image(const run *r, int64_t number, shot *s, const synth_frame *f)
{
    lt_rng rng = lt_rng_make(r->opt->seed, lt_rng_mix(QUALITY, (uint64_t)number));
    const int quality = 80 + (int)lt_rng_below(&rng, 16);
    const int64_t in_split = s->evaluation ? number : number - r->n_evaluation;
    char within[48];

    snprintf(s->image.file, sizeof(s->image.file), "%06lld.jpg", (long long)in_split + 1);
    snprintf(within, sizeof(within), "%s/%s", s->evaluation ? "evaluation" : "train", s->image.file);
    return synth_jpeg(r->opt->out, within, f, quality, &s->file);
}

static lt_status take(const run *r, int64_t i, shot *s)
{
    synth_frame *f = r->frame[lt_thread_index()];
    const int64_t number = r->first + i;
    detect_picture *p;
    synth_scene scene;
    lt_status st;

    lt_arena_reset(s->arena);
    s->evaluation = number < r->n_evaluation;
    s->image = (synth_coco_image){ .width = DETECT_SIDE, .height = DETECT_SIDE };
    p = lt_arena_alloc(s->arena, sizeof(*p));
    st = p ? detect_lay_out(s->arena, &r->place[i / PICTURES], number, p)
           : lt_error(LT_ENOMEM, "synth: no memory for a picture");
    if (st)
        return st;
    s->near = p->near;
    scene = synth_world_scene(&p->world, &p->room, &p->camera);
    st = synth_render(&scene, f);
    if (!st)
        st = annotate(s, p, f);
    if (st)
        return st;
    detect_develop(&r->place[i / PICTURES], number, f);
    return write_image(r, number, s, f);
}

static void take_task(void *ctx, int64_t i)
{
    const run *r = ctx;
    shot *s = &r->shot[i];

    lt_outcome_keep(&s->outcome, take(r, i, s));
}

static lt_status record(run *r, const shot *s)
{
    lt_status st = lt_outcome_tell(&s->outcome);

    if (st)
        return st;
    synth_coco_add(&r->coco[s->evaluation], &s->image);
    st = s->near ? LT_OK : detect_tally_add(&r->tally, s->sight, s->image.n);
    return st ? st : synth_manifest_add(&r->manifest, &s->file, 1);
}

static lt_status take_all(run *r)
{
    lt_status st = LT_OK;

    for (r->first = 0; !st && r->first < r->n; r->first += PLACES * PICTURES) {
        const int64_t n = lt_min_i64(PLACES * PICTURES, r->n - r->first), places = lt_ceil_div(n, PICTURES);

        lt_parallel_for(places, place_task, r);
        for (int64_t i = 0; !st && i < places; i++)
            st = lt_outcome_tell(&r->outcome[i]);
        if (!st)
            lt_parallel_for(n, take_task, r);
        for (int64_t i = 0; !st && i < n; i++)
            st = record(r, &r->shot[i]);
        if (!st)
            st = synth_tell(r->opt, "pictures", "pictures", r->first + n, r->n);
    }
    return st;
}

/* ---- the whole ---- */

/* So many pictures must be what they are meant to be; those of hands from near by are not counted. */
static lt_status finish(run *r, synth_figure *figure)
{
    const synth_result result = { "images", r->tally.pictures, figure, DETECT_FIGURES,
                                  .strict = r->tally.pictures >= DETECT_EVALUATION };
    lt_status st = detect_tally_figures(&r->tally, figure);

    for (int i = 0; !st && i < 2; i++)
        st = synth_coco_close(&r->coco[i], r->opt->out, &r->manifest);
    return st ? st : synth_finish(&r->manifest, r->opt, r->hand, &result);
}

static void clean_up(run *r)
{
    for (int i = 0; i < 2; i++)
        synth_coco_fini(&r->coco[i]);
    for (int i = 0; r->frame && i < r->threads; i++)
        synth_frame_free(r->frame[i]);
    for (int i = 0; r->shot && i < PLACES * PICTURES; i++)
        lt_arena_free(r->shot[i].arena);
    synth_props_fini(&r->props);
    for (int i = 0; i < PLACES; i++)
        lt_arena_free(r->place_arena[i]);
    lt_arena_free(r->arena);
}

int64_t synth_detect_evaluation(uint64_t seed, int64_t pictures)
{
    return seed == DETECT_EVALUATION_SEED ? pictures : lt_min_i64(DETECT_EVALUATION, pictures / 5);
}

lt_status synth_detect(const synth_options *options, synth_figure figures[SYNTH_FIGURES], int *n)
{
    const int64_t usual = options->seed == DETECT_EVALUATION_SEED ? DETECT_EVALUATION : DETECT_PICTURES;
    const int64_t pictures = options->frames ? options->frames : usual;
    run r = { .opt = options, .arena = lt_arena_new(), .threads = lt_threads(), .n = pictures,
              .n_evaluation = synth_detect_evaluation(options->seed, pictures) };
    lt_status st = r.arena ? LT_OK : lt_error(LT_ENOMEM, "synth: no memory");

    r.tally.arena = r.manifest.arena = r.arena;
    r.manifest.layout = "COCO";
    r.manifest.axes = "pixels";
    r.manifest.width = r.manifest.height = DETECT_SIDE;
    if (!st)
        st = prepare(&r);
    if (!st)
        st = take_all(&r);
    if (!st)
        st = finish(&r, figures);
    *n = DETECT_FIGURES;
    clean_up(&r);
    return st;
}
