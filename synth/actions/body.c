/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/actions/body.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <string.h>

/* The order of data/action/action.h */
enum {
    PELVIS, L_HIP, R_HIP, L_KNEE, R_KNEE, L_ANKLE, R_ANKLE, NECK, L_SHOULDER, R_SHOULDER, L_ELBOW, R_ELBOW, L_WRIST,
    R_WRIST, L_BIG_TOE, L_SMALL_TOE, L_HEEL, R_BIG_TOE, R_SMALL_TOE, R_HEEL, L_EAR, R_EAR, L_EYE, R_EYE, NOSE, L_HAND,
    R_HAND = L_HAND + 20,
};

/* Lengths in statures, after Drillis and Contini 1966, "Body segment parameters" */
static const double HIP_UP = 0.53, HIP_OUT = 0.052, THIGH = 0.245, SHANK = 0.246, ANKLE_UP = 0.039;
static const double UPPER_ARM = 0.178, FOREARM = 0.15, HAND = 0.108;
static const double CHEST[][3] = {              /* right, up of the pelvis, forward; turned with the trunk */
    { 0, 0.3, 0 }, { -0.11, 0.288, 0 }, { 0.11, 0.288, 0 },
};
static const double HEAD[][3] = {               /* ears, eyes and nose, of the neck; turned with the head */
    { -0.042, 0.088, 0.01 }, { 0.042, 0.088, 0.01 }, { -0.018, 0.1, 0.052 }, { 0.018, 0.1, 0.052 }, { 0, 0.08, 0.064 },
};
static const double FOOT[][3] = {               /* big toe, small toe, heel, of the ankle: out, up, forward */
    { -0.012, -0.034, 0.105 }, { 0.03, -0.034, 0.085 }, { 0, -0.036, -0.03 },
};
/* Of each finger in hand lengths: its base along the hand and to the thumb, then its three bones */
static const double FINGER[FINGERS][5] = {
    { 0.18, 0.18, 0.2, 0.17, 0.14 }, { 0.5, 0.13, 0.22, 0.14, 0.12 }, { 0.51, 0.02, 0.25, 0.16, 0.13 },
    { 0.48, -0.09, 0.23, 0.15, 0.12 }, { 0.44, -0.19, 0.18, 0.11, 0.1 },
};

typedef double vec3[3];

static void add_scaled(const vec3 a, double s, const vec3 b, vec3 out)
{
    for (int k = 0; k < 3; k++)
        out[k] = a[k] + s * b[k];
}

static double dot(const vec3 a, const vec3 b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const vec3 a, const vec3 b, vec3 out)
{
    const vec3 c = { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };

    memcpy(out, c, sizeof(c));
}

/* a without its part along the unit vector d, at length 1 */
static void across(const vec3 a, const vec3 d, vec3 out)
{
    double n;

    add_scaled(a, -dot(a, d), d, out);
    n = fmax(1e-9, sqrt(dot(out, out)));
    for (int k = 0; k < 3; k++)
        out[k] /= n;
}

static void turn_about(int axis, double angle, double R[9])
{
    double aa[3] = { 0 };

    aa[axis] = angle;
    lt_rot_from_axis_angle(aa, R);
}

/* The joint between two bones from a towards b, bent to the side where `bend` points; b comes as near as they reach */
static void reach(const vec3 a, vec3 b, double upper, double lower, const vec3 bend, vec3 between)
{
    vec3 d, side;
    double far, along;

    add_scaled(b, -1, a, d);
    far = sqrt(dot(d, d));
    for (int k = 0; k < 3; k++)
        d[k] /= fmax(1e-9, far);
    far = fmin(fmax(far, fabs(upper - lower) + 1e-3), 0.998 * (upper + lower));
    add_scaled(a, far, d, b);
    along = (far * far + upper * upper - lower * lower) / (2 * far);
    across(bend, d, side);
    add_scaled(a, along, d, between);
    add_scaled(between, sqrt(fmax(0, upper * upper - along * along)), side, between);
}

typedef struct {
    const body_pose *pose;
    double stature, yaw[9], trunk[9];
    vec3 *joint;
} posing;

/* An offset (right, up, forward) in statures, turned, from a joint */
static void put(const posing *p, int joint, int from, const double R[9], const vec3 offset)
{
    const vec3 v = { p->stature * offset[0], -p->stature * offset[1], p->stature * offset[2] };
    vec3 turned;

    lt_mat3_mulvec(R, v, turned);
    add_scaled(p->joint[from], 1, turned, p->joint[joint]);
}

/* A place as the person sees it: right, up, forward of where it stands */
static void place(const posing *p, const vec3 seen, vec3 out)
{
    const vec3 v = { p->stature * seen[0], -p->stature * seen[1], p->stature * seen[2] };
    const vec3 ground = { p->pose->place[0], 0, p->pose->place[1] };

    lt_mat3_mulvec(p->yaw, v, out);
    add_scaled(ground, 1, out, out);
}

