/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/stream/near.h"

#include "data/mirror.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "synth/stream/truth.h"
#include "synth/world/seen.h"

#include <stdlib.h>

enum { TRIES = 64, LEAST = 400 /* pixels of the hand */, DEPTH = 0x4e444550 };

static const double LEAST_SHARE = 0.35;         /* visible of the hand where the picture has it, and */
static const double LEAST_INSIDE = 0.6;         /* that the picture has at all */

/* A picture as it is drawn, and the hand in it that shows most. */
typedef struct {
    lt_arena *arena;
    detect_picture picture;
    synth_frame *frame;
    synth_seen *seen;
    const detect_put *hand;
    int64_t number;                             /* of those of the seed */
} shot;

static double share_inside(const synth_camera *c, const detect_put *hand)
{
    int n = 0;

    for (int i = 0; i < LT_HAND_VERTICES; i++) {
        double p[3];
        lt_rigid_apply(hand->R, hand->t, hand->grip->vertices[i], p);
        lt_rigid_apply(c->R_cam_world, c->t_cam_world, p, p);
        p[0] = c->fx * p[0] / p[2] + c->cx;
        p[1] = c->fy * p[1] / p[2] + c->cy;
        n += p[2] > 0 && p[0] >= 0 && p[0] < c->width && p[1] >= 0 && p[1] < c->height;
    }
    return n / (double)LT_HAND_VERTICES;
}

static const detect_put *choose_hand(const shot *s)
{
    const detect_put *best = NULL;

    for (int i = 0; i < s->picture.n_put; i++) {
        const detect_put *p = &s->picture.put[i];
        const synth_seen *seen = &s->seen[p->thing];

        if (!p->grip || seen->visible < LEAST || synth_seen_share(seen) < LEAST_SHARE
            || share_inside(&s->picture.camera, p) < LEAST_INSIDE)
            continue;
        if (!best || seen->visible > s->seen[best->thing].visible)
            best = p;
    }
    return best;
}

static lt_status draw(shot *s, const detect_place *place)
{
    synth_scene scene;
    lt_status st;

    lt_arena_reset(s->arena);
    st = detect_lay_out(s->arena, place, s->number, &s->picture);
    if (st)
        return st;
    scene = synth_world_scene(&s->picture.world, &s->picture.room, &s->picture.camera);
    st = synth_render(&scene, s->frame);
    if (!st)
        st = synth_world_look(s->arena, &s->picture.world, &s->picture.camera, s->frame, NULL, &s->seen);
    if (!st)
        s->hand = choose_hand(s);
    return st;
}

static lt_status draw_until_seen(shot *s, const detect_place *place, int64_t n)
{
    lt_status st = LT_OK;

    for (int i = 0; !st && !s->hand && i < TRIES; i++) {
        s->number = n * TRIES + i;
        st = draw(s, place);
    }
    return st || s->hand ? st : lt_error(LT_ENUMERIC, "synth: no hand was seen in %d pictures", TRIES);
}

/* ---- what is known of it ---- */

/* How the hand's frame stands in the camera's, or in the mirror image of it for a left hand. */
static void frame_in_camera(const shot *s, double A[9], double b[3])
{
    const synth_camera *c = &s->picture.camera;

    lt_mat3_mul(c->R_cam_world, s->hand->R, A);
    lt_rigid_apply(c->R_cam_world, c->t_cam_world, s->hand->t, b);
    if (s->hand->grip->left)
        mirror_pose(A, b);
}

/* The hand, and what it holds */
static void take_truth(const shot *s, const lt_hand_model *model, const double A[9], const double b[3],
                       dataset_sample *out)
{
    const synth_grip *g = s->hand->grip;
    double R[LT_HAND_JOINTS][9], wrist[3] = { g->left ? -g->wrist[0] : g->wrist[0], g->wrist[1], g->wrist[2] };
    synth_posed_hand posed;

    for (int i = 0; i < LT_HAND_JOINTS; i++)
        lt_rot_from_axis_angle(g->pose + 3 * i, R[i]);
    lt_mat3_mul(A, R[0], R[0]);
    lt_rigid_apply(A, b, wrist, wrist);
    synth_subject_pose(s->hand->who, model, R[0], wrist, g->pose + 3, &posed);
    truth_hand(R, s->hand->who->beta, posed.keypoints, out);
    out->flags |= g->left ? SAMPLE_MIRRORED : 0;
    if (g->prop)
        truth_object(g->prop->id - 1, A, b, out);       /* it has the hand's frame for its own */
}

