/* SPDX-License-Identifier: Apache-2.0 */
/* Every draw stands in a statement of its own, as C leaves the order of arguments open. */
#include "synth/workplace/scene.h"

#include "libtensor/geometry/mat3.h"
#include "synth/take/clearing.h"
#include "synth/take/view.h"
#include "synth/workplace/robot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CAMERAS = 0x574b4341, ROOM = 0x574b524f, CLUTTER = 10 };
enum { ACROSS = 5, ALONG = 4 };                 /* balls about where somebody reaches */

/* ---- the room --------------------------------------------------------------------------------------------- */

/* What stands about leaves free where persons reach, what the robot sweeps, and the objects. */
static void clear_way(const workplace_script *s, synth_room *room)
{
    synth_ball ball[WORKPLACE_PEOPLE * ACROSS * ALONG + 2 * WORKPLACE_OBJECTS + ACROSS];
    int n = 0;

    for (int i = 0; i < s->n_people; i++)
        for (int x = 0; x < ACROSS; x++)
            for (int y = 0; y < ALONG; y++)
                ball[n++] = (synth_ball){ { s->person[i].stand[0] + 0.2 * (x - 2), s->table[3] - 0.16 * y, 0.1 },
                                          0.16 };
    for (int k = 0; k < ACROSS; k++) {
        const double share = k / (ACROSS - 1.0);

        ball[n++] = (synth_ball){ { s->base[0] + share * (s->person[0].stand[0] - s->base[0]), s->base[1] * (1 - share),
                                    0.15 }, 0.22 };
    }
    for (int i = 0; i < s->n_objects; i++) {
        ball[n++] = synth_settled_ball(&s->object[i].prop->right.mesh, &s->object[i].at);
        ball[n++] = synth_settled_ball(&s->object[i].prop->right.mesh, &s->object[i].kept);
    }
    synth_clear_way(room, ball, n);
}

lt_status workplace_room(lt_arena *arena, const workplace_script *s, synth_room **out)
{
    const synth_room_measures m = { .table = { s->table[0], s->table[1], s->table[2], s->table[3] },
                                    .walls = { 3.65, 4.2 }, .clear = 0.1, .lamps = 1.7 };
    synth_room *room = synth_room_new_of(arena, s->seed, ROOM, &m, CLUTTER);
    bool painted = room != NULL;

    for (int i = 0; painted && i < room->n_instances; i++)
        painted = !room->instance[i].material.texture || synth_texture_paint(room->instance[i].material.texture);
    *out = room;
    if (!painted)
        return lt_error(LT_ENOMEM, "synth: no memory for a room");
    clear_way(s, room);
    return LT_OK;
}

/* ---- a frame ---------------------------------------------------------------------------------------------- */

/* A hand's own vertices, of the skin's */
static lt_status hand_mesh(lt_arena *arena, const synth_body *body, const synth_instance *skin, int side,
                           synth_instance *out)
{
    const int32_t *row = body->hand[side];
    lt_mesh *m = lt_arena_alloc(arena, sizeof(*m));
    float (*rest)[3] = lt_arena_array(arena, LT_HAND_VERTICES, sizeof(*rest));

    if (m)
        *m = (lt_mesh){ .n_vertices = LT_HAND_VERTICES,
                        .vertex = lt_arena_array(arena, LT_HAND_VERTICES, sizeof(*m->vertex)),
                        .normal = lt_arena_array(arena, LT_HAND_VERTICES, sizeof(*m->normal)),
                        .color = lt_arena_array(arena, LT_HAND_VERTICES, sizeof(*m->color)),
                        .face = lt_arena_array(arena, 2 * LT_HAND_FACES, sizeof(*m->face)) };
    if (!m || !rest || !m->vertex || !m->normal || !m->color || !m->face)
        return lt_error(LT_ENOMEM, "synth: no memory for hands");
    for (int i = 0; i < LT_HAND_VERTICES; i++) {
        memcpy(m->vertex[i], skin->mesh->vertex[row[i]], sizeof(*m->vertex));
        memcpy(m->normal[i], skin->mesh->normal[row[i]], sizeof(*m->normal));
        memcpy(m->color[i], skin->mesh->color[row[i]], sizeof(*m->color));
        memcpy(rest[i], skin->rest[row[i]], sizeof(*rest));
    }
    *out = *skin;
    out->mesh = m;
    out->rest = (const float (*)[3])rest;
    return LT_OK;
}