static void pose_trunk(posing *p)
{
    const body_pose *b = p->pose;
    double lean[9], twist[9], sway[9], both[9], turn[9], nod[9], head[9];

    turn_about(1, b->yaw, p->yaw);
    turn_about(0, -b->lean, lean);
    turn_about(1, b->twist, twist);
    turn_about(2, b->sway, sway);
    lt_mat3_mul(lean, twist, both);
    lt_mat3_mul(sway, both, lean);
    lt_mat3_mul(p->yaw, lean, p->trunk);
    turn_about(1, b->turn, turn);
    turn_about(0, -b->nod, nod);
    lt_mat3_mul(turn, nod, both);
    lt_mat3_mul(p->trunk, both, head);
    place(p, (vec3){ 0, HIP_UP + 0.02, -0.35 * sin(fmax(0, b->lean)) * 0.3 }, p->joint[PELVIS]);
    for (int i = 0; i < 3; i++)
        put(p, NECK + i, PELVIS, p->trunk, CHEST[i]);
    for (int i = 0; i < 5; i++)
        put(p, L_EAR + i, NECK, head, HEAD[i]);
}

static void pose_leg(posing *p, int side)
{
    const double out = side == LEFT ? -1 : 1;
    const double *foot = p->pose->foot[side];
    const vec3 forward = { p->yaw[2], p->yaw[5], p->yaw[8] };
    vec3 ankle;

    put(p, L_HIP + side, PELVIS, p->yaw, (vec3){ out * HIP_OUT, -0.02, 0 });
    place(p, (vec3){ out * (HIP_OUT + 0.005), ANKLE_UP + foot[1], foot[0] }, ankle);
    reach(p->joint[L_HIP + side], ankle, THIGH * p->stature, SHANK * p->stature, forward, p->joint[L_KNEE + side]);
    memcpy(p->joint[L_ANKLE + side], ankle, sizeof(vec3));
    for (int i = 0; i < 3; i++)
        put(p, (side == LEFT ? L_BIG_TOE : R_BIG_TOE) + i, L_ANKLE + side, p->yaw,
            (vec3){ out * FOOT[i][0], FOOT[i][1], FOOT[i][2] });
}

/* Bones turn about the axis across the hand, towards the palm; the thumb's towards the fingers as well. */
static void pose_fingers(posing *p, int side, const hand_frame *h)
{
    const double size = HAND * p->stature;
    vec3 along, thumb, palm;

    for (int k = 0; k < 3; k++)
        along[k] = h->R[3 * k], thumb[k] = h->R[3 * k + 1], palm[k] = h->R[3 * k + 2];
    for (int f = 0; f < FINGERS; f++) {
        const double bend = p->pose->arm[side].bend[f], most = f ? 1.45 : 0.7;
        double *at = p->joint[(side == LEFT ? L_HAND : R_HAND) + 4 * f];
        vec3 straight;

        add_scaled(h->wrist, size * FINGER[f][0], along, at);
        add_scaled(at, size * FINGER[f][1], thumb, at);
        add_scaled(along, f ? 0.25 * FINGER[f][1] : 1.1 - 1.2 * bend, thumb, straight);
        across(straight, palm, straight);
        for (int b = 0; b < 3; b++, at += 3) {
            const double angle = most * bend * (f ? b + 0.7 : b + 0.4);

            add_scaled(at, size * FINGER[f][2 + b] * cos(angle), straight, at + 3);
            add_scaled(at + 3, size * FINGER[f][2 + b] * sin(angle), palm, at + 3);
        }
    }
}

static void pose_arm(posing *p, int side, hand_frame *h)
{
    const double out = side == LEFT ? -1 : 1;
    const arm_pose *a = &p->pose->arm[side];
    vec3 elbow_side, palm, thumb, along;
    const vec3 seen = { out * 0.6, 0.8, -0.35 }, looks = { out * a->palm[0], -a->palm[1], a->palm[2] };

    place(p, (vec3){ out * a->wrist[0], a->wrist[1], a->wrist[2] }, h->wrist);
    lt_mat3_mulvec(p->yaw, seen, elbow_side);
    reach(p->joint[L_SHOULDER + side], h->wrist, UPPER_ARM * p->stature, FOREARM * p->stature, elbow_side,
          p->joint[L_ELBOW + side]);
    memcpy(p->joint[L_WRIST + side], h->wrist, sizeof(vec3));
    add_scaled(h->wrist, -1, p->joint[L_ELBOW + side], along);
    across(along, (vec3){ 0, 0, 0 }, along);
    lt_mat3_mulvec(p->yaw, looks, palm);
    across(palm, along, palm);
    cross(palm, along, thumb);                  /* of a right hand: out of the palm by along the fingers */
    for (int k = 0; k < 3; k++) {
        h->R[3 * k] = along[k];
        h->R[3 * k + 1] = -out * thumb[k];
        h->R[3 * k + 2] = palm[k];
    }
    pose_fingers(p, side, h);
}

void body_joints(const body_pose *pose, double stature, double joint[ACTION_BODY][3], hand_frame hand[SIDES])
{
    posing p = { .pose = pose, .stature = stature, .joint = joint };

    pose_trunk(&p);
    for (int side = 0; side < SIDES; side++) {
        pose_leg(&p, side);
        pose_arm(&p, side, &hand[side]);
    }
}
