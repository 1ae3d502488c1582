/* SPDX-License-Identifier: Apache-2.0 */
/* Every draw stands in a statement of its own, as C leaves the order of arguments open. */
#include "synth/body/stance.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "synth/body/limb.h"
#include "synth/world/person.h"

#include <math.h>
#include <string.h>

#define DEGREE 0.017453292519943295

enum { DRAWS = 24 };                            /* of an arm, before it hangs down */

static const double HOLDS = 0.45;               /* share of hands that reach with something in them */
static const double HANGS = 0.15;               /* share of arms that hang down */
static const double SOLE = 0.026;               /* metres from the ball of the foot down */

typedef struct {
    const synth_body_place *place;
    lt_rig rig;
    lt_rng *r;
    synth_body_stance *s;
    double joint[BODY_JOINTS][3];               /* as far as the pose is known */
} pose;

/* ---- joints -------------------------------------------------------------------------------------------- */

static void set(pose *p, int joint, double x, double y, double z)
{
    const double *lo = synth_body_limits[joint].lo, *hi = synth_body_limits[joint].hi;
    const double angle[3] = { fmax(lo[0], fmin(hi[0], x)), fmax(lo[1], fmin(hi[1], y)), fmax(lo[2], fmin(hi[2], z)) };

    synth_body_rotation(angle, p->s->R[joint]);
}

static double spread(pose *p, double degrees) { return degrees * DEGREE * fmax(-2, fmin(2, lt_rng_normal(p->r))); }

static void find_joints(pose *p)
{
    lt_rig_pose(&p->rig, p->s->R[0], p->s->shape, p->s->trans, NULL, p->joint[0]);
}

/* A joint's frame in the world. */
static void world_of(const pose *p, int joint, double out[9])
{
    memcpy(out, p->s->R[joint], 9 * sizeof(*out));
    for (int j = p->rig.parents[joint]; j >= 0; j = p->rig.parents[j]) {
        double R[9];

        lt_mat3_mul(p->s->R[j], out, R);
        memcpy(out, R, sizeof(R));
    }
}

/* ---- trunk and legs ------------------------------------------------------------------------------------ */

static void bend_trunk(pose *p)
{
    const double lean = lt_rng_range(p->r, -2, p->s->sits ? 30 : 38) * DEGREE;
    const double twist = spread(p, 9), sway = spread(p, 4);
    const double nod = lt_rng_range(p->r, -8, 26) * DEGREE, look = spread(p, 22), tilt = spread(p, 6);
    static const int spine[3] = { BODY_SPINE1, BODY_SPINE2, BODY_SPINE3 };

    for (int i = 0; i < 3; i++)
        set(p, spine[i], lean / 3, twist / 3, sway / 3);
    set(p, BODY_NECK, nod / 2, look / 2, tilt / 2);
    set(p, BODY_HEAD, nod / 2, look / 2, tilt / 2);
}

static void bend_legs(pose *p)
{
    for (int side = 0; side < 2; side++) {
        const double out = side ? -1 : 1;
        const double thigh = p->s->sits ? lt_rng_range(p->r, -95, -78) : lt_rng_range(p->r, -16, 10);
        const double shin = p->s->sits ? lt_rng_range(p->r, 62, 105) : lt_rng_range(p->r, 2, 14);
        const double apart = lt_rng_range(p->r, -1, p->s->sits ? 16 : 9), turned = lt_rng_range(p->r, -2, 14);

        set(p, BODY_HIP + side, thigh * DEGREE, out * turned * DEGREE, out * apart * DEGREE);
        set(p, BODY_KNEE + side, shin * DEGREE, 0, 0);
        set(p, BODY_ANKLE + side, -0.8 * (thigh + shin) * DEGREE, 0, 0);
    }
}

/* At the far side of the table in three of five, else at its ends. */
static void choose_seat(pose *p)
{
    static const double sides[3][4] = { { 0.5, 1, 0, 1 }, { 0, 0.5, -1, 0 }, { 1, 0.5, 1, 0 } };
    const double *table = p->place->table, *q = sides[lt_rng_below(p->r, 5) % 3];
    const double slide = lt_rng_range(p->r, -0.3, 0.3), turn = spread(p, 14);
    synth_body_stance *s = p->s;

    s->sits = lt_rng_below(p->r, 5) < 3;
    s->facing = atan2(-q[3], -q[2]) + turn;
    s->seat[2] = p->place->floor;
    s->seat[0] = lt_rng_range(p->r, 0.14, 0.34);
    s->seat[1] = table[1] + q[1] * (table[3] - table[1]) + s->seat[0] * q[3] + slide * fabs(q[2]);
    s->seat[0] = table[0] + q[0] * (table[2] - table[0]) + s->seat[0] * q[2] + slide * fabs(q[3]);
}

