/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/workplace/robot.h"

#include "libtensor/geometry/mat3.h"
#include "synth/room/primitive.h"
#include "synth/workplace/act.h"

#include <math.h>

enum {
    WAITS = 6, AWAY = 48,           /* frames from a handing over: it has hold, it has carried it away */
    COMES = 52, OFFERS = 10,        /* frames before a giving: it begins to bring it, it holds it out */
    LETS_GO = 4, GOES = 30,         /* frames from a giving; on the way from or to where it rests */
};

static const double SHOULDER = 0.32, LINK = 0.5;            /* metres: height over the table, length of either link */
static const double ARCH = 0.08;                            /* metres that what it carries is lifted on the way */

static void carry(const synth_settled *from, const synth_settled *to, double share, synth_settled *at)
{
    act_blend(from, to, share, at);
    at->t[2] += 4 * ARCH * share * (1 - share);
}

void robot_takes(const workplace_script *s, const workplace_hold *h, int k, synth_settled *at)
{
    carry(&h->end, &s->object[h->object].kept, act_ease(k, h->to + WAITS, h->to + AWAY), at);
}

void robot_gives(const workplace_script *s, const workplace_hold *h, int k, synth_settled *at)
{
    if (k >= h->from - COMES)
        carry(&s->object[h->object].kept, &h->begin, act_ease(k, h->from - COMES, h->from - OFFERS), at);
}

/* ---- where the gripper is --------------------------------------------------------------------------------- */

/* An object's middle in the world */
static void middle_of(const workplace_object *o, const synth_settled *at, double out[3])
{
    lt_rigid_apply(at->R, at->t, o->middle, out);
}

/* What it does with one object: from `first` to `last` it is where the object is. */
typedef struct {
    int first, last;
    const workplace_hold *hold;
    bool gives;
} errand;

static void gripper_on(const workplace_script *s, const errand *e, int k, double out[3])
{
    const workplace_object *o = &s->object[e->hold->object];
    synth_settled at = e->gives ? o->kept : e->hold->end;

    if (e->gives)
        robot_gives(s, e->hold, k < e->hold->from ? k : e->hold->from, &at);
    else
        robot_takes(s, e->hold, k, &at);
    middle_of(o, &at, out);
}

static errand errand_of(const workplace_hold *h, bool gives)
{
    return gives ? (errand){ h->from - COMES - 2, h->from + LETS_GO, h, true }
                 : (errand){ h->to - LETS_GO, h->to + AWAY + 2, h, false };
}

/* Where its fingers close, and how far they are open, 0 to 1 */
static double find_gripper(const workplace_script *s, int k, double at[3], double *radius)
{
    const double rest[3] = { s->base[0], s->base[1] + 0.2, 0.3 };
    errand before = { .last = -100000 }, after = { .first = 100000 };
    double to[3], away;

    for (int i = 0; i < s->n_people; i++)
        for (int j = 0; j < s->person[i].n_holds; j++)
            for (int gives = 0; gives < 2; gives++) {
                const workplace_hold *h = &s->person[i].hold[j];
                const errand e = errand_of(h, gives);

                if (gives ? h->picked : h->placed)
                    continue;
                if (e.first <= k && e.last > before.last)
                    before = e;
                else if (e.first > k && e.first < after.first)
                    after = e;
            }
    memcpy(at, rest, sizeof(rest));
    *radius = 0.05;
    if (before.hold) {
        gripper_on(s, &before, k < before.last ? k : before.last, to);
        away = act_ease(k, before.last, before.last + GOES);
        for (int c = 0; c < 3; c++)
            at[c] = to[c] + away * (rest[c] - to[c]);
        *radius += (1 - away) * (s->object[before.hold->object].radius - *radius);
    }
    if (after.hold) {
        const double near = act_ease(k, after.first - GOES, after.first);

        gripper_on(s, &after, after.first, to);
        for (int c = 0; c < 3; c++)
            at[c] += near * (to[c] - at[c]);
        *radius += near * (s->object[after.hold->object].radius - *radius);
    }
    if (!before.hold || k > before.last)
        return 1;
    return 1 - act_ease(k, before.first, before.first + 3) + act_ease(k, before.last - 3, before.last);
}

