/* SPDX-License-Identifier: Apache-2.0 */
/* A person at a moment: programs one after the other, hands that go to what they grasp, the body that follows. */
#include "synth/workplace/act.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "synth/body/limb.h"
#include "synth/workplace/robot.h"

#include <math.h>
#include <string.h>

#define DEGREE 0.017453292519943295

enum {
    APPROACH = 14,                  /* frames in which a hand turns to what it grasps, and fits where it is */
    CLOSE = 8, OPEN = 9,            /* frames in which fingers close, and open */
    TURNING = 8,                    /* frames before and after, over which a hand turns over */
    SETTLE = 5,                     /* frames in which what is put down comes to rest */
    ANKLE = 5,                      /* of data/action's joints, the left one */
};

static const double STEP = 0.05;                /* metres that a foot is lifted where it goes fast */
static const double CLEAR = 0.03;               /* metres from the table up to joints of fingers */
static const double BRINK = 0.14;               /* metres before the table's edge, from where on hands keep clear */

double act_ease(double k, double from, double to)
{
    const double s = fmin(1, fmax(0, (k - from) / fmax(1e-6, to - from)));

    return s * s * s * (10 + s * (6 * s - 15));
}

/* Up from a to b, down from c to d */
static double between(double k, double a, double b, double c, double d)
{
    return act_ease(k, a, b) * (1 - act_ease(k, c, d));
}

void act_turn(const double A[9], const double B[9], double share, double out[9])
{
    double a[4], b[4], v[3], q[4];

    lt_rot_to_quat(A, a);
    lt_rot_to_quat(B, b);
    lt_quat_difference(b, a, v);
    lt_quat_exp(v, share, q);
    lt_quat_mul(q, a, q);
    lt_rot_from_quat(q, out);
}

/* The first frame whose share of the clip is not below u */
static int frame_of(const workplace_act *a, double u)
{
    return a->first + (int)ceil(u * a->draw.frames);
}

int act_meets(const workplace_act *a) { return frame_of(a, a->draw.meets); }
int act_leaves(const workplace_act *a) { return frame_of(a, a->draw.leaves); }

/* ---- the programs' pose --------------------------------------------------------------------------------- */

static void mix(double *a, const double *b, double share, int n)
{
    for (int i = 0; i < n; i++)
        a[i] += share * (b[i] - a[i]);
}

/* A program's pose, which leans farther to reach the table. */
static void pose_of(const workplace_person *p, const workplace_act *a, int k, body_pose *out)
{
    const bool picks = a->draw.cls == ACT_PICK;
    const int there = picks ? act_meets(a) : act_leaves(a);

    action_pose(&p->style, &a->draw, k - a->first, out);
    if (a->lean > 0)
        out->lean += a->lean * between(k, frame_of(a, a->draw.begin), there - 1, there + 2,
                                       picks ? frame_of(a, 0.9) : a->last);
}

/* The act of frame k */
static int act_index(const workplace_person *p, int k)
{
    int i = 0;

    while (i + 1 < p->n_acts && k >= p->act[i + 1].first)
        i++;
    return i;
}

/* The part of a gap in which one program takes over from the other */
typedef struct { double from, to; } window;
static const window whole = { 0, 1 }, halves[SIDES] = { { 0, 0.5 }, { 0.5, 1 } };

static double taken_over(const workplace_person *p, int i, int k, window w)
{
    const int last = p->act[i].last;

    return i + 1 < p->n_acts ? act_ease(k, last + w.from * ACT_GAP, last + w.to * ACT_GAP) : 0;
}

/* Two programs mix as numbers, all of which a pose consists of. */
static void mixed_pose(const workplace_person *p, int k, window w, body_pose *out)
{
    const int i = act_index(p, k);
    const double next = taken_over(p, i, k, w);

    pose_of(p, &p->act[i], k, out);
    if (next > 0) {
        body_pose b;

        pose_of(p, &p->act[i + 1], k, &b);
        mix((double *)out, (const double *)&b, next, (int)(sizeof(b) / sizeof(double)));
    }
}

