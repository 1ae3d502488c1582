/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/body/follow.h"

#include "libtensor/geometry/mat3.h"
#include "synth/body/limb.h"

#include <math.h>
#include <string.h>

enum { TRIES = 4 };                             /* bones at rest are not quite straight: aim, look, aim off */

static const double STRETCH = 0.992;            /* of a limb that is as good as straight */
static const double FOREARM = 0.65;             /* share of a hand's twist that the forearm does, the wrist the rest */
static const double TWIST_MIDDLE = 0.35, TWIST[2] = { -1.75, 2.25 };      /* radians: of a forearm with its wrist */
static const double SOFT = 0.006;               /* metres: how softly one leg's reach gives way to the other's */

typedef struct {
    const synth_follower *who;
    const synth_body_goal *goal;
    synth_body_pose *out;
} following;

static void set(following *f, int joint, double x, double y, double z)
{
    const double *lo = synth_body_limits[joint].lo, *hi = synth_body_limits[joint].hi;
    const double angle[3] = { fmax(lo[0], fmin(hi[0], x)), fmax(lo[1], fmin(hi[1], y)), fmax(lo[2], fmin(hi[2], z)) };

    synth_body_rotation(angle, f->out->R[joint]);
}

static void find_joints(following *f)
{
    synth_body_pose *p = f->out;
    double root[3];

    for (int k = 0; k < 3; k++)
        root[k] = f->who->rest[0][k] + p->trans[k];
    lt_rig_chain(BODY_JOINTS, f->who->rig.parents, f->who->rest, p->R[0], root, p->world, p->joint);
}

static double bone(const synth_follower *who, int joint, int next)
{
    return lt_vec3_distance(who->rest[joint], who->rest[next]);
}

/* The joint between two bones from a to b, bent to the side; b comes as near as they reach. d: the way there */
static void bend_between(const double a[3], double b[3], double upper, double lower, const double to[3], double d[3],
                         double between[3])
{
    double side[3], far, along;

    lt_vec3_sub(b, a, d);
    far = lt_vec3_unit(d);
    far = fmin(fmax(far, fabs(upper - lower) + 0.02), STRETCH * (upper + lower));
    along = (far * far + upper * upper - lower * lower) / (2 * far);
    for (int k = 0; k < 3; k++)
        side[k] = to[k] - lt_vec3_dot(to, d) * d[k];
    lt_vec3_unit(side);
    for (int k = 0; k < 3; k++) {
        b[k] = a[k] + far * d[k];
        between[k] = a[k] + along * d[k] + sqrt(fmax(0, upper * upper - along * along)) * side[k];
    }
}

/* ---- trunk ---------------------------------------------------------------------------------------------- */

static void bend_trunk(following *f)
{
    static const int spine[3] = { BODY_SPINE1, BODY_SPINE2, BODY_SPINE3 };
    const synth_body_goal *g = f->goal;

    for (int i = 0; i < 3; i++)
        set(f, spine[i], g->lean / 3, g->twist / 3, g->sway / 3);
    set(f, BODY_NECK, g->nod / 2, g->look / 2, 0);
    set(f, BODY_HEAD, g->nod / 2, g->look / 2, 0);
}

/* As high as the shorter of the two reaches lets it, with a soft edge between them. */
static double pelvis_height(const following *f)
{
    const synth_follower *who = f->who;
    const synth_body_goal *g = f->goal;
    double up[2];

    for (int side = 0; side < 2; side++) {
        const int hip = BODY_HIP + side, knee = BODY_KNEE + side;
        const double leg = STRETCH * (bone(who, hip, knee) + bone(who, knee, BODY_ANKLE + side));
        const double away = hypot(f->out->joint[hip][0] - g->foot[side][0], f->out->joint[hip][1] - g->foot[side][1]);

        up[side] = g->floor + who->ankle + g->lift[side] + sqrt(fmax(0.01, leg * leg - away * away))
                   - (f->out->joint[hip][2] - f->out->joint[0][2]);
    }
    return fmin(up[0], up[1]) - SOFT * log1p(exp(-fabs(up[0] - up[1]) / SOFT));
}