/* The skin's faces of hands become meshes of their own. */
static lt_status part_hands(lt_arena *arena, const synth_body *body, synth_instance *skin, synth_instance hand[2])
{
    lt_mesh *rest = (lt_mesh *)skin->mesh;
    int32_t *own = lt_arena_array(arena, BODY_VERTICES, sizeof(*own));      /* 1 + number in its hand; right: < 0 */
    lt_status st = own ? LT_OK : lt_error(LT_ENOMEM, "synth: no memory for hands");
    int n = 0;

    for (int side = 0; side < 2 && !st; side++) {
        st = hand_mesh(arena, body, skin, side, &hand[side]);
        for (int i = 0; i < LT_HAND_VERTICES; i++)
            own[body->hand[side][i]] = side ? -(1 + i) : 1 + i;
    }
    for (int f = 0; f < rest->n_faces && !st; f++) {
        const int32_t *v = rest->face[f];
        const int a = own[v[0]], b = own[v[1]], c = own[v[2]];

        if ((a > 0 && b > 0 && c > 0) || (a < 0 && b < 0 && c < 0)) {
            lt_mesh *to = (lt_mesh *)hand[a < 0].mesh;

            memcpy(to->face[to->n_faces++], (int32_t[]){ abs(a) - 1, abs(b) - 1, abs(c) - 1 }, sizeof(*to->face));
        } else
            memmove(rest->face[n++], v, sizeof(*rest->face));
    }
    rest->n_faces = st ? 0 : n;
    return st;
}

static lt_status dress(lt_arena *arena, workplace_scene *c, int i)
{
    const workplace_script *s = c->script;
    const workplace_person *p = &s->person[i];
    const int first = s->n_people + 2 * i;
    synth_instance worn[SYNTH_WORN], hand[2];
    lt_status st;
    int n;

    c->vertex[i] = lt_arena_array(arena, BODY_VERTICES, sizeof(*c->vertex[i]));
    if (!c->vertex[i])
        return lt_error(LT_ENOMEM, "synth: no memory for a person");
    lt_rig_pose(&p->body.rig, c->who[i].body.R[0], p->body.shape, c->who[i].body.trans, c->vertex[i][0], NULL);
    st = synth_appearance_wear(arena, s->body, &p->look, (const double (*)[3])c->vertex[i], worn, &n);
    st = st ? st : part_hands(arena, s->body, &worn[n - 1], hand);
    for (int k = 0; !st && k < n; k++)
        synth_world_place(&c->world, i, &worn[k]);
    for (int side = 0; !st && side < 2; side++)
        synth_world_place(&c->world, first + side, &hand[side]);
    return st;
}

static void list_things(workplace_scene *c)
{
    const workplace_script *s = c->script;

    for (int i = 0; i < s->n_people; i++)
        synth_world_thing(&c->world, &(synth_thing){ .kind = SYNTH_PERSON_THING, .owner = -1, .identity = 1 + i });
    for (int i = 0; i < 2 * s->n_people; i++)
        synth_world_thing(&c->world, &(synth_thing){ .kind = SYNTH_HAND_THING, .owner = i / 2, .left = i % 2 == 0,
                                                     .identity = 11 + i });
}

lt_status workplace_scene_at(lt_arena *arena, const workplace_script *s, const synth_room *room, int k,
                             workplace_scene **out)
{
    workplace_scene *c = lt_arena_alloc(arena, sizeof(*c));
    lt_status st = c ? LT_OK : lt_error(LT_ENOMEM, "synth: no memory for a frame");

    if (st)
        return st;
    c->script = s;
    c->k = k;
    list_things(c);
    for (int i = 0; i < s->n_people; i++)
        workplace_person_at(s, i, k, &c->who[i]);
    for (int i = 0; !st && i < s->n_people; i++)
        st = dress(arena, c, i);
    for (int i = 0; i < s->n_objects; i++) {
        workplace_object_at(s, c->who, i, k, &c->object[i], &c->owner[i]);
        synth_object_place(&s->object[i].prop->right, c->object[i].R, c->object[i].t, 21 + i, &c->world);
    }
    st = st ? st : robot_place(arena, s, k, &c->world);
    synth_world_room(&c->world, room);
    *out = c;
    return st;
}

