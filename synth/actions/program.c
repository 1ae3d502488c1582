/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/actions/program.h"

#include <math.h>
#include <string.h>

/* Classes as data/action/action.h numbers them */
enum { WAVE, WALK, REACH, CROSS, POINT, WAIT, RECEIVE, PLACE, HAND_OVER, PICK };
enum { LEAST_FRAMES = 60, MOST_FRAMES = 90 };

static const double FPS = 30;

/* ---- draws; each stands in a statement of its own, as C leaves the order of arguments open ---- */

void action_style_draw(lt_rng *r, action_style *s)
{
    s->stature = lt_rng_range(r, 1.55, 1.92);
    s->speed = lt_rng_range(r, 0.7, 1.4);
    s->amplitude = lt_rng_range(r, 0.8, 1.2);
    s->delay = lt_rng_range(r, 0, 0.06);
    s->idle = lt_rng_range(r, 0.5, 1.5);
    s->arm = lt_rng_uniform(r) < 0.25 ? LEFT : RIGHT;
}

/* Wrists end before the chest where something is given, taken or reached for, above the table where it stands there. */
static void draw_target(lt_rng *r, action_draw *d)
{
    const bool table = d->cls == PLACE || d->cls == PICK;

    d->target[0] = lt_rng_range(r, 0, 0.12);
    d->target[1] = table ? lt_rng_range(r, 0.5, 0.56) : lt_rng_range(r, 0.64, 0.72);
    d->target[2] = table ? lt_rng_range(r, 0.24, 0.29) : lt_rng_range(r, 0.26, 0.31);
}

static void draw_times(lt_rng *r, double difficulty, const action_style *style, action_draw *d)
{
    static const double meets[ACTION_CLASSES][2] = { [RECEIVE] = { 0.72, 0.82 }, [PICK] = { 0.3, 0.4 } };
    static const double leaves[ACTION_CLASSES][2] = { [PLACE] = { 0.6, 0.72 }, [HAND_OVER] = { 0.7, 0.84 } };

    d->frames = LEAST_FRAMES + (int)lt_rng_below(r, MOST_FRAMES - LEAST_FRAMES + 1);
    d->begin = style->delay + lt_rng_range(r, 0, 0.05);
    d->meets = lt_rng_range(r, meets[d->cls][0], meets[d->cls][1]);
    d->leaves = leaves[d->cls][1] > 0 ? lt_rng_range(r, leaves[d->cls][0], leaves[d->cls][1]) : 2;
    d->parts = difficulty * lt_rng_range(r, 0.7, 0.9);
}

void action_draw_new(lt_rng *r, int cls, double difficulty, const action_style *style, action_draw *d)
{
    *d = (action_draw){ .cls = cls };
    draw_times(r, difficulty, style, d);
    draw_target(r, d);
    d->pace = lt_rng_range(r, 0.9, 1.1);
    d->arm = lt_rng_uniform(r) < 0.85 ? style->arm : LEFT + RIGHT - style->arm;
    d->phase = lt_rng_range(r, 0, 2 * M_PI);
    d->wander = lt_rng_range(r, 0, 2 * M_PI);
    d->yaw = lt_rng_range(r, -M_PI * 40 / 180, M_PI * 40 / 180);
    for (int k = 0; k < 2; k++)
        d->place[k] = lt_rng_range(r, -0.3, 0.3);
    for (int k = 0; k < 3; k++)
        d->size[k] = lt_rng_range(r, 0.04, 0.1);
    d->size[2] *= 1.6;
}

bool action_holds(const action_draw *d, int k)
{
    const double u = (double)k / d->frames;

    return d->cls >= ACTION_WITH_OBJECT && u >= d->meets && u < d->leaves;
}

/* ---- key poses ---- */

/* What the programs write upon: the moment, and the pose. */
typedef struct {
    const action_style *style;
    const action_draw *draw;
    double u, t;                    /* share of the clip; seconds times the subject's speed */
    body_pose *pose;
} moment;

static const double REST[3] = { 0.13, 0.485, 0.02 }, CARRY[3] = { 0.04, 0.62, 0.17 };
static const double INWARD[3] = { -1, 0, 0.1 }, DOWN[3] = { 0, -1, 0 }, UP[3] = { -0.25, 1, 0 };
static const double FORWARD[3] = { 0, 0.1, 1 };

/* From 0 to 1 between two shares of the clip, with minimum jerk */
static double ease(const moment *m, double from, double to)
{
    const double s = fmin(1, fmax(0, (m->u - from) / fmax(1e-6, to - from)));

    return s * s * s * (10 + s * (6 * s - 15));
}