/* ---- from a program's pose to a goal -------------------------------------------------------------------- */

/* A program's axes, x right, y down, z forward, in the world */
static void to_world(const workplace_person *p, const double x[3], double out[3])
{
    const double c = cos(p->facing), s = sin(p->facing);
    const double at[3] = { s * x[0] + c * x[2], -c * x[0] + s * x[2], -x[1] };

    memcpy(out, at, sizeof(at));
}

static void place_in_world(const workplace_person *p, const double x[3], double out[3])
{
    to_world(p, x, out);
    out[0] += p->stand[0];
    out[1] += p->stand[1];
    out[2] += WORKPLACE_FLOOR;
}

/* The frame of the wrist's joint: of a hand at rest, x is along the arm, y out of its back, z to the thumb */
static void wrist_frame(const workplace_person *p, int side, const hand_frame *h, double out[9])
{
    for (int k = 0; k < 3; k++) {
        const double column[3] = { h->R[k], h->R[3 + k], h->R[6 + k] };
        const double sign = k == 0 ? (side ? -1 : 1) : k == 1 ? 1 : -1;
        const int to = k == 0 ? 0 : k == 1 ? 2 : 1;
        double x[3];

        to_world(p, column, x);
        for (int r = 0; r < 3; r++)
            out[3 * r + to] = sign * x[r];
    }
}

/* Of a program's bends, thumb first, to a hand's angles, thumb last */
static void bend_fingers(const workplace_script *s, const double bend[FINGERS], double pose[3 * LT_HAND_JOINTS])
{
    static const int digit[4] = { 1, 2, 4, 3 }; /* of the hand's order: index, middle, little, ring */
    double angles[15][3] = { { 0 } };

    for (int d = 0; d < 4; d++) {
        angles[3 * d][SYNTH_HAND_FLEX] = 72 * DEGREE * bend[digit[d]];
        angles[3 * d + 1][SYNTH_HAND_FLEX] = 92 * DEGREE * bend[digit[d]];
        angles[3 * d + 2][SYNTH_HAND_FLEX] = 60 * DEGREE * bend[digit[d]];
    }
    angles[12][SYNTH_HAND_SPREAD] = 30 * DEGREE * (1 - bend[0]);
    angles[12][SYNTH_HAND_FLEX] = 24 * DEGREE * bend[0];
    angles[13][SYNTH_HAND_FLEX] = 38 * DEGREE * bend[0];
    angles[14][SYNTH_HAND_FLEX] = 30 * DEGREE * bend[0];
    synth_hand_clamp_angles(angles);
    memset(pose, 0, 3 * sizeof(*pose));
    synth_hand_angles_to_pose(&s->hand_frames, angles, pose + 3);
}

/* Where the sole of a foot is, and how high the program lifts it */
static double find_foot(const workplace_person *p, int side, int k, double out[3])
{
    double joint[ACTION_BODY][3];
    hand_frame hand[SIDES];
    body_pose pose;

    mixed_pose(p, k, halves[side], &pose);
    body_joints(&pose, p->body.stature, joint, hand);
    place_in_world(p, joint[ANKLE + side], out);
    return p->body.stature * pose.foot[side][1];
}

/* Feet go one after the other, and are lifted where they go. */
static void place_feet(const workplace_person *p, int k, synth_body_goal *g)
{
    const int i = act_index(p, k);
    const double walks = p->act[i].draw.cls == ACT_WALK ? 1 - taken_over(p, i, k, whole) : 0;

    for (int side = 0; side < SIDES; side++) {
        double before[3], now[3], after[3], speed;
        const double lift = find_foot(p, side, k, now);

        find_foot(p, side, k - 1, before);
        find_foot(p, side, k + 1, after);
        speed = hypot(after[0] - before[0], after[1] - before[1]) * WORKPLACE_FPS / 2;
        memcpy(g->foot[side], now, sizeof(g->foot[side]));
        g->lift[side] = lift + (1 - walks) * STEP * speed * speed / (speed * speed + 0.09);
    }
}