/* ---- its shape -------------------------------------------------------------------------------------------- */

typedef struct {
    lt_arena *arena;
    synth_world *world;
    bool failed;
} building;

/* A box from a along d, a unit vector; its broad side is level */
static void put_box(building *b, const double a[3], const double d[3], const double size[3], const float color[3])
{
    const double up[3] = { 0, fabs(d[2]) > 0.95, fabs(d[2]) <= 0.95 };
    lt_mesh *mesh = lt_arena_alloc(b->arena, sizeof(*mesh));
    synth_instance in = { .mesh = mesh, .moving = true, .material = { .specular = 0.05f, .shininess = 40 } };
    double x[3], y[3];

    lt_vec3_cross(up, d, x);
    lt_vec3_unit(x);
    lt_vec3_cross(d, x, y);
    if (mesh)
        *mesh = primitive_box(b->arena, size, 0.2 * fmin(size[0], size[1]));
    if (!mesh || !mesh->n_vertices) {
        b->failed = true;
        return;
    }
    for (int k = 0; k < 3; k++) {
        in.R_world_obj[3 * k] = x[k];
        in.R_world_obj[3 * k + 1] = y[k];
        in.R_world_obj[3 * k + 2] = d[k];
        in.t_world_obj[k] = a[k];
        in.material.albedo[k] = color[k];
    }
    synth_world_place(b->world, -1, &in);
}

static void put_link(building *b, const double from[3], const double to[3], double thick, const float color[3])
{
    double d[3], size[3] = { thick, thick, 0 };

    lt_vec3_sub(to, from, d);
    size[2] = lt_vec3_unit(d);
    put_box(b, from, d, size, color);
}

lt_status robot_place(lt_arena *arena, const workplace_script *s, int k, synth_world *w)
{
    static const float white[3] = { 0.75f, 0.75f, 0.73f }, dark[3] = { 0.05f, 0.05f, 0.06f };
    const double shoulder[3] = { s->base[0], s->base[1], SHOULDER };
    const double foot[3] = { s->base[0], s->base[1], WORKPLACE_FLOOR };
    building b = { .arena = arena, .world = w };
    double at[3], ahead[3], wrist[3], elbow[3], d[3], far, along, radius;
    const double open = find_gripper(s, k, at, &radius), palm_size[3] = { 0.1, 0.05, 0.04 };
    const double finger_size[3] = { 0.012, 0.03, radius + 0.07 }, apart = radius * 0.75 + 0.025 * open;

    for (int c = 0; c < 3; c++)
        ahead[c] = c < 2 ? at[c] - s->base[c] : 0;
    lt_vec3_unit(ahead);
    for (int c = 0; c < 3; c++)
        wrist[c] = at[c] - (radius + 0.07) * ahead[c];
    lt_vec3_sub(wrist, shoulder, d);
    far = fmin(lt_vec3_unit(d), 1.98 * LINK);
    along = sqrt(LINK * LINK - far * far / 4);
    for (int c = 0; c < 3; c++) {               /* the elbow is above the line, in the plane of base and object */
        wrist[c] = shoulder[c] + far * d[c];
        elbow[c] = shoulder[c] + far / 2 * d[c] + along * ((c == 2) - d[2] * d[c]) / sqrt(fmax(1e-6, 1 - d[2] * d[2]));
    }
    put_link(&b, foot, shoulder, 0.1, dark);
    put_link(&b, shoulder, elbow, 0.06, white);
    put_link(&b, elbow, wrist, 0.045, white);
    put_box(&b, wrist, ahead, palm_size, dark);
    for (int side = -1; side <= 1; side += 2) {
        double from[3] = { wrist[0] - side * apart * ahead[1], wrist[1] + side * apart * ahead[0], wrist[2] };

        put_link(&b, wrist, from, 0.022, dark);
        put_box(&b, from, ahead, finger_size, dark);
    }
    return b.failed ? lt_error(LT_ENOMEM, "synth: no memory for a robot") : LT_OK;
}