static void place_trunk(following *f)
{
    const double c = cos(f->goal->facing), s = sin(f->goal->facing);
    const double R[9] = { -s, 0, c, c, 0, s, 0, 1, 0 };         /* columns: left, up, forward */
    double *trans = f->out->trans;

    memcpy(f->out->R[0], R, sizeof(R));
    bend_trunk(f);
    for (int k = 0; k < 3; k++)
        trans[k] = (k < 2 ? f->goal->pelvis[k] : 0) - f->who->rest[0][k];
    find_joints(f);
    trans[2] += pelvis_height(f);
    find_joints(f);
}

/* ---- legs ----------------------------------------------------------------------------------------------- */

static void aim_leg(following *f, int side, const double target[3])
{
    const synth_follower *who = f->who;
    const int hip = BODY_HIP + side, knee = BODY_KNEE + side, ankle = BODY_ANKLE + side;
    const double heading = f->goal->heading[side], forward[3] = { cos(heading), sin(heading), 0 };
    double at[3], middle[3], d[3], x[3], y[3], z[3], shin[3], back[9], local[9], angle[3];

    memcpy(at, target, sizeof(at));
    bend_between(f->out->joint[hip], at, bone(who, hip, knee), bone(who, knee, ankle), forward, d, middle);
    lt_vec3_sub(f->out->joint[hip], middle, y);
    lt_vec3_sub(at, middle, shin);
    lt_vec3_unit(y);
    lt_vec3_unit(shin);
    lt_vec3_cross(forward, d, x);
    lt_vec3_unit(x);
    lt_vec3_cross(x, y, z);
    const double world[9] = { x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2] };
    lt_mat3_transpose(f->out->world[0], back);
    lt_mat3_mul(back, world, local);
    synth_body_angles(local, angle);
    set(f, hip, angle[0], angle[1], angle[2]);
    set(f, knee, acos(fmax(-1, fmin(1, -lt_vec3_dot(y, shin)))), 0, 0);
}

/* The sole is level. */
static void level_foot(following *f, int side)
{
    const double c = cos(f->goal->heading[side]), s = sin(f->goal->heading[side]);
    const double level[9] = { -s, 0, c, c, 0, s, 0, 1, 0 };
    double back[9], local[9], angle[3];

    lt_mat3_transpose(f->out->world[BODY_KNEE + side], back);
    lt_mat3_mul(back, level, local);
    synth_body_angles(local, angle);
    set(f, BODY_ANKLE + side, angle[0], angle[1], angle[2]);
}

static void place_leg(following *f, int side)
{
    const synth_body_goal *g = f->goal;
    const double want[3] = { g->foot[side][0], g->foot[side][1], g->floor + f->who->ankle + g->lift[side] };
    double aim[3] = { want[0], want[1], want[2] };

    for (int i = 0; i < TRIES; i++) {
        aim_leg(f, side, aim);
        find_joints(f);
        for (int k = 0; k < 3; k++)
            aim[k] += want[k] - f->out->joint[BODY_ANKLE + side][k];
    }
    level_foot(f, side);
}

/* ---- arms ----------------------------------------------------------------------------------------------- */

static void aim_arm(following *f, int side, const double target[3])
{
    const synth_follower *who = f->who;
    const int shoulder = BODY_SHOULDER + side, elbow = BODY_ELBOW + side;
    double wrist[3], middle[3], d[3], angle[3];

    memcpy(wrist, target, sizeof(wrist));
    bend_between(f->out->joint[shoulder], wrist, bone(who, shoulder, elbow), bone(who, elbow, BODY_WRIST + side),
                 f->goal->elbow[side], d, middle);
    synth_limb_aim(side, f->out->world[BODY_COLLAR + side], f->out->joint[shoulder], middle, wrist,
                   f->out->R[shoulder], f->out->R[elbow]);
    if (!synth_body_within(shoulder, f->out->R[shoulder])) {
        synth_body_angles(f->out->R[shoulder], angle);
        set(f, shoulder, angle[0], angle[1], angle[2]);
    }
}

