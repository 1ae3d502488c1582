/* SPDX-License-Identifier: Apache-2.0 */
/* Films a stage: what is seen at a moment becomes a scene, and a picture. */
#include "synth/take/internal.h"

#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/mat3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double FRAMES_PER_SECOND = 30;

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

/* Light that reaches the sensor; local: instead of the room's, where the stage is lit. */
static lt_status render(const synth_stage *s, int view, const synth_moment *m, const synth_posed_hand *hand,
                        const synth_light_local *local, synth_frame *out)
{
    lt_arena *arena = lt_arena_new();
    cast *c = arena ? lt_arena_alloc(arena, sizeof(*c)) : NULL;
    lt_status st = c ? gather(arena, s, m, hand, c) : lt_error(LT_ENOMEM, "synth: no memory for a frame");

    if (!st) {
        synth_scene scene = scene_of(s, c, view);
        synth_light lamp;
        if (local)
            synth_light_up(local, &scene, &lamp, c->instance);
        st = synth_render(&scene, out);
    }
    lt_arena_free(arena);
    return st;
}

lt_status synth_stage_film(const synth_stage *s, int camera, int k, const synth_posed_hand *hand,
                           synth_frame *out, float *depth)
{
    const uint64_t frame = lt_rng_mix((uint64_t)camera, (uint64_t)k);
    const int view = synth_stage_view(s, camera, k);
    const synth_light_state light = s->lit ? synth_light_at(&s->light, k) : synth_light_still;
    synth_sensor sensor = s->lit ? synth_light_sensor(&light.global) : s->sensor[view];
    const lt_status st = render(s, view, &s->sequence.moment[s->kept[k]], hand, s->lit ? &light.local : NULL, out);

    if (st)
        return st;
    sensor.stream = lt_rng_mix(lt_rng_mix(s->stream, NOISE), frame);
    sensor.seed = s->seed;
    smear(s, view, s->kept[k], sensor.motion);
    synth_sensor_image(&sensor, out);
    if (s->lit && s->light.jitter)
        synth_light_jitter(light.jitter, out->rgb, (int64_t)out->width * out->height);
    synth_sensor_depth(out, s->camera[view].fx, s->depth_unit, SYNTH_SENSOR_FAR, s->seed,
                       lt_rng_mix(lt_rng_mix(s->stream, DEPTH_NOISE), frame), depth);
    return LT_OK;
}

/* ---- what light does ---- */

/* The picture as `global` shows it, without what is no light's. */
static void develop(const synth_light_global *global, synth_frame *f)
{
    synth_sensor sensor = synth_light_sensor(global);

    sensor.noise = 0;
    synth_sensor_image(&sensor, f);
}

/* Squared differences of f's picture from `still` where hand or object is seen. */
static double difference(const synth_frame *f, const uint8_t (*still)[3], uint8_t object)
{
    double sum = 0;

    for (int64_t i = 0; i < (int64_t)f->width * f->height; i++)
        for (int c = 0; c < 3 && (f->label[i] == SYNTH_LABEL_HAND || f->label[i] == object); c++)
            sum += (f->rgb[i][c] - still[i][c]) * (f->rgb[i][c] - still[i][c]);
    return sum;
}

lt_status synth_stage_light_parts(const synth_stage *s, int camera, int k, const synth_posed_hand *hand,
                                  synth_frame *frame, double part[2])
{
    const synth_light_state *still = &synth_light_still, light = synth_light_at(&s->light, k);
    const synth_moment *m = &s->sequence.moment[s->kept[k]];
    const int view = synth_stage_view(s, camera, k);
    const size_t bytes = (size_t)frame->width * (size_t)frame->height * sizeof(*frame->rgb);
    uint8_t (*at_rest)[3] = malloc(bytes);
    lt_status st = at_rest ? render(s, view, m, hand, &still->local, frame)
                           : lt_error(LT_ENOMEM, "synth: no memory for a frame");

    if (!st) {
        develop(&still->global, frame);
        memcpy(at_rest, frame->rgb, bytes);
        develop(&light.global, frame);
        part[0] = difference(frame, (const uint8_t (*)[3])at_rest, (uint8_t)s->prop->id);
        st = render(s, view, m, hand, &light.local, frame);
    }
    if (!st) {
        develop(&still->global, frame);
        part[1] = difference(frame, (const uint8_t (*)[3])at_rest, (uint8_t)s->prop->id);
    }
    free(at_rest);
    return st;
}