static void program_goal(const workplace_script *s, const workplace_person *p, int k, synth_body_goal *g)
{
    double joint[ACTION_BODY][3], at[3];
    hand_frame hand[SIDES];
    body_pose pose;

    mixed_pose(p, k, whole, &pose);
    body_joints(&pose, p->body.stature, joint, hand);
    place_in_world(p, joint[0], at);
    *g = (synth_body_goal){ .pelvis = { at[0], at[1] }, .floor = WORKPLACE_FLOOR, .facing = p->facing - pose.yaw,
                            .lean = pose.lean, .twist = -pose.twist, .sway = pose.sway, .look = -pose.turn,
                            .nod = pose.nod, .heading = { p->facing - pose.yaw + 0.1, p->facing - pose.yaw - 0.1 } };
    place_feet(p, k, g);
    for (int side = 0; side < SIDES; side++) {
        const double out = side == LEFT ? -1 : 1, c = cos(pose.yaw), d = sin(pose.yaw);
        const double bent[3] = { out * 0.6, 0.8, -0.35 };
        const double turned[3] = { c * bent[0] + d * bent[2], bent[1], -d * bent[0] + c * bent[2] };

        place_in_world(p, hand[side].wrist, g->wrist[side]);
        wrist_frame(p, side, &hand[side], g->hand[side]);
        to_world(p, turned, g->elbow[side]);
        bend_fingers(s, pose.arm[side].bend, g->fingers[side]);
    }
}

/* ---- hands that grasp ----------------------------------------------------------------------------------- */

/* How much of a hand at frame k is the hold's: its turn, its place at either end, its fingers */
static void fit_hand(const workplace_person *p, const workplace_hold *h, int k, synth_body_goal *g)
{
    const int side = p->style.arm;
    const double turn = between(k, h->from - APPROACH, h->from - 1, h->to + 1, h->to + APPROACH);
    const double close = between(k, h->from - CLOSE, h->from, h->to - 1, h->to + OPEN);
    const double pick = between(k, h->from - APPROACH, h->from - 1, h->from + 2, h->from + APPROACH);
    const double place = between(k, h->to - APPROACH, h->to - 2, h->to + 2, h->to + APPROACH);

    if (turn > 0)
        act_turn(g->hand[side], h->hand, turn, g->hand[side]);
    if (h->picked)
        mix(g->wrist[side], h->wrist[0], pick, 3);
    if (h->placed)
        mix(g->wrist[side], h->wrist[1], place, 3);
    mix(g->fingers[side] + 3, p->grip.pose + 3, close, 45);
}

void act_goal(const workplace_script *s, const workplace_person *p, int k, bool bare, synth_body_goal *out)
{
    program_goal(s, p, k, out);
    for (int i = 0; i < p->n_holds && !bare; i++)
        fit_hand(p, &p->hold[i], k, out);
}

/* Least height of a point, of how far it is before the table's edge: rising to the table's top, and CLEAR above it */
static double least_height(const workplace_script *s, const double x[3])
{
    const double *t = s->table;
    const double away = fmax(fmax(t[0] - x[0], x[0] - t[2]), fmax(t[1] - x[1], x[1] - t[3]));

    return CLEAR - 0.4 * act_ease(away, 0.02, BRINK);
}