static double beat(const moment *m, double hz)
{
    return sin(2 * M_PI * hz * m->draw->pace * m->t + m->draw->phase);
}

static void go(double x[3], const double to[3], double share)
{
    for (int k = 0; k < 3; k++)
        x[k] += share * (to[k] - x[k]);
}

static void bend_all(arm_pose *a, double to, double share)
{
    for (int f = 0; f < FINGERS; f++)
        a->bend[f] += share * (to - a->bend[f]);
}

/* Standing, and never quite still */
static void stand(moment *m)
{
    const double w = 2 * M_PI * m->t, by = m->style->idle, p = m->draw->wander;
    body_pose *b = m->pose;

    *b = (body_pose){ .place = { m->draw->place[0], m->draw->place[1] }, .yaw = m->draw->yaw };
    b->place[0] += 0.006 * by * sin(0.23 * w + p);
    b->place[1] += 0.005 * by * sin(0.31 * w + 2 * p);
    b->lean = 0.02 + 0.012 * by * sin(0.27 * w + 3 * p);
    b->turn = 0.08 * by * sin(0.2 * w + 5 * p);
    for (int side = 0; side < SIDES; side++) {
        arm_pose *a = &b->arm[side];

        memcpy(a->wrist, REST, sizeof(REST));
        memcpy(a->palm, INWARD, sizeof(INWARD));
        a->wrist[2] += 0.004 * by * sin(0.4 * w + p + side);
        bend_all(a, 0.35, 1);
    }
}

static arm_pose *preferred(const moment *m)
{
    return &m->pose->arm[m->draw->arm];
}

static void wave(moment *m)
{
    const double up = ease(m, m->draw->begin - 0.1, m->draw->begin + 0.12);
    const double by = m->style->amplitude * up;
    arm_pose *a = preferred(m);

    go(a->wrist, (double[]){ 0.22, 0.9, 0.1 }, up);
    go(a->palm, FORWARD, up);
    bend_all(a, 0.03, up);
    a->wrist[0] += 0.09 * by * beat(m, 1.8);
}

static void walk(moment *m)
{
    const double speed = 0.95 * m->style->amplitude * m->draw->pace, w = 2 * M_PI * 0.9 * m->t + m->draw->phase;
    body_pose *b = m->pose;

    b->place[0] += speed * m->t * sin(b->yaw) * 0.3;
    b->place[1] += speed * m->t - 1.2;
    b->yaw *= 0.3;
    b->lean += 0.05;
    b->twist = 0.08 * sin(w);
    for (int side = 0; side < SIDES; side++) {
        const double swing = sin(w + M_PI * side), lift = cos(w + M_PI * side);

        b->foot[side][0] = 0.16 * swing;
        b->foot[side][1] = 0.05 * fmax(0, lift);
        b->arm[side].wrist[2] -= 0.1 * m->style->amplitude * swing;
        b->arm[side].wrist[1] += 0.02 * fabs(swing);
    }
}

/* A step there, and where nothing is left to do, back */
static void step(moment *m, double share)
{
    body_pose *b = m->pose;

    b->place[0] += 0.18 * share * sin(b->yaw);
    b->place[1] += 0.18 * share * cos(b->yaw);
    for (int side = 0; side < SIDES; side++)
        b->foot[side][0] -= (side == m->draw->arm ? 0.04 : 0.1) * share;
}

/* The path that reaching and receiving share, and the fingers until they part */
static double stretch(moment *m)
{
    const double there = ease(m, m->draw->begin - 0.1, 1.1);
    arm_pose *a = preferred(m);

    go(a->wrist, m->draw->target, there);
    go(a->palm, UP, there);
    bend_all(a, 0.2, ease(m, m->draw->begin, m->draw->begin + 0.2));
    m->pose->lean += 0.1 * there;
    m->pose->nod = 0.15 * there;
    return ease(m, m->draw->parts - 0.02, m->draw->parts + 0.14);
}

static void reach_out(moment *m)
{
    const double parted = stretch(m);

    bend_all(preferred(m), 0.85, parted);
}

static void receive(moment *m)
{
    const double parted = stretch(m);

    bend_all(preferred(m), 0.02, parted);
}

