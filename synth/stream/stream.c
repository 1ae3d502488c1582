/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A stream has lanes, each of which goes from one take to the next; picture n is of lane n % LANES. A lane remembers
 * the take it is in, so that pictures that are read in order are quick, and what it holds never shows in them.
 */
#include "synth/stream/stream.h"

#include "assets/hand/hand.h"
#include "assets/ycb/objects.h"
#include "libtensor/base/parallel.h"
#include "libtensor/base/rng.h"
#include "libtensor/geometry/rotation.h"
#include "synth/stream/near.h"
#include "synth/stream/packed.h"
#include "synth/stream/truth.h"
#include "synth/take/annotate.h"
#include "synth/world/props.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LANES = 32, NAME = 32, TAKE = 0x5354524d, NEAR = 0x53544e52 };

typedef struct {
    pthread_mutex_t lock;
    lt_arena *arena;                /* of the take; its memory is used again for the next one */
    int64_t take;                   /* -1: none */
    synth_subject subject;
    synth_stage stage;
    bool near;
    detect_place place;             /* where it is of hands from near by, instead of subject and stage */
    synth_frame *frame;
    float *depth;
} lane;

typedef struct {
    dataset base;
    lt_arena *arena, *arena_of[SYNTH_OBJECTS];
    synth_stream_options o;
    const lt_hand_model *hand;
    synth_prop prop[SYNTH_OBJECTS];
    synth_props both;               /* for either hand, where hands are seen from near by */
    dataset_object object[SYNTH_OBJECTS];
    char (*name)[NAME];             /* (count) */
    packed_sample **kept;           /* (count) each its lane's to touch; NULL: not kept */
    atomic_size_t kept_bytes;
    lane lane[LANES];
    int n_lanes;                    /* made so far */
    char title[48];
} stream;

/* ---- takes ---- */

static bool is_near(const stream *s, int64_t take)
{
    lt_rng rng = lt_rng_make(s->o.seed, lt_rng_mix(NEAR, (uint64_t)take));

    return lt_rng_uniform(&rng) < s->o.near;
}

/* Any subject, who takes any object. */
static synth_stage_spec spec_of(const stream *s, lane *l, int64_t take)
{
    lt_rng rng = lt_rng_make(s->o.seed, lt_rng_mix(TAKE, (uint64_t)take));

    synth_subject_draw(s->hand, s->o.seed, (int)take, &l->subject);
    return (synth_stage_spec){
        .hand = s->hand, .subject = &l->subject, .prop = &s->prop[lt_rng_below(&rng, SYNTH_OBJECTS)], .n_grasps = 1,
        .n_frames = SYNTH_STREAM_FRAMES, .n_cameras = 1, .number = (int)take,
        .setting = { .depth_unit = 0.001, .shrink = s->o.shrink }, .seed = s->o.seed,
        .stream = lt_rng_mix(TAKE, (uint64_t)take),
    };
}

static lt_status enter_stage(const stream *s, lane *l, int64_t take)
{
    synth_stage_spec spec = spec_of(s, l, take);
    synth_grasp grasp;
    lt_status st;

    spec.grasp = &grasp;
    st = synth_choose_grasps(l->arena, &spec, &grasp);
    return st ? st : synth_stage_new(l->arena, &spec, &l->stage);
}

static lt_status enter(const stream *s, lane *l, int64_t take)
{
    lt_status st;

    if (l->take == take)
        return LT_OK;
    lt_arena_reset(l->arena);
    l->take = -1;
    l->near = is_near(s, take);
    l->place = (detect_place){ .hand = s->hand, .prop = s->both.pair, .seed = s->o.seed, .near = 1 };
    st = l->near ? detect_place_new(l->arena, take, &l->place) : enter_stage(s, l, take);
    if (!st)
        l->take = take;
    return st;
}

/* ---- samples ---- */

static synth_posed_hand annotate(const stream *s, const lane *l, int k, dataset_sample *out)
{
    const synth_moment *m = &l->stage.sequence.moment[l->stage.kept[k]];
    double rotation[LT_HAND_JOINTS][9];
    synth_posed_hand hand;
    synth_picture p;

    synth_stage_pose(&l->stage, m, &hand);
    synth_annotate(&l->stage, 0, k, &hand, &p);
    out->width = p.width;
    out->height = p.height;
    out->camera = p.camera;
    for (int i = 0; i < LT_HAND_JOINTS; i++)
        lt_rot_from_axis_angle(p.pose + 3 * i, rotation[i]);
    truth_hand(rotation, p.beta, p.joints, out);
    truth_object((int)(l->stage.prop - s->prop), p.R, p.t, out);
    return hand;
}