/* The pelvis above the seat, so that the lower foot is on the floor. */
static void put_down(pose *p)
{
    synth_body_stance *s = p->s;
    const double c = cos(s->facing), d = sin(s->facing);
    const double R[9] = { -d, 0, c, c, 0, d, 0, 1, 0 };         /* columns: left, up, forward */
    double lowest = INFINITY;

    memcpy(s->R[0], R, sizeof(R));
    memset(s->trans, 0, sizeof(s->trans));
    find_joints(p);
    for (int side = 0; side < 2; side++)
        lowest = fmin(lowest, fmin(p->joint[BODY_FOOT + side][2] - SOLE, p->joint[BODY_ANKLE + side][2] - 0.07));
    for (int k = 0; k < 3; k++)
        s->trans[k] = k < 2 ? s->seat[k] - p->joint[0][k] : s->seat[2] - lowest;
    find_joints(p);
}

/* ---- arms ---------------------------------------------------------------------------------------------- */

/* Upper arm and forearm from the shoulder over the elbow to the wrist. */
static void aim(pose *p, int side, const double elbow[3], const double wrist[3])
{
    double collar[9];

    world_of(p, BODY_COLLAR + side, collar);
    synth_limb_aim(side, collar, p->joint[BODY_SHOULDER + side], elbow, wrist, p->s->R[BODY_SHOULDER + side],
                   p->s->R[BODY_ELBOW + side]);
}

/* The forearm turns, and the wrist bends. */
static void turn_hand(pose *p, int side)
{
    const double out = side ? -1 : 1;
    const double twist = lt_rng_range(p->r, -80, 55) * DEGREE, raise = lt_rng_range(p->r, -40, 40) * DEGREE;
    const double aside = lt_rng_range(p->r, -14, 20) * DEGREE;
    double elbow[3];

    synth_body_angles(p->s->R[BODY_ELBOW + side], elbow);
    set(p, BODY_ELBOW + side, 0.6 * twist, elbow[1], 0);
    set(p, BODY_WRIST + side, 0.4 * twist, out * aside, out * raise);
}

static void set_fingers(pose *p, int side, const synth_grip *g)
{
    synth_limb_fingers(side, g->pose, p->s->R);
    p->s->grip[side] = g;
}

/* What the hand holds goes where the hand is. */
static void set_object(pose *p, int side)
{
    double world[9];

    world_of(p, BODY_WRIST + side, world);
    synth_limb_object(side, p->s->grip[side], world, p->joint[BODY_WRIST + side], p->s->object_R[side],
                      p->s->object_t[side]);
}

static bool over_table(const pose *p, const double x[3])
{
    const double *t = p->place->table;

    return x[0] > t[0] - 0.04 && x[0] < t[2] + 0.04 && x[1] > t[1] - 0.04 && x[1] < t[3] + 0.04;
}

static bool is_clear(const pose *p, const double x[3], double room)
{
    return x[2] > room || x[2] < -0.12 || !over_table(p, x);
}

/* Whether hand, what it holds, and forearm are out of the table, and the hand out of the trunk. */
static bool arm_is_free(const pose *p, int side)
{
    const double *wrist = p->joint[BODY_WRIST + side], *elbow = p->joint[BODY_ELBOW + side];
    const synth_grip *g = p->s->grip[side];

    for (int k = 0; k < BODY_HAND_JOINTS; k++)
        if (!is_clear(p, p->joint[BODY_FINGERS + side * BODY_HAND_JOINTS + k], 0.02))
            return false;
    for (int i = 0; i <= 6; i++) {
        double x[3];

        for (int k = 0; k < 3; k++)
            x[k] = wrist[k] + i * (elbow[k] - wrist[k]) / 6;
        if (!is_clear(p, x, 0.045))
            return false;
    }
    for (int v = 0; g && g->prop && v < g->prop->mesh.n_vertices; v += 7) {
        const float *q = g->prop->mesh.vertex[v];
        double x[3];

        lt_rigid_apply(p->s->object_R[side], p->s->object_t[side], (double[]){ q[0], q[1], q[2] }, x);
        if (!is_clear(p, x, 0.002))
            return false;
    }
    return true;
}

static void rest_hand(pose *p, int side)
{
    for (int k = 0; k < BODY_HAND_JOINTS; k++) {
        const float *mean = p->place->body->model->hand_mean[side] + 3 * k;

        lt_rot_from_axis_angle((double[]){ mean[0], mean[1], mean[2] },
                               p->s->R[BODY_FINGERS + side * BODY_HAND_JOINTS + k]);
    }
    p->s->grip[side] = NULL;
}