/* The hand's frame against the forearm's without a twist is Rx(twist) Ry Rz. Half a turn off the middle of what a
 * forearm can do, the twist goes from one side to the other. */
static void find_turn(const following *f, int side, double out[3])
{
    const int elbow = BODY_ELBOW + side;
    double back[9], N[9];

    lt_mat3_transpose(f->out->world[elbow], back);
    lt_mat3_mul(back, f->goal->hand[side], N);
    out[0] = atan2(-N[5], N[8]);
    out[1] = asin(fmax(-1, fmin(1, N[2])));
    out[2] = atan2(-N[1], N[0]);
    if (out[0] < TWIST_MIDDLE - M_PI)
        out[0] += 2 * M_PI;
    out[0] = fmax(TWIST[0], fmin(TWIST[1], out[0]));
}

/* The forearm takes most of the twist, the wrist what is left, and bends. */
static void turn_hand(following *f, int side, const double turn[3])
{
    const int elbow = BODY_ELBOW + side;
    double bent[3], twisted[9], y[9], z[9], angle[3];

    synth_body_angles(f->out->R[elbow], bent);
    set(f, elbow, FOREARM * turn[0], bent[1], 0);
    synth_body_rotation((double[]){ (1 - FOREARM) * turn[0], 0, 0 }, twisted);
    synth_body_rotation((double[]){ 0, turn[1], 0 }, y);
    synth_body_rotation((double[]){ 0, 0, turn[2] }, z);
    lt_mat3_mul(y, z, y);
    lt_mat3_mul(twisted, y, y);
    synth_body_angles(y, angle);
    set(f, BODY_WRIST + side, angle[0], angle[1], angle[2]);
}

static void place_arm(following *f, int side)
{
    const double *want = f->goal->wrist[side];
    double aim[3] = { want[0], want[1], want[2] }, *turn = f->out->turn[side];

    for (int i = 0; i < TRIES; i++) {           /* a twist moves the wrist by some millimetres, too */
        aim_arm(f, side, aim);
        find_joints(f);
        if (f->goal->turned)
            memcpy(turn, f->goal->turn[side], sizeof(f->goal->turn[side]));
        else
            find_turn(f, side, turn);
        turn_hand(f, side, turn);
        find_joints(f);
        for (int k = 0; k < 3; k++)
            aim[k] += want[k] - f->out->joint[BODY_WRIST + side][k];
    }
    synth_limb_fingers(side, f->goal->fingers[side], f->out->R);
}

/* ---- the whole ------------------------------------------------------------------------------------------ */

void synth_follower_init(const synth_body *body, const double shape[BODY_SHAPES], synth_follower *out)
{
    const double straight[9] = { 1, 0, 0, 0, 1, 0, 0, 0, 1 };
    double R[BODY_JOINTS][9], lo = INFINITY, hi = -INFINITY;

    *out = (synth_follower){ .rig = synth_body_rig(body->model) };
    memcpy(out->shape, shape, BODY_SHAPES * sizeof(*shape));
    for (int j = 0; j < BODY_JOINTS; j++)
        memcpy(R[j], straight, sizeof(straight));
    lt_rig_pose(&out->rig, R[0], out->shape, NULL, NULL, out->rest[0]);
    for (int v = 0; v < BODY_VERTICES; v++) {
        double y = body->model->v_template[v][1];

        for (int k = 0; k < BODY_SHAPES; k++)
            y += (double)body->model->shapedirs[((size_t)v * 3 + 1) * BODY_DIRECTIONS + (size_t)k] * shape[k];
        lo = fmin(lo, y);
        hi = fmax(hi, y);
    }
    out->stature = hi - lo;
    out->ankle = out->rest[BODY_ANKLE][1] - lo;
}

void synth_follow(const synth_follower *who, const synth_body_goal *goal, synth_body_pose *out)
{
    following f = { who, goal, out };

    for (int j = 0; j < BODY_JOINTS; j++)
        lt_mat3_identity(out->R[j]);
    place_trunk(&f);
    for (int side = 0; side < 2; side++) {
        place_leg(&f, side);
        place_arm(&f, side);
    }
    find_joints(&f);
}