/* How far an arm is to be raised: its joints, fingertips beyond the last ones, the forearm. */
static double too_low(const workplace_script *s, const synth_body_pose *b, int side)
{
    const double *wrist = b->joint[BODY_WRIST + side], *elbow = b->joint[BODY_ELBOW + side];
    const double (*finger)[3] = (const double (*)[3])b->joint + BODY_FINGERS + side * BODY_HAND_JOINTS;
    double most = 0, x[3];

    for (int j = 0; j < BODY_HAND_JOINTS; j++) {
        const double beyond = j % 3 == 2 ? 0.9 : 0;         /* a tip is nearly as far on as the joint before it */

        for (int k = 0; k < 3; k++)
            x[k] = finger[j][k] + beyond * (finger[j][k] - finger[j ? j - 1 : 0][k]);
        most = fmax(most, least_height(s, x) - x[2]);
    }
    for (int i = 0; i <= 4; i++) {
        for (int k = 0; k < 3; k++)
            x[k] = wrist[k] + i / 4.0 * (elbow[k] - wrist[k]);
        most = fmax(most, least_height(s, x) + 0.015 - x[2]);
    }
    return most;
}

void act_follow(const workplace_script *s, const workplace_person *p, const synth_body_goal *goal, double clear,
                synth_body_pose *out)
{
    synth_body_goal g = *goal;

    synth_follow(&p->body, &g, out);
    for (int i = 0; i < 2 && clear > 0; i++) {
        for (int side = 0; side < SIDES; side++)
            g.wrist[side][2] += clear * too_low(s, out, side);
        synth_follow(&p->body, &g, out);
    }
}

void act_target(const workplace_person *p, workplace_act *a, int k, const double wrist[3])
{
    const double c = cos(p->facing), s = sin(p->facing), S = p->body.stature;
    const double from[2] = { wrist[0] - p->stand[0], wrist[1] - p->stand[1] };
    double right, ahead, *target = a->draw.target;
    body_pose pose;

    action_pose(&p->style, &a->draw, k - a->first, &pose);
    right = s * from[0] - c * from[1] - pose.place[0];
    ahead = c * from[0] + s * from[1] - pose.place[1];
    target[0] = (cos(pose.yaw) * right - sin(pose.yaw) * ahead) * (a->draw.arm == LEFT ? -1 : 1) / S;
    target[1] = (wrist[2] - WORKPLACE_FLOOR) / S;
    target[2] = (sin(pose.yaw) * right + cos(pose.yaw) * ahead) / S;
}

/* ---- what it comes to ------------------------------------------------------------------------------------ */

/* Whether the hand is so near to what it picks or places that the grasp alone says how low it may be: 1, else to 0 */
static double at_grasp(const workplace_person *p, int k)
{
    double most = 0;

    for (int i = 0; i < p->n_holds; i++) {
        const workplace_hold *h = &p->hold[i];

        if (h->picked)
            most = fmax(most, between(k, h->from - APPROACH, h->from - 4, h->from + 4, h->from + APPROACH));
        if (h->placed)
            most = fmax(most, between(k, h->to - APPROACH, h->to - 4, h->to + 4, h->to + APPROACH));
    }
    return most;
}

/* Where a program turns a hand over at once, it takes some frames: a mean of turns before and after, with a bell's
 * weights, but where it grasps. */
static void smooth_turns(const workplace_script *s, const workplace_person *p, int k, double exact, synth_body_goal *g)
{
    double own[SIDES][3], sum = 0;

    for (int i = exact < 1 ? -TURNING : 0; i <= (exact < 1 ? TURNING : 0); i++) {
        const double weight = 1 + cos(M_PI * i / (TURNING + 1));
        synth_body_goal goal;
        synth_body_pose other;

        act_goal(s, p, k + i, false, &goal);
        synth_follow(&p->body, &goal, &other);
        sum += weight;
        for (int side = 0; side < SIDES; side++)
            for (int c = 0; c < 3; c++)
                g->turn[side][c] += weight * other.turn[side][c];
        if (i == 0)
            memcpy(own, other.turn, sizeof(own));
    }
    for (int side = 0; side < SIDES; side++)
        for (int c = 0; c < 3; c++)
            g->turn[side][c] = g->turn[side][c] / sum + exact * (own[side][c] - g->turn[side][c] / sum);
    g->turned = true;
}

