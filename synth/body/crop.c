/* SPDX-License-Identifier: Apache-2.0 */
/* Every draw stands in a statement of its own, as C leaves the order of arguments open. */
#include "synth/body/picture.h"

#include "libtensor/geometry/mat3.h"
#include "synth/room/primitive.h"
#include "synth/take/clearing.h"
#include "synth/take/view.h"

#include <math.h>
#include <string.h>

enum { PICTURE = 0x42504943, SENSOR = 0x42534e53, CAMERAS = 60, LOOKS = 8, BALLS = 24 };
enum { SHRINK = 4 };            /* of the wider picture, where the person is looked for */

#define DEGREE 0.017453292519943295

static const double FLOOR = -0.75;              /* under the table's top */

bool picture_project(const synth_camera *c, const double p[3], double uv[2])
{
    double x[3];

    lt_rigid_apply(c->R_cam_world, c->t_cam_world, p, x);
    uv[0] = c->fx * x[0] / x[2] + c->cx;
    uv[1] = c->fy * x[1] / x[2] + c->cy;
    return x[2] > 0.05;
}

/* Whether enough of the person is before the camera; whether the picture's edge cuts some of it off. */
static bool is_in_view(body_picture *p)
{
    int n = 0;

    for (int v = 0; v < BODY_VERTICES; v += 3) {
        double uv[2];

        if (picture_project(&p->wide, p->vertex[v], uv))
            n += uv[0] >= 0 && uv[0] <= PICTURE_WIDE - 1 && uv[1] >= 0 && uv[1] <= PICTURE_HIGH - 1;
    }
    p->cut = n < BODY_VERTICES / 3 - 2;
    return n > BODY_VERTICES / 9;
}

/* What a detector would find: around what is seen of the person, to a few pixels; false where that is little. */
static lt_status find_box(body_picture *p, synth_frame *small, bool *found)
{
    synth_camera c = p->wide;
    synth_scene scene;
    double *b = p->box;
    lt_status st;

    c.fx /= SHRINK;
    c.fy /= SHRINK;
    c.cx = (c.cx + 0.5) / SHRINK - 0.5;
    c.cy = (c.cy + 0.5) / SHRINK - 0.5;
    c.width = PICTURE_WIDE / SHRINK;
    c.height = PICTURE_HIGH / SHRINK;
    scene = synth_world_scene(&p->world, &p->room, &c);
    scene.n_lights = 0;
    st = synth_render(&scene, small);
    b[0] = b[1] = INFINITY;
    b[2] = b[3] = -INFINITY;
    for (int i = 0; !st && i < c.width * c.height; i++)
        if (small->label[i] == 1) {
            b[0] = fmin(b[0], SHRINK * (i % c.width));
            b[1] = fmin(b[1], SHRINK * (i / c.width));
            b[2] = fmax(b[2], SHRINK * (i % c.width) + SHRINK - 1);
            b[3] = fmax(b[3], SHRINK * (i / c.width) + SHRINK - 1);
        }
    *found = b[2] - b[0] > 60 && b[3] - b[1] > 80;
    return st;
}

/* Before the person, more or less aside, looking at the chest or thereabouts; from within the room. */
static void draw_camera(body_picture *p)
{
    const double focal = lt_rng_range(&p->r, 300, 560), away = exp(lt_rng_range(&p->r, log(0.9), log(2.4)));
    const double aside = 32 * DEGREE * lt_rng_normal(&p->r), up = DEGREE * lt_rng_range(&p->r, -6, 42);
    const double along = lt_rng_uniform(&p->r), roll = 3 * DEGREE * lt_rng_normal(&p->r);
    const double angle = p->stance.facing + fmax(-1.7, fmin(1.7, aside));
    const double *lower = p->joint[BODY_PELVIS], *upper = p->joint[BODY_HEAD];
    double target[3], eye[3];

    for (int k = 0; k < 3; k++)
        target[k] = lower[k] + along * (upper[k] - lower[k]) + 0.08 * away * lt_rng_normal(&p->r);
    eye[0] = fmax(-1.22, fmin(1.22, target[0] + away * cos(up) * cos(angle)));
    eye[1] = fmax(-1.25, fmin(1.22, target[1] + away * cos(up) * sin(angle)));
    eye[2] = fmax(0.1, fmin(1.35, target[2] + away * sin(up)));
    p->wide = (synth_camera){ .fx = focal, .fy = focal, .cx = (PICTURE_WIDE - 1) / 2.0, .cy = (PICTURE_HIGH - 1) / 2.0,
                              .width = PICTURE_WIDE, .height = PICTURE_HIGH };
    synth_view_look(eye, target, roll, &p->wide);
}