static void cross_hands(moment *m)
{
    const double up = ease(m, m->draw->begin - 0.1, m->draw->begin + 0.15);

    for (int side = 0; side < SIDES; side++) {
        arm_pose *a = &m->pose->arm[side];

        go(a->wrist, (double[]){ -0.03, 0.74 + 0.02 * side, 0.17 + 0.03 * side }, up);
        go(a->palm, FORWARD, up);
        a->wrist[0] += up * 0.055 * m->style->amplitude * (1 + beat(m, 0.75));
        bend_all(a, 0.05, up);
    }
}

static void point(moment *m)
{
    const double there = ease(m, m->draw->begin - 0.05, m->draw->begin + 0.2);
    arm_pose *a = preferred(m);

    go(a->wrist, (double[]){ m->draw->target[0] + 0.08, m->draw->target[1] + 0.08, m->draw->target[2] - 0.02 }, there);
    go(a->palm, DOWN, there);
    bend_all(a, 0.95, there);
    a->bend[1] *= 1 - there;
    a->wrist[2] += 0.04 * there * m->style->amplitude * beat(m, 1.1);
    m->pose->turn += 0.2 * there * (m->draw->arm == RIGHT ? 1 : -1);
}

/* The weight from foot to foot, a look round, hands before the body */
static void wait_about(moment *m)
{
    for (int side = 0; side < SIDES; side++) {
        arm_pose *a = &m->pose->arm[side];

        go(a->wrist, (double[]){ 0.03, 0.54, 0.13 }, 1);
        bend_all(a, 0.5, 1);
    }
    m->pose->place[0] += 0.02 * m->style->idle * beat(m, 0.25);
    m->pose->sway = 0.03 * m->style->idle * beat(m, 0.25);
    m->pose->turn += 0.35 * beat(m, 0.2);
}

static void place_down(moment *m)
{
    const double down = ease(m, m->draw->begin, m->draw->leaves - 0.03), off = ease(m, m->draw->leaves + 0.02, 1.05);
    arm_pose *a = preferred(m);

    memcpy(a->wrist, CARRY, sizeof(CARRY));
    go(a->wrist, m->draw->target, down);
    go(a->wrist, REST, off);
    go(a->palm, DOWN, 0.7);
    bend_all(a, 0.6, 1);
    bend_all(a, 0.08, ease(m, m->draw->leaves - 0.04, m->draw->leaves + 0.04));
    step(m, down * (1 - off));
    m->pose->lean += 0.32 * down * (1 - off);
    m->pose->nod = 0.3 * (1 - off);
}

/* With both hands, offered again and again until it is taken */
static void hand_over(moment *m)
{
    const double out = ease(m, m->draw->begin, m->draw->begin + 0.3), back = ease(m, m->draw->leaves + 0.02, 1.05);

    for (int side = 0; side < SIDES; side++) {
        arm_pose *a = &m->pose->arm[side];

        memcpy(a->wrist, CARRY, sizeof(CARRY));
        go(a->wrist, (double[]){ 0.04, m->draw->target[1], m->draw->target[2] }, out);
        a->wrist[2] += 0.02 * m->style->amplitude * beat(m, 0.8);
        go(a->wrist, REST, back);
        go(a->palm, (double[]){ -1, 0.4, 0 }, 1);
        bend_all(a, 0.6, 1);
        bend_all(a, 0.08, ease(m, m->draw->leaves - 0.04, m->draw->leaves + 0.04));
    }
    m->pose->lean += 0.12 * out * (1 - back);
}

static void pick_up(moment *m)
{
    const double there = ease(m, m->draw->begin, m->draw->meets), up = ease(m, m->draw->meets + 0.04, 0.9);
    arm_pose *a = preferred(m);

    go(a->wrist, m->draw->target, there);
    go(a->wrist, CARRY, up);
    go(a->palm, DOWN, 0.7 * there);
    bend_all(a, 0.08, ease(m, m->draw->begin, m->draw->meets - 0.1));
    bend_all(a, 0.6, ease(m, m->draw->meets - 0.05, m->draw->meets + 0.04));
    m->pose->lean += 0.32 * there * (1 - up);
    m->pose->nod = 0.3 * there;
}

void action_pose(const action_style *style, const action_draw *draw, int k, body_pose *out)
{
    static void (*const program[ACTION_CLASSES])(moment *) = {
        [WAVE] = wave, [WALK] = walk, [REACH] = reach_out, [CROSS] = cross_hands, [POINT] = point, [WAIT] = wait_about,
        [RECEIVE] = receive, [PLACE] = place_down, [HAND_OVER] = hand_over, [PICK] = pick_up,
    };
    moment m = { style, draw, (double)k / draw->frames, k / FPS * style->speed, out };

    stand(&m);
    program[draw->cls](&m);
}
