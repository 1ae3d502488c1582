/* SPDX-License-Identifier: Apache-2.0 */
/* Puts room, arm, hand and object together, and films them. */
#include "synth/take/stage.h"

#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/mat3.h"
#include "synth/take/clearing.h"

#include <math.h>
#include <string.h>

/* Uses of a stage's stream. */
enum { MOTION = 1, VIEW, ROOM, ARM, SENSOR, NOISE, DEPTH_NOISE, SHUTTER, TABLE };

enum { ARM_BALLS = 12, BALLS = 1 + LT_HAND_KEYPOINTS + ARM_BALLS };

static const double CLEAR = 0.16;               /* radius of table without clutter, metres */
static const double ARM_LENGTH = 0.6;
static const double FRAMES_PER_SECOND = 30;

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
    for (int i = 0; i < n; i++)
        sensor[i] = synth_sensor_random(s->seed, lt_rng_mix(lt_rng_mix(s->stream, SENSOR), (uint64_t)i));
    s->camera = camera;
    s->sensor = sensor;
    return LT_OK;
}

/* The object taken with one grasp after the other. */
static lt_status move(lt_arena *arena, synth_stage *s, const synth_grasp *grasp, int n)
{
    synth_sequence *round = lt_arena_array(arena, (size_t)n, sizeof(*round));
    lt_status st = round ? LT_OK : lt_error(LT_ENOMEM, "synth: no memory for a take");

    for (int i = 0; !st && i < n; i++) {
        synth_sequence_spec spec = { .grasp = &grasp[i], .object = &s->prop->mesh,
                                     .min_moments = (int)lt_ceil_div(s->n_kept, n), .seed = s->seed,
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

    st = move(arena, &s, spec->grasp, spec->n_grasps);
    if (st)
        return st;
    s.kept = choose_moments(arena, &s.sequence, spec, n);
    sight = lt_arena_array(arena, (size_t)n, sizeof(*sight));
    if (!s.kept || !sight)
        return lt_error(LT_ENOMEM, "synth: no memory for a take");
    for (int k = 0; k < n; k++)
        look_at(&s, &s.sequence.moment[s.kept[k]], &sight[k]);
    st = furnish(arena, sight, &spec->setting, &s, &room);
    if (st)
        return st;
    st = place_cameras(arena, sight, &spec->setting, spec->number, &s);
    if (st)
        return st;
    if (!synth_room_paint(room, s.camera, s.n_cameras * s.n_views) || !synth_texture_paint(s.cloth))
        return lt_error(LT_ENOMEM, "synth: no memory for a room");
    *out = s;
    return LT_OK;
}

/* ---- filming ---- */

/* The posed hand as a mesh to draw, with normals and the subject's skin. */
static lt_status hand_mesh(lt_arena *arena, const synth_stage *s, const synth_posed_hand *hand, lt_mesh *out)
{
    *out = (lt_mesh){
        .n_vertices = LT_HAND_VERTICES, .n_faces = LT_HAND_FACES,
        .vertex = lt_arena_array(arena, LT_HAND_VERTICES, sizeof(*out->vertex)),
        .normal = lt_arena_array(arena, LT_HAND_VERTICES, sizeof(*out->normal)),
        .face = (int32_t (*)[3])s->hand->faces, .color = (float (*)[3])s->subject->color,
    };
    if (!out->vertex || !out->normal)
        return lt_error(LT_ENOMEM, "synth: no memory for a hand");
    for (int i = 0; i < LT_HAND_VERTICES; i++)
        for (int k = 0; k < 3; k++)
            out->vertex[i][k] = (float)hand->vertices[i][k];
    lt_mesh_normals(out, out->normal);
    return LT_OK;
}

static lt_status grow_arm(lt_arena *arena, const synth_stage *s, const synth_moment *m, const lt_mesh *hand,
                          synth_arm *out)
{
    float loop[SYNTH_WRIST_LOOP][3], normal[SYNTH_WRIST_LOOP][3], color[SYNTH_WRIST_LOOP][3];
    synth_arm_spec spec = {
        .loop = (const float (*)[3])loop, .loop_normal = (const float (*)[3])normal,
        .loop_color = (const float (*)[3])color, .elbow = { m->R_hand[0], m->R_hand[3], m->R_hand[6] },
        .bare = s->subject->bare, .length = ARM_LENGTH, .cloth = s->cloth, .seed = s->seed,
        .stream = lt_rng_mix(s->stream, ARM),
    };

    for (int i = 0; i < SYNTH_WRIST_LOOP; i++) {
        const int v = synth_hand_wrist_loop[i];
        memcpy(loop[i], hand->vertex[v], sizeof(loop[i]));
        memcpy(normal[i], hand->normal[v], sizeof(normal[i]));
        memcpy(color[i], hand->color[v], sizeof(color[i]));
    }
    memcpy(spec.skin, s->subject->skin, sizeof(spec.skin));
    return synth_arm_new(arena, &spec, out);
}

/* A mesh whose vertices are in the world already. */
static synth_instance in_world(const lt_mesh *mesh, const synth_material *material, uint8_t label)
{
    return (synth_instance){ .mesh = mesh, .R_world_obj = { 1, 0, 0, 0, 1, 0, 0, 0, 1 },
                             .material = *material, .label = label, .moving = true };
}

static synth_instance object_instance(const synth_prop *prop, const double R[9], const double t[3], bool moving)
{
    synth_instance i = {
        .mesh = &prop->mesh, .label = (uint8_t)prop->id, .moving = moving,
        .material = { .albedo = { 1, 1, 1 }, .specular = 0.04f, .shininess = 40, .texture = prop->texture },
    };

    memcpy(i.R_world_obj, R, sizeof(i.R_world_obj));
    memcpy(i.t_world_obj, t, sizeof(i.t_world_obj));
    return i;
}

typedef struct {
    lt_mesh hand;
    synth_arm arm;
    synth_instance instance[SYNTH_ROOM_INSTANCES + SYNTH_STAGE_OTHERS + 4];
    int n;
} cast;

static lt_status gather(lt_arena *arena, const synth_stage *s, const synth_moment *m,
                        const synth_posed_hand *hand, cast *c)
{
    static const synth_material skin = { .albedo = { 1, 1, 1 }, .specular = 0.028f, .shininess = 12,
                                         .translucency = 1 };
    lt_status st = hand_mesh(arena, s, hand, &c->hand);

    if (!st)
        st = grow_arm(arena, s, m, &c->hand, &c->arm);
    if (st)
        return st;
    c->n = s->room->n_instances;
    memcpy(c->instance, s->room->instance, (size_t)c->n * sizeof(c->instance[0]));
    for (int i = 0; i < s->n_others; i++)
        c->instance[c->n++] = object_instance(s->other[i], s->at[i].R, s->at[i].t, false);
    c->instance[c->n++] = object_instance(s->prop, m->R_obj, m->t_obj, true);
    c->instance[c->n++] = in_world(&c->hand, &skin, SYNTH_LABEL_HAND);
    c->instance[c->n++] = in_world(&c->arm.skin, &c->arm.skin_material, SYNTH_LABEL_BACKGROUND);
    if (c->arm.sleeve.n_faces)
        c->instance[c->n++] = in_world(&c->arm.sleeve, &c->arm.sleeve_material, SYNTH_LABEL_BACKGROUND);
    return LT_OK;
}

static synth_scene scene_of(const synth_stage *s, const cast *c, int view)
{
    synth_scene scene = { .instance = c->instance, .n_instances = c->n, .light = s->room->light,
                          .n_lights = s->room->n_lights, .focus_radius = s->room->focus_radius,
                          .camera = s->camera[view], .target = (uint8_t)s->prop->id };

    memcpy(scene.sky, s->room->sky, sizeof(scene.sky));
    memcpy(scene.ground, s->room->ground, sizeof(scene.ground));
    memcpy(scene.up, s->room->up, sizeof(scene.up));
    memcpy(scene.focus, s->room->focus, sizeof(scene.focus));
    return scene;
}

static void wrist_pixel(const synth_stage *s, int view, const synth_moment *m, double uv[2])
{
    const synth_camera *c = &s->camera[view];
    const lt_camera cam = { c->fx, c->fy, c->cx, c->cy };
    double p[3];

    lt_rigid_apply(c->R_cam_world, c->t_cam_world, m->wrist, p);
    lt_camera_project(&cam, p, uv);
}

static bool same_round(const synth_stage *s, int a, int b)
{
    return b >= 0 && b < s->sequence.n && s->sequence.moment[a].round == s->sequence.moment[b].round;
}

/* How far the wrist moves in the picture while the shutter is open. */
static void smear(const synth_stage *s, int view, int moment, float out[2])
{
    lt_rng rng = lt_rng_make(s->seed, lt_rng_mix(lt_rng_mix(s->stream, SHUTTER), (uint64_t)view));
    const double open = lt_rng_range(&rng, 0.008, 0.016) * FRAMES_PER_SECOND;
    const int before = same_round(s, moment, moment - 1) ? moment - 1 : moment;
    const int after = same_round(s, moment, moment + 1) ? moment + 1 : moment;
    double a[2], b[2];

    wrist_pixel(s, view, &s->sequence.moment[before], a);
    wrist_pixel(s, view, &s->sequence.moment[after], b);
    for (int k = 0; k < 2; k++)
        out[k] = (float)(open * (b[k] - a[k]) / (after - before));
}

lt_status synth_stage_film(const synth_stage *s, int camera, int k, const synth_posed_hand *hand,
                           synth_frame *out, float *depth)
{
    const synth_moment *m = &s->sequence.moment[s->kept[k]];
    const uint64_t frame = lt_rng_mix((uint64_t)camera, (uint64_t)k);
    const int view = synth_stage_view(s, camera, k);
    synth_sensor sensor = s->sensor[view];
    lt_arena *arena = lt_arena_new();
    cast *c = arena ? lt_arena_alloc(arena, sizeof(*c)) : NULL;
    lt_status st = c ? gather(arena, s, m, hand, c) : lt_error(LT_ENOMEM, "synth: no memory for a frame");

    if (!st) {
        const synth_scene scene = scene_of(s, c, view);
        st = synth_render(&scene, out);
    }
    if (!st) {
        sensor.stream = lt_rng_mix(lt_rng_mix(s->stream, NOISE), frame);
        sensor.seed = s->seed;
        smear(s, view, s->kept[k], sensor.motion);
        synth_sensor_image(&sensor, out);
        synth_sensor_depth(out, s->camera[view].fx, s->depth_unit, s->seed,
                           lt_rng_mix(lt_rng_mix(s->stream, DEPTH_NOISE), frame), depth);
    }
    lt_arena_free(arena);
    return st;
}