/* Copies of what the lane's next picture will be drawn over */
static lt_status take_images(const lane *l, unsigned want, lt_arena *arena, dataset_sample *out)
{
    const size_t n = (size_t)out->width * (size_t)out->height;
    uint8_t *rgb = lt_arena_array(arena, n, 3), *silhouette = lt_arena_array(arena, n, 1);
    uint8_t *segments = lt_arena_array(arena, n, 1);
    float *depth = lt_arena_array(arena, n, sizeof(*depth));

    if (!rgb || !silhouette || !segments || !depth)
        return lt_error(LT_ENOMEM, "%s: no memory", out->name);
    out->rgb = memcpy(rgb, l->frame->rgb, 3 * n);
    for (size_t i = 0; i < n; i++) {
        const uint8_t label = l->frame->label[i];

        silhouette[i] = l->frame->object_mask[i] != 0;
        segments[i] = label == SYNTH_LABEL_HAND ? SEGMENT_HAND : label == l->stage.prop->id ? SEGMENT_OBJECT : 0;
    }
    out->silhouette = want & SAMPLE_OBJECT ? silhouette : NULL;
    if (want & SAMPLE_DEPTH) {
        out->depth = memcpy(depth, l->depth, n * sizeof(*depth));
        out->flags |= SAMPLE_DEPTH;
    }
    if (want & SAMPLE_SEGMENTS) {
        out->segments = segments;
        out->segments_width = out->width, out->segments_height = out->height;
        out->flags |= SAMPLE_SEGMENTS;
    }
    return LT_OK;
}

/* Where picture n is: its lane, the lane's take, the frame of that */
typedef struct {
    int lane, frame;
    int64_t take;
} place;

static place place_of(int64_t n)
{
    const int64_t of_lane = n / LANES;

    return (place){ .lane = (int)(n % LANES), .frame = (int)(of_lane % SYNTH_STREAM_FRAMES),
                    .take = of_lane / SYNTH_STREAM_FRAMES * LANES + n % LANES };
}

static lt_status film(const stream *s, lane *l, int frame, unsigned want, lt_arena *arena, bool drawn,
                      dataset_sample *out)
{
    const synth_posed_hand hand = annotate(s, l, frame, out);
    lt_status st;

    if (!drawn)
        return LT_OK;
    st = synth_stage_film(&l->stage, 0, frame, &hand, l->frame, l->depth);
    if (!st)
        st = take_images(l, want, arena, out);
    return st ? st : dataset_project(&s->base, out);
}

/* Hand out what comes back from a packed sample, and keep that where there is room */
static lt_status keep(stream *s, int64_t index, const dataset_sample *drawn, lt_arena *arena, dataset_sample *out)
{
    packed_sample *k = packed_new(drawn);
    const size_t bytes = k ? packed_bytes(k) : 0;
    const lt_status st = k ? packed_read(k, arena, out) : lt_error(LT_ENOMEM, "%s: no memory", drawn->name);

    if (!st && !s->kept[index] && atomic_fetch_add(&s->kept_bytes, bytes) + bytes <= s->o.keep) {
        s->kept[index] = k;
        return LT_OK;
    }
    packed_free(k);
    return st;
}

static lt_status picture(stream *s, int64_t index, unsigned want, lt_arena *arena, bool drawn, dataset_sample *out)
{
    const place at = place_of(index);
    lane *l = &s->lane[at.lane];
    dataset_sample sample = { .name = s->name[index], .object = -1 };
    lt_status st;

    pthread_mutex_lock(&l->lock);
    if (drawn && s->kept[index] && packed_has(s->kept[index], want)) {
        st = packed_read(s->kept[index], arena, out);
        pthread_mutex_unlock(&l->lock);
        return st;
    }
    st = enter(s, l, at.take);
    if (!st && l->near)
        st = near_sample(&s->base, &l->place, at.take * SYNTH_STREAM_FRAMES + at.frame, want, arena, &sample);
    else if (!st)
        st = film(s, l, at.frame, want, arena, drawn, &sample);
    if (!st && drawn)
        st = keep(s, index, &sample, arena, out);
    else if (!st)
        *out = sample;
    pthread_mutex_unlock(&l->lock);
    return st;
}

static lt_status read_sample(const dataset *d, int64_t index, unsigned want, lt_arena *arena, dataset_sample *out)
{
    return picture((stream *)d, index, want, arena, true, out);
}

static lt_status read_annotation(const dataset *d, int64_t index, lt_arena *arena, dataset_sample *out)
{
    return picture((stream *)d, index, 0, arena, false, out);
}

static const char *nothing_missing(const dataset *d, int64_t index, lt_arena *arena)
{
    (void)d, (void)index, (void)arena;
    return NULL;
}

static const char *name(const dataset *d, int64_t index)
{
    return ((const stream *)d)->name[index];
}

/* ---- opening ---- */

static void free_stream(dataset *d)
{
    stream *s = (stream *)d;

    for (int i = 0; i < s->n_lanes; i++) {
        pthread_mutex_destroy(&s->lane[i].lock);
        synth_frame_free(s->lane[i].frame);
        lt_arena_free(s->lane[i].arena);
        lt_release(s->lane[i].depth);
    }
    for (int i = 0; i < SYNTH_OBJECTS; i++)
        lt_arena_free(s->arena_of[i]);
    synth_props_fini(&s->both);
    for (int64_t i = 0; s->kept && i < s->o.count; i++)
        packed_free(s->kept[i]);
    lt_arena_free(s->arena);
    free(s);
}

