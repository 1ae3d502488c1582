/* SPDX-License-Identifier: Apache-2.0 */
/* Every draw stands in a statement of its own, as C leaves the order of arguments open. */
#include "synth/workplace/scene.h"

#include "libtensor/geometry/mat3.h"
#include "synth/take/clearing.h"
#include "synth/take/view.h"
#include "synth/workplace/robot.h"

#include <math.h>
#include <string.h>

enum { CAMERAS = 0x574b4341, ROOM = 0x574b524f, CLUTTER = 8, STRIDE = 8 };

/* ---- the room --------------------------------------------------------------------------------------------- */

/* Around an arm: hand, wrist, forearm. */
static int arm_balls(const synth_body_pose *b, int side, synth_ball *out)
{
    const double *wrist = b->joint[BODY_WRIST + side], *elbow = b->joint[BODY_ELBOW + side];
    const double *finger = b->joint[BODY_FINGERS + side * BODY_HAND_JOINTS + 4];

    for (int i = 0; i < 3; i++) {
        out[i].radius = i ? 0.09 : 0.14;
        for (int k = 0; k < 3; k++)
            out[i].centre[k] = i == 0 ? finger[k] : wrist[k] + 0.5 * (i - 1) * (elbow[k] - wrist[k]);
    }
    return 3;
}

/* What stands about gives way to everything that moves, at any moment. */
static lt_status clear_way(lt_arena *arena, const workplace_script *s, synth_room *room)
{
    const int moments = s->frames / STRIDE + 1, most = moments * (6 * s->n_people + s->n_objects) + s->n_objects + 1;
    synth_ball *ball = lt_arena_array(arena, (size_t)most, sizeof(*ball));
    int n = 0;

    if (!ball)
        return lt_error(LT_ENOMEM, "synth: no memory for a room");
    for (int k = 0; k < moments; k++) {
        workplace_moment who[WORKPLACE_PEOPLE];

        for (int i = 0; i < s->n_people; i++) {
            workplace_person_at(s, i, STRIDE * k, &who[i]);
            for (int side = 0; side < 2; side++)
                n += arm_balls(&who[i].body, side, ball + n);
        }
        for (int i = 0; i < s->n_objects; i++) {
            synth_settled at;
            int owner;

            workplace_object_at(s, who, i, STRIDE * k, &at, &owner);
            ball[n++] = synth_settled_ball(&s->object[i].prop->right.mesh, &at);
        }
    }
    for (int i = 0; i < s->n_objects; i++)
        ball[n++] = synth_settled_ball(&s->object[i].prop->right.mesh, &s->object[i].kept);
    ball[n++] = (synth_ball){ { s->base[0], s->base[1] + 0.2, 0.2 }, 0.25 };
    synth_clear_way(room, ball, n);
    return LT_OK;
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
    return painted ? clear_way(arena, s, room) : lt_error(LT_ENOMEM, "synth: no memory for a room");
}

/* ---- a frame ---------------------------------------------------------------------------------------------- */

/* The skin's faces of hands become instances of their own, which share its vertices. */
static lt_status part_hands(lt_arena *arena, const synth_body *body, synth_instance *skin, synth_instance hand[2])
{
    uint8_t *of = lt_arena_alloc(arena, BODY_VERTICES);
    lt_mesh *rest = (lt_mesh *)skin->mesh;
    int n = 0;

    memset(of ? of : &(uint8_t){ 0 }, 0, of ? BODY_VERTICES : 0);
    for (int side = 0; side < 2; side++) {
        lt_mesh *m = lt_arena_alloc(arena, sizeof(*m));

        if (!of || !m)
            return lt_error(LT_ENOMEM, "synth: no memory for hands");
        *m = *rest;
        m->n_faces = 0;
        m->face = lt_arena_array(arena, 2 * LT_HAND_FACES, sizeof(*m->face));
        if (!m->face)
            return lt_error(LT_ENOMEM, "synth: no memory for hands");
        for (int i = 0; i < LT_HAND_VERTICES; i++)
            of[body->hand[side][i]] = (uint8_t)(1 + side);
        hand[side] = *skin;
        hand[side].mesh = m;
    }
    for (int f = 0; f < rest->n_faces; f++) {
        const int32_t *v = rest->face[f];
        const int side = of[v[0]] && of[v[0]] == of[v[1]] && of[v[0]] == of[v[2]] ? of[v[0]] : 0;
        lt_mesh *to = side ? (lt_mesh *)hand[side - 1].mesh : rest;
        const int at = side ? to->n_faces++ : n++;

        memmove(to->face[at], v, sizeof(to->face[at]));
    }
    rest->n_faces = n;
    return LT_OK;
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
    double eye[4][3] = { { 0.3 * side, -1.75 - 0.15 * (s->n_people - 1), 0.72 }, { -0.6 - 0.3 * wide, -0.2, 1.05 }, { 0.6 + 0.3 * wide, -0.25, 1.1 },
                         { side * (2.1 + 0.4 * wide), 0.15, 0.75 } };
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