/* The state is that of the program's phase. */
static void find_state(const workplace_person *p, int k, workplace_moment *m)
{
    const workplace_act *a = &p->act[act_index(p, k)];
    const int begin = frame_of(a, a->draw.begin);

    m->act = k < a->last ? a : NULL;
    m->state = WORKPLACE_NONE;
    m->object = -1;
    for (int i = 0; i < p->n_holds; i++)
        if (k >= p->hold[i].from && k < p->hold[i].to) {
            m->hold = &p->hold[i];
            m->state = WORKPLACE_HOLD;
            m->object = m->hold->object;
        }
    if (a->draw.cls == ACT_REACH && k >= begin && k < a->last)
        m->state = WORKPLACE_APPROACH;
    if (a->object < 0 || k < begin)
        return;
    if (a->draw.cls == ACT_PICK && k < act_meets(a) + 3)
        m->state = k < act_meets(a) ? WORKPLACE_APPROACH : WORKPLACE_CONTACT;
    else if (a->draw.cls == ACT_RECEIVE && k < a->last)
        m->state = WORKPLACE_RECEIVE;
    else if (a->draw.cls == ACT_HAND_OVER && k < act_leaves(a))
        m->state = WORKPLACE_HANDOVER;
    else if (a->draw.cls == ACT_PLACE && k < act_leaves(a))
        m->state = WORKPLACE_PLACE;
    if (m->state != WORKPLACE_NONE)
        m->object = a->object;
}

void workplace_person_at(const workplace_script *s, int person, int k, workplace_moment *out)
{
    const workplace_person *p = &s->person[person];
    workplace_moment before = { .state = WORKPLACE_NONE };
    const double exact = at_grasp(p, k);
    synth_body_goal goal;

    *out = (workplace_moment){ .object = -1 };
    act_goal(s, p, k, false, &goal);
    smooth_turns(s, p, k, exact, &goal);
    act_follow(s, p, &goal, 1 - exact, &out->body);
    for (int side = 0; side < SIDES; side++)
        out->miss[side] = lt_vec3_distance(goal.wrist[side], out->body.joint[BODY_WRIST + side]);
    find_state(p, k, out);
    for (out->since = k; out->since > 0; out->since--) {
        find_state(p, out->since - 1, &before);
        if (before.state != out->state || before.object != out->object)
            break;
    }
}

/* ---- objects ---------------------------------------------------------------------------------------------- */

void act_blend(const synth_settled *a, const synth_settled *b, double share, synth_settled *out)
{
    synth_settled c = *a;

    act_turn(a->R, b->R, share, c.R);
    mix(c.t, b->t, share, 3);
    *out = c;
}

void act_in_hand(const workplace_person *p, const synth_body_pose *b, synth_settled *out)
{
    const int wrist = BODY_WRIST + p->style.arm;

    synth_limb_object(p->style.arm, &p->grip, b->world[wrist], b->joint[wrist], out->R, out->t);
}

void workplace_object_at(const workplace_script *s, const workplace_moment *who, int object, int k, synth_settled *out,
                         int *owner)
{
    const workplace_hold *last = NULL, *next = NULL;

    *out = s->object[object].at;
    *owner = -1;
    for (int i = 0; i < s->n_people; i++)
        for (int j = 0; j < s->person[i].n_holds; j++) {
            const workplace_hold *h = &s->person[i].hold[j];

            if (h->object != object)
                continue;
            if (k >= h->from && k < h->to) {
                *owner = i;
                act_in_hand(&s->person[i], &who[i].body, out);
                act_blend(&h->begin, out, act_ease(k, h->from - 1, h->from + SETTLE), out);
                if (h->placed)
                    act_blend(out, &h->end, act_ease(k, h->to - SETTLE, h->to), out);
                return;
            }
            if (k >= h->to)
                last = h;
            else if (!next)
                next = h;
        }
    if (last)
        *out = last->end;
    if (last && !last->placed)
        robot_takes(s, last, k, out);
    if (next && !next->picked)
        robot_gives(s, next, k, out);
}
