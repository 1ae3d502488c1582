/* SPDX-License-Identifier: Apache-2.0 */
/* Puts room, arm, hand and object together. */
#include "synth/take/internal.h"

#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/mat3.h"
#include "synth/take/clearing.h"

#include <math.h>
#include <string.h>

enum { ARM_BALLS = 12, BALLS = 1 + LT_HAND_KEYPOINTS + ARM_BALLS };

static const double CLEAR = 0.16;               /* radius of table without clutter, metres */

/* ---- a take ---- */

void synth_stage_pose(const synth_stage *s, const synth_moment *m, synth_posed_hand *out)
{
    synth_subject_pose(s->subject, s->hand, m->R_hand, m->wrist, m->fingers, out);
}

/* n moments, evenly spread over the `of` from begin on. */
static void spread(int begin, int of, int n, int *kept)
{
    const int stride = of / n, first = begin + (of - 1 - (n - 1) * stride) / 2;

    for (int k = 0; k < n; k++)
        kept[k] = first + k * stride;
}

/* A grasp's only frame: another part of the motion each time, reaching, lifting or putting back, all alike often.
 * number: of the grasp in its dataset */
static int any_part(int number, int of)
{
    const double golden = 0.6180339887498949, turns = (number + 0.5) * golden;

    return (int)((turns - floor(turns)) * of);
}

/* Whether no vertex of the hand is in the object; within a millimetre the mesh is asked, not the grid. */
static bool is_apart(const synth_stage *s, const synth_moment *m)
{
    synth_posed_hand hand;
    double back[9];

    synth_stage_pose(s, m, &hand);
    lt_mat3_transpose(m->R_obj, back);
    for (int i = 0; i < LT_HAND_VERTICES; i++) {
        double d[3], p[3], away;
        lt_vec3_sub(hand.vertices[i], m->t_obj, d);
        lt_mat3_mulvec(back, d, p);
        away = synth_sdf_at(&s->prop->sdf, p, NULL);
        if (away < -0.001 || (away < 0.001 && lt_mesh_inside(s->prop->index, p)))
            return false;
    }
    return true;
}

/* n moments, evenly spread over those at which hand and object are apart. */
static lt_status choose_apart(lt_arena *arena, const synth_stage *s, int n, int *kept)
{
    int *apart = lt_arena_array(arena, (size_t)s->sequence.n, sizeof(*apart)), n_apart = 0;

    if (!apart)
        return lt_error(LT_ENOMEM, "synth: no memory for a take");
    for (int i = 0; i < s->sequence.n; i++)
        if (is_apart(s, &s->sequence.moment[i]))
            apart[n_apart++] = i;
    if (n_apart < n)
        return lt_error(LT_ENUMERIC, "%s: hand and object are apart in %d of %d moments, and %d are to be kept",
                        s->prop->name, n_apart, s->sequence.n, n);
    spread(0, n_apart, n, kept);
    for (int k = 0; k < n; k++)
        kept[k] = apart[kept[k]];
    return LT_OK;
}

/* Frame k is moment kept[k]: as many of each round where n allows it, else n of the whole motion. */
static int *choose_moments(lt_arena *arena, const synth_sequence *q, const synth_stage_spec *spec, int n)
{
    const int rounds = spec->n_grasps;
    int *kept = lt_arena_array(arena, (size_t)n, sizeof(*kept));
    const int each = n / rounds;

    if (!kept)
        return NULL;
    if (n % rounds) {
        spread(0, q->n, n, kept);
        return kept;
    }
    for (int round = 0, begin = 0; round < rounds; round++) {
        int of = 0;
        while (begin + of < q->n && q->moment[begin + of].round == round)
            of++;
        if (each == 1)
            kept[round] = begin + any_part(spec->number * rounds + round, of);
        else
            spread(begin, of, each, kept + round * each);
        begin += of;
    }
    return kept;
}

static void look_at(const synth_stage *s, const synth_moment *m, synth_sight *out)
{
    synth_posed_hand hand;
    double centre[3];

    synth_stage_pose(s, m, &hand);
    memcpy(out->keypoints, hand.keypoints, sizeof(out->keypoints));
    for (int k = 0; k < 3; k++) {
        out->elbow[k] = m->R_hand[3 * k];
        centre[k] = (s->prop->box.lo[k] + s->prop->box.hi[k]) / 2;
    }
    lt_rigid_apply(m->R_obj, m->t_obj, centre, out->object);
}