/* The part of the wider picture that the network gets, as pixels of the picture that is written. */
static void crop(body_picture *p)
{
    const person_window w = person_window_around(p->box, BODY_PICTURE_WIDTH, BODY_PICTURE_HEIGHT);

    p->camera = p->wide;
    p->camera.fx *= w.scale;
    p->camera.fy *= w.scale;
    p->camera.cx = w.scale * p->wide.cx + w.shift[0];
    p->camera.cy = w.scale * p->wide.cy + w.shift[1];
    p->camera.width = BODY_PICTURE_WIDTH;
    p->camera.height = BODY_PICTURE_HEIGHT;
    p->window = w;
}

/* A pixel of the crop that the wider picture has not. */
bool picture_outside(const body_picture *p, double u, double v)
{
    const double x = (u - p->window.shift[0]) / p->window.scale, y = (v - p->window.shift[1]) / p->window.scale;

    return x < -0.5 || x > PICTURE_WIDE - 0.5 || y < -0.5 || y > PICTURE_HIGH - 0.5;
}

/* A stool. */
static lt_status add_seat(body_picture *p)
{
    static const double size[3] = { 0.38, 0.36, 0.04 }, post[3] = { 0.06, 0.06, 0.3 };
    const float wood[3] = { 0.16f, 0.1f, 0.06f };
    lt_mesh *top = lt_arena_alloc(p->arena, sizeof(*top)), *leg = lt_arena_alloc(p->arena, sizeof(*leg));
    synth_instance in = { .R_world_obj = { 1, 0, 0, 0, 1, 0, 0, 0, 1 },
                          .material = { .specular = 0.03f, .shininess = 20 } };
    double high = INFINITY;

    if (!top || !leg)
        return lt_error(LT_ENOMEM, "synth: no memory for a seat");
    for (int v = 0; v < BODY_VERTICES; v++)     /* under what of the person is over it */
        if (hypot(p->vertex[v][0] - p->stance.seat[0], p->vertex[v][1] - p->stance.seat[1]) < 0.12)
            high = fmin(high, p->vertex[v][2]);
    *top = primitive_box(p->arena, size, 0.01);
    *leg = primitive_box(p->arena, post, 0.01);
    memcpy(in.material.albedo, wood, sizeof(wood));
    memcpy(in.t_world_obj, p->stance.seat, sizeof(in.t_world_obj));
    in.t_world_obj[2] = high - size[2] + 0.015;
    in.mesh = top;
    synth_world_place(&p->world, -1, &in);
    in.mesh = leg;
    in.t_world_obj[2] = FLOOR;
    synth_world_place(&p->world, -1, &in);
    return LT_OK;
}

/* Things on the table give way to arms and to what they hold. */
static void clear_way(body_picture *p)
{
    synth_ball ball[BALLS];
    int n = 0;

    for (int side = 0; side < 2; side++) {
        const double *ends[3] = { p->joint[BODY_ELBOW + side], p->joint[BODY_WRIST + side],
                                  p->joint[BODY_FINGERS + side * BODY_HAND_JOINTS + 4] };

        for (int i = 0; i <= 8; i++) {
            const double *a = ends[i / 5], *b = ends[i / 5 + 1], t = i % 5 / 4.0;
            synth_ball *q = &ball[n++];

            q->radius = i < 5 ? 0.055 : 0.09;
            for (int k = 0; k < 3; k++)
                q->centre[k] = a[k] + t * (b[k] - a[k]);
        }
        if (p->stance.grip[side] && p->stance.grip[side]->prop) {
            memcpy(ball[n].centre, p->stance.object_t[side], sizeof(ball[n].centre));
            ball[n++].radius = 0.13;
        }
    }
    synth_clear_way(&p->room, ball, n);
}