static const dataset_ops ops = { read_sample, read_annotation, nothing_missing, name, free_stream };

static lt_status open_lanes(stream *s)
{
    const int w = SYNTH_WIDTH / s->o.shrink, h = SYNTH_HEIGHT / s->o.shrink;

    for (; s->n_lanes < LANES; s->n_lanes++) {
        lane *l = &s->lane[s->n_lanes];

        *l = (lane){ .take = -1, .arena = lt_arena_new(), .frame = synth_frame_new(w, h),
                     .depth = lt_alloc((size_t)w * (size_t)h * sizeof(*l->depth)) };
        pthread_mutex_init(&l->lock, NULL);
        if (!l->arena || !l->frame || !l->depth) {
            s->n_lanes++;           /* what there is of it is freed */
            return lt_error(LT_ENOMEM, "no memory for a stream of pictures");
        }
    }
    return LT_OK;
}

static lt_status open_object(stream *s, int i)
{
    synth_prop *p = &s->prop[i];
    lt_arena *arena = s->arena_of[i] = lt_arena_new();
    lt_status st = arena ? synth_prop_new(arena, i + 1, false, p) : lt_error(LT_ENOMEM, "no memory for an object");

    if (st)
        return st;
    s->object[i] = (dataset_object){ .name = p->name, .ycb_id = i + 1 == SYNTH_JUG ? 0 : i + 1, .mesh = p->mesh,
                                     .point = (float (*)[3])p->points, .n_points = SYNTH_POINTS };
    return dataset_measure_object(arena, &s->object[i], p->name, p->name);
}

typedef struct {
    stream *s;
    lt_status status[SYNTH_OBJECTS];
} objects_job;

static void open_object_task(void *ctx, int64_t i)
{
    objects_job *j = ctx;

    j->status[i] = open_object(j->s, (int)i);
}

static lt_status open_objects(stream *s)
{
    objects_job j = { .s = s };
    lt_status st = LT_OK;

    lt_parallel_for(SYNTH_OBJECTS, open_object_task, &j);
    if (s->o.near > 0)
        st = synth_props_init(&s->both);
    for (int i = 0; i < SYNTH_OBJECTS && !st; i++)
        if (j.status[i])
            st = lt_error(j.status[i], "no memory for the objects of a stream of pictures");
    s->base.objects = s->object;
    s->base.n_objects = SYNTH_OBJECTS;
    return st;
}

static lt_status open_names(stream *s)
{
    s->name = lt_arena_array(s->arena, (size_t)s->o.count, sizeof(*s->name));
    s->kept = lt_arena_array(s->arena, (size_t)s->o.count, sizeof(*s->kept));
    if (!s->name || !s->kept)
        return lt_error(LT_ENOMEM, "no memory for the names of %lld pictures", (long long)s->o.count);
    for (int64_t i = 0; i < s->o.count; i++)
        snprintf(s->name[i], NAME, "stream/%010lld", (long long)i);
    snprintf(s->title, sizeof(s->title), "stream of seed %llu", (unsigned long long)s->o.seed);
    return LT_OK;
}

static lt_status open_hand(stream *s)
{
    lt_hand_model *hand = NULL;
    lt_status st;

    if (s->o.count < 1 || s->o.shrink < 1 || s->o.shrink > 4)
        return lt_error(LT_EINVAL, "a stream of %lld pictures of 640 x 480 over %d, expected some, over 1 to 4",
                        (long long)s->o.count, s->o.shrink);
    st = synth_hand_new(s->arena, SYNTH_HAND_MANO_LIKE, &hand);
    s->hand = hand;
    return st;
}

lt_status synth_stream_open(const synth_stream_options *o, dataset **out)
{
    stream *s = calloc(1, sizeof(*s));
    lt_status st;

    if (!s || !(s->arena = lt_arena_new())) {
        free(s);
        return lt_error(LT_ENOMEM, "no memory for a stream of pictures");
    }
    s->o = *o;
    s->base = (dataset){ .ops = &ops, .kind = &synth_stream_kind, .title = "stream", .split = "train",
                         .root = s->title, .synthetic = true, .count = o->count, .tips = lt_hand_tips_ho3d };
    st = open_hand(s);
    if (!st)
        st = open_names(s);
    if (!st)
        st = open_objects(s);
    if (!st)
        st = open_lanes(s);
    if (st)
        free_stream(&s->base);
    else
        *out = &s->base;
    return st;
}

static lt_status open_by_kind(const dataset_options *o, dataset **out)
{
    (void)out;
    return lt_error(LT_EINVAL, "%s: a stream of pictures has no folder", o->root ? o->root : "stream");
}

static const char *const splits[] = { "train", NULL };

const dataset_kind synth_stream_kind = {
    .title = "stream", .splits = splits, .counted = "pictures", .open = open_by_kind,
    .fields = SAMPLE_HAND_POSE | SAMPLE_JOINTS | SAMPLE_ROOT | SAMPLE_OBJECT | SAMPLE_DEPTH | SAMPLE_SEGMENTS,
};