/* Hand, object and forearm at one moment. */
static void occupy(const synth_stage *s, const synth_sight *at, synth_ball ball[BALLS])
{
    const double *wrist = at->keypoints[0];
    int n = 0;

    ball[n] = (synth_ball){ .radius = lt_box_diagonal(&s->prop->box) / 2 };
    memcpy(ball[n++].centre, at->object, sizeof(at->object));
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++, n++) {
        ball[n].radius = 0.02;
        memcpy(ball[n].centre, at->keypoints[i], sizeof(ball[n].centre));
    }
    for (int i = 0; i < ARM_BALLS; i++, n++) {
        ball[n].radius = 0.055;
        for (int k = 0; k < 3; k++)
            ball[n].centre[k] = wrist[k] + ARM_LENGTH * (i + 1) / ARM_BALLS * at->elbow[k];
    }
}

/* Stand the others on the table, away from n balls and each other; each adds a ball. */
static void set_table(const synth_setting *setting, synth_stage *s, synth_ball *ball, int n)
{
    lt_rng rng = lt_rng_make(s->seed, lt_rng_mix(s->stream, TABLE));

    for (int i = 0; i < setting->n_others; i++) {
        const synth_prop *p = setting->other[i];
        synth_settled at;
        if (!synth_settle(&p->mesh, ball, n + s->n_others, &rng, &at))
            continue;
        ball[n + s->n_others] = synth_settled_ball(&p->mesh, &at);
        s->other[s->n_others] = p;
        s->at[s->n_others++] = at;
    }
}

static lt_status furnish(lt_arena *arena, const synth_sight *sight, const synth_setting *setting, synth_stage *s,
                         synth_room **out)
{
    synth_room *room = synth_room_new(arena, s->seed, lt_rng_mix(s->stream, ROOM), CLEAR);
    const int moving = s->n_kept * BALLS;
    synth_ball *ball = lt_arena_array(arena, (size_t)moving + SYNTH_STAGE_OTHERS, sizeof(*ball));

    s->cloth = synth_arm_cloth(arena, s->seed, lt_rng_mix(s->stream, ARM));
    if (!room || !ball || !s->cloth)
        return lt_error(LT_ENOMEM, "synth: no memory for a room");
    for (int k = 0; k < s->n_kept; k++)
        occupy(s, &sight[k], ball + k * BALLS);
    set_table(setting, s, ball, moving);
    synth_clear_way(room, ball, moving + s->n_others);
    s->room = *out = room;
    return LT_OK;
}

/* Take away what stands between the camera and the object. */
static lt_status clear_sight(lt_arena *arena, const synth_stage *s, const synth_sight *sight, synth_room *room)
{
    enum { STEPS = 8 };
    synth_ball *ball = lt_arena_array(arena, (size_t)s->n_kept * STEPS, sizeof(*ball));

    if (!ball)
        return lt_error(LT_ENOMEM, "synth: no memory for a room");
    for (int k = 0; k < s->n_kept; k++) {
        const synth_camera *c = &s->camera[synth_stage_view(s, 0, k)];
        for (int i = 0; i < STEPS; i++) {
            const double share = (i + 0.5) / STEPS;
            synth_ball *b = &ball[k * STEPS + i];
            b->radius = 0.04 + 0.08 * share;
            for (int d = 0; d < 3; d++) {
                double eye = 0;
                for (int e = 0; e < 3; e++)
                    eye -= c->R_cam_world[3 * e + d] * c->t_cam_world[e];
                b->centre[d] = (1 - share) * eye + share * sight[k].object[d];
            }
        }
    }
    synth_clear_way(room, ball, s->n_kept * STEPS);
    return LT_OK;
}

int synth_stage_view(const synth_stage *s, int camera, int k)
{
    return camera * s->n_views + (s->n_views == 1 ? 0 : s->sequence.moment[s->kept[k]].round);
}

static void set_lens(const synth_camera *lens, synth_camera *c)
{
    c->fx = lens->fx;
    c->fy = lens->fy;
    c->cx = lens->cx;
    c->cy = lens->cy;
}

/* One camera that walks: for each round it is chosen anew, but for its lens. */
static void walk(const synth_stage *s, const synth_sight *sight, int number, synth_camera *camera)
{
    const uint64_t stream = lt_rng_mix(s->stream, VIEW);

    for (int v = 0, k = 0, n; v < s->n_views; v++, k += n) {
        for (n = 0; k + n < s->n_kept && synth_stage_view(s, 0, k + n) == v; n++)
            ;
        synth_view_choose(sight + k, n, s->seed, synth_round_stream(stream, v), number * s->n_views + v, 1, &camera[v]);
        set_lens(&camera[0], &camera[v]);
    }
}