static lt_status furnish(body_picture *p)
{
    synth_instance worn[SYNTH_WORN];
    int n, thing;
    lt_status st;

    p->room = *p->place->room;
    clear_way(p);
    thing = synth_world_thing(&p->world, &(synth_thing){ .kind = SYNTH_PERSON_THING, .owner = -1 });
    st = synth_appearance_wear(p->arena, p->place->body, &p->place->look[p->who], (const double (*)[3])p->vertex, worn,
                               &n);
    for (int i = 0; !st && i < n; i++)
        synth_world_place(&p->world, thing, &worn[i]);
    for (int side = 0; !st && side < 2; side++)
        if (p->stance.grip[side] && p->stance.grip[side]->prop)
            synth_object_place(p->stance.grip[side]->prop, p->stance.object_R[side], p->stance.object_t[side], 0,
                               &p->world);
    if (!st && p->stance.sits)
        st = add_seat(p);
    synth_world_room(&p->world, &p->room);
    return st;
}

static lt_status pose(body_picture *p)
{
    synth_body_place about = { .body = p->place->body, .table = p->place->room->table, .floor = FLOOR };

    for (int side = 0; side < 2; side++) {
        about.grip[side] = p->place->grip[side];
        about.n_grips[side] = p->place->n_grips[side];
    }
    p->rig = synth_body_rig(p->place->body->model);
    p->vertex = lt_arena_array(p->arena, BODY_VERTICES, sizeof(*p->vertex));
    if (!p->vertex)
        return lt_error(LT_ENOMEM, "synth: no memory for a person");
    p->who = (int)lt_rng_below(&p->r, SYNTH_BODY_PEOPLE);
    synth_stance_draw(&about, p->place->shape[p->who], &p->r, &p->stance);
    lt_rig_pose(&p->rig, p->stance.R[0], p->stance.shape, p->stance.trans, p->vertex[0], p->joint[0]);
    return LT_OK;
}

/* The first of some cameras that sees enough. */
static lt_status choose_camera(body_picture *p, synth_frame *small)
{
    bool found = false;
    lt_status st = LT_OK;

    for (int i = 0, looks = 0; !st && !found && i < CAMERAS && looks < LOOKS; i++) {
        draw_camera(p);
        if (is_in_view(p)) {
            st = find_box(p, small, &found);
            looks++;
        }
    }
    if (!st && !found)
        memcpy(p->box, (double[]){ 0, 0, PICTURE_WIDE - 1, PICTURE_HIGH - 1 }, sizeof(p->box));
    crop(p);
    return st;
}

/* As a camera shows it; black where the wider picture ends. */
static void develop(const body_picture *p, int64_t i, synth_frame *f)
{
    const synth_sensor sensor = synth_sensor_random(p->place->seed, lt_rng_mix(SENSOR, (uint64_t)i));

    synth_sensor_image(&sensor, f);
    for (int v = 0; v < f->height; v++)
        for (int u = 0; u < f->width; u++)
            if (picture_outside(p, u, v))
                memset(f->rgb[v * f->width + u], 0, sizeof(*f->rgb));
}

lt_status synth_crop_take(lt_arena *arena, const synth_crop_place *place, int64_t i, synth_frame *small,
                          synth_frame *frame, body_row *out)
{
    body_picture *p = lt_arena_alloc(arena, sizeof(*p));
    synth_scene scene;
    lt_status st;

    if (!p)
        return lt_error(LT_ENOMEM, "synth: no memory for a picture");
    p->arena = arena;
    p->place = place;
    p->r = lt_rng_make(place->seed, lt_rng_mix(PICTURE, (uint64_t)i));
    st = pose(p);
    if (!st)
        st = furnish(p);
    if (!st)
        st = choose_camera(p, small);
    if (st)
        return st;
    scene = synth_world_scene(&p->world, &p->room, &p->camera);
    memcpy(scene.focus, p->joint[BODY_SPINE2], sizeof(scene.focus));
    scene.focus_radius = 0.9;
    st = synth_render(&scene, frame);
    if (st)
        return st;
    picture_truth(p, frame, out);
    develop(p, i, frame);
    return LT_OK;
}
