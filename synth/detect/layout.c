/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A camera, then persons, arms from outside and objects. What would pass through something that is there already is
 * drawn anew a few times, and then left out.
 */
#include "synth/detect/internal.h"

#include "libtensor/geometry/mat3.h"
#include "synth/room/primitive.h"
#include "synth/take/view.h"

#include <math.h>
#include <string.h>

enum { PICTURE = 0x50494354, PLACE = 0x504c4143, NEAR = 0x4e454152, SENSOR = 0x53454e53 };

#define DEGREE 0.017453292519943295

static const double EMPTY = 0.05;               /* share of pictures with no thing */
static const double BARE = 0.005;               /* metres between a bare hand and any object, at least */
static const double CEILING = 2.2;

static void draw_camera(layout *l)
{
    synth_camera *c = &l->out->camera;
    const double f = lt_rng_range(&l->r, l->out->near ? 300 : 150, l->out->near ? 700 : 340);
    const double away = exp(lt_rng_range(&l->r, log(0.42), log(2.6)));
    const double azimuth = DEGREE * lt_rng_range(&l->r, -65, 65), up = DEGREE * lt_rng_range(&l->r, 4, 60);
    const double roll = DEGREE * (lt_rng_below(&l->r, 8) ? 3 : 15) * lt_rng_normal(&l->r);
    double target[3], eye[3];

    for (int k = 0; k < 3; k++)
        target[k] = lt_rng_range(&l->r, k == 2 ? 0.02 : -0.25, k == 2 ? 0.35 : 0.25);
    target[1] += 0.2;
    eye[0] = target[0] + away * cos(up) * sin(azimuth);
    eye[1] = target[1] - away * cos(up) * cos(azimuth);
    eye[2] = target[2] + away * sin(up);
    eye[0] = fmax(-1.2, fmin(1.2, eye[0]));
    eye[1] = fmax(-1.25, fmin(1.2, eye[1]));
    eye[2] = fmax(0.08, fmin(1.4, eye[2]));
    *c = (synth_camera){ .fx = f, .fy = f, .cx = 159.5, .cy = 159.5, .width = DETECT_SIDE, .height = DETECT_SIDE };
    synth_view_look(eye, target, roll, c);
    layout_add_ball(l, eye, 0.12);
}

/* ---- the whole ---- */

/* Whether any vertex of the hand is nearer to the object than BARE. */
static bool touches(const detect_put *hand, const detect_put *object)
{
    double back[9];

    lt_mat3_transpose(object->R, back);
    for (int i = 0; i < LT_HAND_VERTICES; i++) {
        double p[3];
        lt_rigid_apply(hand->R, hand->t, hand->grip->vertices[i], p);
        lt_vec3_sub(p, object->t, p);
        lt_mat3_mulvec(back, p, p);
        if (synth_sdf_at(&object->prop->sdf, p, NULL) < BARE)
            return true;
    }
    return false;
}

static void find_bare(layout *l)
{
    detect_picture *p = l->out;

    for (int i = 0; i < p->n_put; i++)
        if (p->put[i].grip) {
            bool bare = true;
            for (int j = 0; j < p->n_put; j++)
                bare = bare && !(p->put[j].prop && touches(&p->put[i], &p->put[j]));
            p->bare[p->put[i].thing] = bare;
        }
}

/* One hand, or two. */
static lt_status add_near(layout *l)
{
    const int n = 1 + (lt_rng_uniform(&l->r) > 0.7);
    lt_status st = LT_OK;

    l->near = true;
    for (int i = 0; !st && i < n; i++)
        st = layout_add_arm(l);
    l->near = false;
    return st;
}