/* The same view in fewer pixels; integers are pixels' centres. */
static void shrink_camera(int by, synth_camera *c)
{
    c->fx /= by;
    c->fy /= by;
    c->cx = (c->cx + 0.5) / by - 0.5;
    c->cy = (c->cy + 0.5) / by - 0.5;
    c->width /= by;
    c->height /= by;
}

static lt_status place_cameras(lt_arena *arena, const synth_sight *sight, const synth_setting *setting, int number,
                               synth_stage *s)
{
    const int n = s->n_cameras * s->n_views;
    synth_camera *camera = lt_arena_array(arena, (size_t)n, sizeof(*camera));
    synth_sensor *sensor = lt_arena_array(arena, (size_t)n, sizeof(*sensor));

    if (!camera || !sensor)
        return lt_error(LT_ENOMEM, "synth: no memory for %d cameras", n);
    if (setting->camera)
        memcpy(camera, setting->camera, (size_t)n * sizeof(*camera));
    else if (s->n_views > 1)
        walk(s, sight, number, camera);
    else
        synth_view_choose(sight, s->n_kept, s->seed, lt_rng_mix(s->stream, VIEW), number * n, n, camera);
    for (int i = 0; i < n && setting->shrink > 1; i++)
        shrink_camera(setting->shrink, &camera[i]);
    for (int i = 0; i < n; i++)
        sensor[i] = synth_sensor_random(s->seed, lt_rng_mix(lt_rng_mix(s->stream, SENSOR), (uint64_t)i));
    s->camera = camera;
    s->sensor = sensor;
    return LT_OK;
}

/* The object taken with one grasp after the other. apart: with half as many moments again to choose from. */
static lt_status move(lt_arena *arena, synth_stage *s, const synth_grasp *grasp, int n, bool apart)
{
    synth_sequence *round = lt_arena_array(arena, (size_t)n, sizeof(*round));
    lt_status st = round ? LT_OK : lt_error(LT_ENOMEM, "synth: no memory for a take");

    for (int i = 0; !st && i < n; i++) {
        synth_sequence_spec spec = { .grasp = &grasp[i], .object = &s->prop->mesh,
                                     .min_moments = (int)lt_ceil_div(s->n_kept * (apart ? 3 : 2), 2 * n),
                                     .steady = apart, .seed = s->seed,
                                     .stream = synth_round_stream(lt_rng_mix(s->stream, MOTION), i) };
        memcpy(spec.rest_wrist, s->subject->rest_wrist, sizeof(spec.rest_wrist));
        st = synth_sequence_new(arena, &spec, &round[i]);
    }
    return st ? st : synth_sequence_join(arena, round, n, &s->sequence);
}

lt_status synth_stage_new(lt_arena *arena, const synth_stage_spec *spec, synth_stage *out)
{
    const int n = spec->n_frames;
    const bool carried = spec->n_cameras == 1 && !spec->setting.camera;
    synth_stage s = { .hand = spec->hand, .subject = spec->subject, .prop = spec->prop, .n_kept = n,
                      .n_cameras = spec->n_cameras, .n_views = carried ? spec->n_grasps : 1,
                      .depth_unit = spec->setting.depth_unit, .seed = spec->seed, .stream = spec->stream };
    synth_sight *sight;
    synth_room *room = NULL;
    lt_status st;

    s.lit = spec->setting.light;
    if (s.lit)
        s.light = *spec->setting.light;
    st = move(arena, &s, spec->grasp, spec->n_grasps, spec->setting.apart);
    if (st)
        return st;
    s.kept = choose_moments(arena, &s.sequence, spec, n);
    sight = lt_arena_array(arena, (size_t)n, sizeof(*sight));
    if (!s.kept || !sight)
        return lt_error(LT_ENOMEM, "synth: no memory for a take");
    if (spec->setting.apart)
        st = choose_apart(arena, &s, n, (int *)s.kept);
    if (st)
        return st;
    for (int k = 0; k < n; k++)
        look_at(&s, &s.sequence.moment[s.kept[k]], &sight[k]);
    st = furnish(arena, sight, &spec->setting, &s, &room);
    if (st)
        return st;
    st = place_cameras(arena, sight, &spec->setting, spec->number, &s);
    if (!st && spec->setting.apart)
        st = clear_sight(arena, &s, sight, room);
    if (st)
        return st;
    if (!synth_room_paint(room, s.camera, s.n_cameras * s.n_views) || !synth_texture_paint(s.cloth))
        return lt_error(LT_ENOMEM, "synth: no memory for a room");
    *out = s;
    return LT_OK;
}