static void let_hang(pose *p, int side)
{
    const double out = side ? -1 : 1, down = lt_rng_range(p->r, -78, -66), forward = lt_rng_range(p->r, -12, 6);
    const double bent = lt_rng_range(p->r, 6, 24);

    set(p, BODY_COLLAR + side, 0, 0, 0);
    set(p, BODY_SHOULDER + side, forward * DEGREE, 0, out * down * DEGREE);
    set(p, BODY_ELBOW + side, -20 * DEGREE, -out * bent * DEGREE, 0);
    set(p, BODY_WRIST + side, 0, 0, 0);
    rest_hand(p, side);
    find_joints(p);
}

/* Where a wrist may be before a person: over the table, before the chest, at the face now and then. */
static void draw_wrist(pose *p, int side, const synth_reach *reach, double out[3])
{
    const bool high = lt_rng_below(p->r, 6) == 0;
    const double ahead = lt_rng_range(p->r, 0.16, 0.5), inward = lt_rng_range(p->r, -0.14, 0.22);
    const double up = high ? lt_rng_range(p->r, -0.1, 0.2) : lt_rng_range(p->r, -0.42, -0.12);

    for (int k = 0; k < 3; k++)
        out[k] = reach->shoulder[side][k] + ahead * reach->forward[k] + (side ? 1 : -1) * inward * reach->left[k] +
                 (k == 2) * up;
}

static void find_reach(const pose *p, synth_reach *out)
{
    const double c = cos(p->s->facing), d = sin(p->s->facing);

    *out = (synth_reach){ .forward = { c, d, 0 }, .left = { -d, c, 0 },
                          .upper = lt_vec3_distance(p->joint[BODY_SHOULDER], p->joint[BODY_ELBOW]),
                          .fore = lt_vec3_distance(p->joint[BODY_ELBOW], p->joint[BODY_WRIST]) };
    for (int side = 0; side < 2; side++)
        memcpy(out->shoulder[side], p->joint[BODY_SHOULDER + side], sizeof(out->shoulder[side]));
}

static bool try_reach(pose *p, int side)
{
    const double swivel = lt_rng_range(p->r, 0.05, 0.9);
    synth_reach reach;
    double wrist[3], elbow[3];

    find_reach(p, &reach);
    draw_wrist(p, side, &reach, wrist);
    synth_reach_elbow(&reach, side, swivel, wrist, elbow);
    aim(p, side, elbow, wrist);
    turn_hand(p, side);
    find_joints(p);
    if (p->s->grip[side])
        set_object(p, side);
    return synth_body_within(BODY_SHOULDER + side, p->s->R[BODY_SHOULDER + side]) && arm_is_free(p, side);
}

static void place_arm(pose *p, int side)
{
    const synth_body_place *place = p->place;
    const bool hangs = lt_rng_uniform(p->r) < HANGS, holds = lt_rng_uniform(p->r) < HOLDS;

    rest_hand(p, side);
    for (int i = 0; !hangs && i < DRAWS; i++) {
        bool held = holds && i < DRAWS / 2;
        int n = 0;

        for (int g = 0; g < place->n_grips[side]; g++)
            n += (place->grip[side][g].prop != NULL) == held;
        if (n > 0) {
            int which = (int)lt_rng_below(p->r, (uint32_t)n), g = 0;

            while ((place->grip[side][g].prop != NULL) != held || which-- > 0)
                g++;
            set_fingers(p, side, &place->grip[side][g]);
        }
        if (try_reach(p, side))
            return;
    }
    let_hang(p, side);
}

void synth_stance_draw(const synth_body_place *place, const double *shape, lt_rng *rng, synth_body_stance *out)
{
    pose p = { .place = place, .rig = synth_body_rig(place->body->model), .r = rng, .s = out };

    memset(out, 0, sizeof(*out));
    for (int j = 0; j < BODY_JOINTS; j++)
        lt_mat3_identity(out->R[j]);
    memcpy(out->shape, shape, BODY_SHAPES * sizeof(*shape));
    for (int k = BODY_SHAPES; k < BODY_DIRECTIONS; k++)
        out->shape[k] = 0.8 * fmax(-2, fmin(2, lt_rng_normal(rng)));
    choose_seat(&p);
    bend_trunk(&p);
    bend_legs(&p);
    set(&p, BODY_JAW, fmax(0, spread(&p, 4)), 0, 0);
    put_down(&p);
    for (int side = 0; side < 2; side++)
        place_arm(&p, side);
}