static lt_status fill(layout *l)
{
    static const double people[2] = { 0.5, 0.88 }, reaching[2] = { 0.4, 0.78 };     /* up to none, up to one */
    const double a = lt_rng_uniform(&l->r), b = lt_rng_uniform(&l->r);
    const int n_people = (a > people[0]) + (a > people[1]), n_arms = (b > reaching[0]) + (b > reaching[1]);
    const uint32_t first = lt_rng_below(&l->r, DETECT_PEOPLE);
    lt_status st = LT_OK;

    for (int i = 0; !st && i < n_people; i++)
        st = layout_add_person(l, &l->place->person[(first + (uint32_t)i) % DETECT_PEOPLE]);
    for (int i = 0; !st && i < n_arms; i++)
        st = layout_add_arm(l);
    if (!st)
        layout_add_objects(l);
    return st;
}

/* Rooms of takes have none, for their cameras look down. */
static void add_ceiling(layout *l)
{
    const synth_material white = { .albedo = { 0.75f, 0.74f, 0.72f }, .specular = 0.02f, .shininess = 8 };
    lt_mesh *sheet = lt_arena_alloc(l->arena, sizeof(*sheet));
    const synth_instance in = { .mesh = sheet, .R_world_obj = { 1, 0, 0, 0, -1, 0, 0, 0, -1 },
                                .t_world_obj = { 0, 0, CEILING }, .material = white, .no_shadow = true };

    if (!sheet)
        return;
    *sheet = primitive_sheet(l->arena, 8, 8, 1, 1);
    synth_world_place(&l->out->world, -1, &in);
}

/* A draw of its own: the other pictures are the same for any share. */
static bool is_near(const detect_place *place, int64_t i)
{
    lt_rng r = lt_rng_make(place->seed, lt_rng_mix(NEAR, (uint64_t)i));

    return lt_rng_uniform(&r) < place->near;
}

lt_status detect_lay_out(lt_arena *arena, const detect_place *place, int64_t i, detect_picture *out)
{
    layout *l = lt_arena_alloc(arena, sizeof(*l));
    lt_status st = LT_OK;

    if (!l)
        return lt_error(LT_ENOMEM, "synth: no memory for a picture");
    *l = (layout){ .arena = arena, .place = place, .out = out, .number = i,
                   .r = lt_rng_make(place->seed, lt_rng_mix(PICTURE, (uint64_t)i)) };
    memset(out, 0, sizeof(*out));
    out->room = *place->room;
    out->near = is_near(place, i);
    draw_camera(l);
    if (out->near)
        st = add_near(l);
    if (!st && lt_rng_uniform(&l->r) >= EMPTY)
        st = fill(l);
    if (st)
        return st;
    find_bare(l);
    synth_clear_way(&out->room, l->ball, l->n_balls);
    synth_world_room(&out->world, &out->room);
    add_ceiling(l);
    return LT_OK;
}

void detect_develop(const detect_place *place, int64_t number, synth_frame *f)
{
    const uint64_t stream = lt_rng_mix(SENSOR, (uint64_t)number);
    lt_rng rng = lt_rng_make(place->seed, stream);
    synth_sensor sensor = synth_sensor_random(place->seed, stream);
    const bool blurred = lt_rng_below(&rng, 4) == 0;

    for (int k = 0; k < 2; k++) {
        const double path = 2.5 * lt_rng_normal(&rng);
        sensor.motion[k] = blurred ? (float)fmax(-6, fmin(6, path)) : 0;
    }
    synth_sensor_image(&sensor, f);
}

lt_status detect_place_new(lt_arena *arena, int64_t n, detect_place *p)
{
    const uint64_t stream = lt_rng_mix(PLACE, (uint64_t)n);
    synth_room *room = synth_room_new(arena, p->seed, stream, 0.1);

    for (int i = 0; room && i < room->n_instances; i++)
        if (room->instance[i].material.texture && !synth_texture_paint(room->instance[i].material.texture))
            room = NULL;
    if (!room)
        return lt_error(LT_ENOMEM, "synth: no memory for a room");
    p->room = room;
    for (int i = 0; i < DETECT_PEOPLE; i++) {
        const int number = (int)n * DETECT_PEOPLE + i;
        const lt_status st = synth_person_draw(arena, p->hand, p->seed, number, number, &p->person[i]);
        if (st)
            return st;
    }
    return LT_OK;
}