lt_status workplace_scene_draw(const workplace_scene *c, const synth_room *room, const synth_camera *camera,
                               synth_frame *frame)
{
    synth_scene scene = synth_world_scene(&c->world, room, camera);
    const double middle[3] = { 0, 0.3, 0.2 };

    memcpy(scene.focus, middle, sizeof(middle));
    scene.focus_radius = 1.1 + 0.2 * c->script->n_people;
    return synth_render(&scene, frame);
}

/* ---- cameras ---------------------------------------------------------------------------------------------- */

static void look(const double eye[3], const double target[3], double roll, recording_camera *c)
{
    synth_camera view = { .width = c->width, .height = c->height };

    synth_view_look(eye, target, roll, &view);
    lt_mat3_transpose(view.R_cam_world, c->R);
    memcpy(c->t, eye, sizeof(c->t));
}

/* Where each stands and looks; a little off, as real ones are. */
static void aim(const workplace_script *s, int i, lt_rng *r, recording_camera *c)
{
    const double wide = s->table[2], side = s->base[0] > 0 ? -1 : 1;
    double eye[4][3] = { { 0.3 * side, -1.75 - 0.15 * (s->n_people - 1), 0.72 },
                         { -0.6 - 0.3 * wide, -0.2, 1.05 }, { 0.6 + 0.3 * wide, -0.25, 1.1 },
                         { side * (2.0 + 0.4 * wide), -0.25, 0.9 } };
    double target[4][3] = { { 0, 0.6, 0.14 }, { 0.1, 0.1, 0 }, { -0.1, 0.1, 0 }, { 0, 0.5, 0.12 } };
    const double focal[4] = { 500, 520, 520, 540 };
    double roll;

    for (int k = 0; k < 3; k++) {
        eye[i][k] += lt_rng_range(r, -0.06, 0.06);
        target[i][k] += lt_rng_range(r, -0.04, 0.04);
    }
    roll = lt_rng_range(r, -0.03, 0.03);
    c->K.fx = focal[i] * lt_rng_range(r, 0.99, 1.01);
    c->K.fy = c->K.fx * 1.001;
    c->K.cx = (WORKPLACE_WIDTH - 1) / 2.0 + lt_rng_range(r, -8, 8);
    c->K.cy = (WORKPLACE_HEIGHT - 1) / 2.0 + lt_rng_range(r, -8, 8);
    look(eye[i], target[i], roll, c);
}

void workplace_rig(const workplace_script *s, int n, int shrink, recording_rig *out)
{
    static const struct { const char *name; recording_role role; } all[RECORDING_CAMERAS] = {
        { "front", RECORDING_FRONT }, { "table-left", RECORDING_TABLE }, { "table-right", RECORDING_TABLE },
        { "side", RECORDING_SIDE },
    };

    *out = (recording_rig){ .n = n, .fps = WORKPLACE_FPS, .has_robot = true, .synthetic = true };
    memcpy(out->robot, s->robot, sizeof(out->robot));
    for (int i = 0; i < n; i++) {
        lt_rng r = lt_rng_make(s->seed, lt_rng_mix(CAMERAS, (uint64_t)i));
        recording_camera *c = &out->camera[i];

        *c = (recording_camera){ .name = all[i].name, .role = all[i].role, .width = WORKPLACE_WIDTH / shrink,
                                 .height = WORKPLACE_HEIGHT / shrink, .placed = true,
                                 .depth_scale = WORKPLACE_DEPTH_STEP };
        aim(s, i, &r, c);
        c->K.fx /= shrink;
        c->K.fy /= shrink;
        c->K.cx = (c->K.cx + 0.5) / shrink - 0.5;
        c->K.cy = (c->K.cy + 0.5) / shrink - 0.5;
    }
}

synth_camera workplace_camera(const recording_camera *c)
{
    synth_camera out = { .fx = c->K.fx, .fy = c->K.fy, .cx = c->K.cx, .cy = c->K.cy, .width = c->width,
                         .height = c->height };

    lt_mat3_transpose(c->R, out.R_cam_world);
    lt_mat3_mulvec(out.R_cam_world, c->t, out.t_cam_world);
    for (int k = 0; k < 3; k++)
        out.t_cam_world[k] = -out.t_cam_world[k];
    return out;
}