/* ---- the images ---- */

static lt_status take_colour(const shot *s, const detect_place *place, lt_arena *arena, dataset_sample *out)
{
    const size_t n = (size_t)out->width * (size_t)out->height;
    uint8_t *rgb = lt_arena_array(arena, n, 3);

    if (!rgb)
        return lt_error(LT_ENOMEM, "%s: no memory", out->name);
    detect_develop(place, s->number, s->frame);
    out->rgb = memcpy(rgb, s->frame->rgb, 3 * n);
    if (out->flags & SAMPLE_MIRRORED)
        mirror_plane(rgb, out->width, out->height, 3);
    return LT_OK;
}

static lt_status take_depth(const shot *s, const detect_place *place, lt_arena *arena, dataset_sample *out)
{
    float *depth = lt_arena_array(arena, (size_t)out->width * (size_t)out->height, sizeof(*depth));

    if (!depth)
        return lt_error(LT_ENOMEM, "%s: no memory", out->name);
    synth_sensor_depth(s->frame, s->picture.camera.fx, 0.001, SYNTH_SENSOR_FAR, place->seed,
                       lt_rng_mix(DEPTH, (uint64_t)s->number), depth);
    if (out->flags & SAMPLE_MIRRORED)
        mirror_plane(depth, out->width, out->height, sizeof(*depth));
    out->depth = depth;
    out->flags |= SAMPLE_DEPTH;
    return LT_OK;
}

/* The object that is held is the thing after its hand. */
static lt_status take_segments(const shot *s, lt_arena *arena, dataset_sample *out)
{
    const size_t n = (size_t)out->width * (size_t)out->height;
    const uint8_t *hand = s->seen[s->hand->thing].mask;
    const uint8_t *object = s->hand->grip->prop ? s->seen[s->hand->thing + 1].mask : NULL;
    uint8_t *segments = lt_arena_array(arena, n, 1);

    if (!segments)
        return lt_error(LT_ENOMEM, "%s: no memory", out->name);
    for (size_t i = 0; i < n; i++)
        segments[i] = hand[i] ? SEGMENT_HAND : object && object[i] ? SEGMENT_OBJECT : 0;
    if (out->flags & SAMPLE_MIRRORED)
        mirror_plane(segments, out->width, out->height, 1);
    out->segments = segments;
    out->segments_width = out->width, out->segments_height = out->height;
    out->flags |= SAMPLE_SEGMENTS;
    return LT_OK;
}

static lt_status describe(const shot *s, const dataset *d, const detect_place *place, unsigned want, lt_arena *arena,
                          dataset_sample *out)
{
    const synth_camera *c = &s->picture.camera;
    double A[9], b[3];
    lt_status st;

    out->width = c->width;
    out->height = c->height;
    out->camera = (lt_camera){ .fx = c->fx, .fy = c->fy, .cx = c->cx, .cy = c->cy };
    if (s->hand->grip->left)
        mirror_camera(&out->camera, out->width);
    frame_in_camera(s, A, b);
    take_truth(s, place->hand, A, b, out);
    st = dataset_project(d, out);
    if (!st)
        st = take_colour(s, place, arena, out);
    if (!st && want & SAMPLE_DEPTH)
        st = take_depth(s, place, arena, out);
    if (!st && want & SAMPLE_SEGMENTS)
        st = take_segments(s, arena, out);
    if (!st && want & SAMPLE_OBJECT && out->flags & SAMPLE_OBJECT)
        st = dataset_draw_silhouette(d, arena, out);
    return st;
}

lt_status near_sample(const dataset *d, const detect_place *place, int64_t n, unsigned want, lt_arena *arena,
                      dataset_sample *out)
{
    shot *s = calloc(1, sizeof(*s));
    lt_status st;

    if (!s)
        return lt_error(LT_ENOMEM, "%s: no memory", out->name);
    s->arena = lt_arena_new();
    s->frame = synth_frame_new(DETECT_SIDE, DETECT_SIDE);
    st = s->arena && s->frame ? draw_until_seen(s, place, n) : lt_error(LT_ENOMEM, "%s: no memory", out->name);
    if (!st)
        st = describe(s, d, place, want, arena, out);
    synth_frame_free(s->frame);
    lt_arena_free(s->arena);
    free(s);
    return st;
}
