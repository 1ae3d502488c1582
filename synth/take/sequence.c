/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Key poses, and minimum-jerk ways between them. Each way takes as long as the hand's farthest point
 * needs at its peak speed, so no joint ever outruns SYNTH_MAX_STEP.
 */
#include "synth/take/sequence.h"

#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <string.h>

enum { MIN_MOMENTS = 48, MAX_KEYS = 24, TREMBLES = 3, TRIES = 40 };

static const double PEAK = 1.875;               /* greatest speed of minimum jerk over the mean one */
static const double STEP = 0.85 * SYNTH_MAX_STEP;       /* leaves room for trembling and slip */
static const double TURN = 0.85 * SYNTH_MAX_TURN;
static const double REACH = 0.22;               /* from the wrist to the farthest finger tip */
static const double FINGER = 0.10;              /* from a knuckle to its tip */
static const double RETREAT = 0.09;             /* from the grasp to where the fingers open */
static const double FOREARM = 0.45;             /* what must stay above the table */
static const double ARM_CLEAR = 0.03;           /* height of its middle line there */
static const double OPEN = 0.25, OPEN_THUMB = 0.5;      /* share of the grasp's angles when open */
static const double SLIP = 0.0008;              /* metres that a held object slides */
static const double TREMBLE = 0.006;            /* radians at each finger joint */

typedef struct { double R[9], t[3]; } rigid;

/* A pose to pass through. */
typedef struct {
    synth_phase phase;              /* of the way that leads here */
    bool attached;                  /* the hand holds the object on that way */
    rigid object, hand;             /* world; hand: the wrist */
    double open;                    /* 0: the grasp, 1: open */
    int moments;                    /* of the way that leads here */
} key;

typedef struct {
    const synth_sequence_spec *spec;
    lt_rng rng;
    rigid grip;                     /* wrist in the object's frame */
    double closed[45], opened[45];
    key key[MAX_KEYS];
    int n_keys, n_moments;
    double tremble_phase[45][TREMBLES], tremble_rate[TREMBLES], slip_phase[3];
} plan;

/* ---- rigid motions ---- */

static rigid compose(const rigid *a, const rigid *b)
{
    rigid c;

    lt_mat3_mul(a->R, b->R, c.R);
    lt_rigid_apply(a->R, a->t, b->t, c.t);
    return c;
}

/* The vector from rotation a to rotation b, in a's frame. */
static void turn_between(const double a[9], const double b[9], double aa[3])
{
    double at[9], d[9];

    lt_mat3_transpose(a, at);
    lt_mat3_mul(at, b, d);
    lt_rot_to_axis_angle(d, aa);
}

static rigid between(const rigid *a, const rigid *b, double s)
{
    double aa[3], d[9];
    rigid c;

    turn_between(a->R, b->R, aa);
    for (int k = 0; k < 3; k++) {
        aa[k] *= s;
        c.t[k] = a->t[k] + s * (b->t[k] - a->t[k]);
    }
    lt_rot_from_axis_angle(aa, d);
    lt_mat3_mul(a->R, d, c.R);
    return c;
}

static void turn_about(double axis_x, double axis_y, double axis_z, double angle, double R[9])
{
    const double n = sqrt(axis_x * axis_x + axis_y * axis_y + axis_z * axis_z);
    const double aa[3] = { axis_x / n * angle, axis_y / n * angle, axis_z / n * angle };

    lt_rot_from_axis_angle(aa, R);
}

/* ---- the hand and the table ---- */

static rigid grip_of(const synth_sequence_spec *spec)
{
    rigid g;

    lt_rot_from_axis_angle(spec->grasp->pose, g.R);
    for (int k = 0; k < 3; k++)
        g.t[k] = spec->rest_wrist[k] + spec->grasp->trans[k];
    return g;
}

static double lowest_vertex(const lt_mesh *mesh)
{
    double z = INFINITY;

    for (int i = 0; i < mesh->n_vertices; i++)
        z = fmin(z, mesh->vertex[i][2]);
    return z;
}

/* Whether the forearm, which goes off along the hand's x, stays above the table. */
static bool arm_is_clear(const rigid *hand)
{
    return hand->t[2] > ARM_CLEAR && hand->t[2] + FOREARM * hand->R[6] > ARM_CLEAR;
}

bool synth_fits_table(const synth_sequence_spec *spec)
{
    const rigid grip = grip_of(spec);
    rigid stand = { .R = { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, .t = { 0, 0, -lowest_vertex(spec->object) } };
    const rigid hand = compose(&stand, &grip);

    return spec->grasp->lowest > 0 && arm_is_clear(&hand);
}

/* ---- keys ---- */

/* The way of the farthest finger tip when the hand opens: two joints of a finger add up. */
static double opening_way(const plan *p)
{
    double bend = 0;

    for (int j = 0; j < 15; j++)
        bend = fmax(bend, lt_vec3_distance(p->closed + 3 * j, p->opened + 3 * j));
    return 2 * bend * FINGER;
}

/* How many moments the way from a to b needs: held things turn about the object's origin, a free hand
 * about its wrist. */
static int moments_between(const plan *p, const key *a, const key *b)
{
    const rigid *from = b->attached ? &a->object : &a->hand, *to = b->attached ? &b->object : &b->hand;
    const double arm = b->attached ? fmax(REACH / 2, lt_vec3_norm(p->grip.t)) : REACH;
    double aa[3], way, turn;

    turn_between(from->R, to->R, aa);
    turn = lt_vec3_norm(aa);
    way = lt_vec3_distance(from->t, to->t) + turn * arm + opening_way(p) * fabs(a->open - b->open);
    return (int)ceil(fmax(4, PEAK * fmax(way / STEP, turn / TURN)));
}

/* Add the key unless the list is full; the way to it takes as long as it must. */
static void push(plan *p, key k)
{
    if (p->n_keys == MAX_KEYS)
        return;
    k.moments = p->n_keys ? moments_between(p, &p->key[p->n_keys - 1], &k) : 1;
    p->n_moments += k.moments;
    p->key[p->n_keys++] = k;
}

static key holding(const plan *p, synth_phase phase, rigid object)
{
    return (key){ .phase = phase, .attached = true, .object = object, .hand = compose(&object, &p->grip) };
}

/* The hand drawn back from the grasp, towards its own back and elbow. */
static key drawn_back(const plan *p, synth_phase phase, rigid object, double by, double open)
{
    key k = { .phase = phase, .object = object, .hand = compose(&object, &p->grip), .open = open };

    for (int i = 0; i < 3; i++)
        k.hand.t[i] += by * (0.6 * k.hand.R[3 * i] + 0.8 * k.hand.R[3 * i + 1]);
    k.hand.t[2] = fmax(k.hand.t[2], ARM_CLEAR);
    return k;
}

/* Where the hand comes from: farther back, higher, turned a little. */
static key far_away(plan *p, synth_phase phase, rigid object)
{
    key k = drawn_back(p, phase, object, RETREAT, lt_rng_range(&p->rng, 0.5, 1));
    const double back = lt_rng_range(&p->rng, 0.08, 0.16);
    double R[9], turned[9];

    for (int i = 0; i < 3; i++)
        k.hand.t[i] += back * k.hand.R[3 * i];
    k.hand.t[2] += lt_rng_range(&p->rng, 0, 0.08);
    turn_about(lt_rng_normal(&p->rng), lt_rng_normal(&p->rng), lt_rng_normal(&p->rng),
               lt_rng_range(&p->rng, -0.4, 0.4), R);
    lt_mat3_mul(R, k.hand.R, turned);
    memcpy(k.hand.R, turned, sizeof(turned));
    return k;
}

/* The object standing on the table, turned so that the forearm points anywhere about. */
static rigid standing(plan *p)
{
    const double yaw = lt_rng_range(&p->rng, -M_PI, M_PI);
    rigid r = { .t = { lt_rng_range(&p->rng, -0.04, 0.04), lt_rng_range(&p->rng, -0.04, 0.04),
                       -lowest_vertex(p->spec->object) } };

    turn_about(0, 0, 1, yaw, r.R);
    return r;
}

/* The object's pose turned by R about its own place. */
static rigid turned_by(const rigid *object, double axis[3], double angle)
{
    rigid r = *object;
    double R[9];

    turn_about(axis[0], axis[1], axis[2], angle, R);
    lt_mat3_mul(R, object->R, r.R);
    return r;
}

/* Somewhere near the place of base, turned from it, with the arm above the table. */
static rigid wander(plan *p, const rigid *base)
{
    rigid r = *base;

    for (int i = 0; i < TRIES; i++) {
        double axis[3] = { lt_rng_normal(&p->rng), lt_rng_normal(&p->rng), lt_rng_normal(&p->rng) };
        const double angle = lt_rng_range(&p->rng, 0.3, 1.1);
        rigid hand;
        r = turned_by(base, axis, angle);
        for (int k = 0; k < 3; k++)
            r.t[k] = base->t[k] + lt_rng_range(&p->rng, -0.035, 0.035);
        hand = compose(&r, &p->grip);
        if (arm_is_clear(&hand))
            return r;
    }
    return *base;
}

/* From the table into the air, about, and back. */
static void plan_from_table(plan *p, int min_moments)
{
    const rigid stand = standing(p);
    rigid up = stand;
    int after;

    up.t[2] += lt_rng_range(&p->rng, 0.10, 0.18);
    push(p, far_away(p, SYNTH_REACH, stand));
    push(p, drawn_back(p, SYNTH_REACH, stand, RETREAT, 1));
    push(p, drawn_back(p, SYNTH_CLOSE, stand, 0, 1));
    push(p, drawn_back(p, SYNTH_CLOSE, stand, 0, 0));
    push(p, holding(p, SYNTH_LIFT, up));
    after = 40;                     /* putting back and letting go take at least this long */
    do
        push(p, holding(p, SYNTH_MANIPULATE, wander(p, &up)));
    while (p->n_keys < 7 || (p->n_moments + after < min_moments && p->n_keys < MAX_KEYS - 4));
    push(p, holding(p, SYNTH_MANIPULATE, up));
    push(p, holding(p, SYNTH_PLACE, stand));
    push(p, drawn_back(p, SYNTH_RELEASE, stand, 0, 1));
    push(p, drawn_back(p, SYNTH_RELEASE, stand, RETREAT, 1));
}

/* Held throughout: about in the air, from a pose where the arm is clear of the table. */
static void plan_in_hand(plan *p, int min_moments)
{
    rigid base = standing(p), hand;

    for (int i = 0; i < TRIES; i++) {
        double axis[3] = { lt_rng_normal(&p->rng), lt_rng_normal(&p->rng), lt_rng_normal(&p->rng) };
        base = turned_by(&base, axis, lt_rng_range(&p->rng, 0, 2));
        base.t[2] = lt_rng_range(&p->rng, 0.25, 0.32);
        hand = compose(&base, &p->grip);
        if (arm_is_clear(&hand))
            break;
    }
    do
        push(p, holding(p, SYNTH_MANIPULATE, p->n_keys ? wander(p, &base) : base));
    while (p->n_keys < 4 || (p->n_moments < min_moments && p->n_keys < MAX_KEYS));
}

/* When the keys' own times are too short for what was asked, all take longer alike. */
static void stretch(plan *p, int min_moments)
{
    const double factor = (double)min_moments / p->n_moments;

    if (factor <= 1)
        return;
    p->n_moments = 1;
    for (int i = 1; i < p->n_keys; i++) {
        p->key[i].moments = (int)ceil(p->key[i].moments * factor);
        p->n_moments += p->key[i].moments;
    }
}

/* ---- moments ---- */

static double min_jerk(double x)
{
    return x * x * x * (10 + x * (-15 + 6 * x));
}

/* Trembling of finger number i at moment t: a few slow sines. */
static double tremble(const plan *p, int i, int t)
{
    double sum = 0;

    for (int k = 0; k < TREMBLES && !p->spec->steady; k++)
        sum += sin(p->tremble_phase[i][k] + p->tremble_rate[k] * t);
    return TREMBLE / TREMBLES * sum;
}

static void set_fingers(const plan *p, double open, int t, double fingers[45])
{
    for (int i = 0; i < 45; i++)
        fingers[i] = p->closed[i] + open * (p->opened[i] - p->closed[i]) + tremble(p, i, t);
}

static synth_moment moment_at(const plan *p, const key *a, const key *b, double s, int t)
{
    synth_moment m = { .phase = b->phase };
    const rigid object = between(&a->object, &b->object, s);
    rigid hand = b->attached ? compose(&object, &p->grip) : between(&a->hand, &b->hand, s);

    if (b->attached && !p->spec->steady)
        for (int k = 0; k < 3; k++)
            hand.t[k] += SLIP * sin(p->slip_phase[k] + 0.12 * (k + 1) * t) * sin(M_PI * s);
    memcpy(m.R_hand, hand.R, sizeof(m.R_hand));
    memcpy(m.wrist, hand.t, sizeof(m.wrist));
    memcpy(m.R_obj, object.R, sizeof(m.R_obj));
    memcpy(m.t_obj, object.t, sizeof(m.t_obj));
    set_fingers(p, a->open + s * (b->open - a->open), t, m.fingers);
    return m;
}

static void fill(const plan *p, synth_moment *out)
{
    int t = 0;

    out[t++] = moment_at(p, &p->key[0], &p->key[0], 0, 0);
    for (int i = 1; i < p->n_keys; i++)
        for (int k = 1; k <= p->key[i].moments; k++, t++)
            out[t] = moment_at(p, &p->key[i - 1], &p->key[i], min_jerk((double)k / p->key[i].moments), t);
}

static void start(plan *p, const synth_sequence_spec *spec)
{
    *p = (plan){ .spec = spec, .rng = lt_rng_make(spec->seed, spec->stream), .grip = grip_of(spec) };
    for (int i = 0; i < 45; i++) {
        p->closed[i] = spec->grasp->pose[3 + i];
        p->opened[i] = p->closed[i] * (i >= 36 ? OPEN_THUMB : OPEN);
        for (int k = 0; k < TREMBLES; k++)
            p->tremble_phase[i][k] = lt_rng_range(&p->rng, -M_PI, M_PI);
    }
    for (int k = 0; k < 3; k++) {
        p->tremble_rate[k] = lt_rng_range(&p->rng, 0.1, 0.5);
        p->slip_phase[k] = lt_rng_range(&p->rng, -M_PI, M_PI);
    }
}

lt_status synth_sequence_new(lt_arena *arena, const synth_sequence_spec *spec, synth_sequence *out)
{
    const int at_least = spec->min_moments > MIN_MOMENTS ? spec->min_moments : MIN_MOMENTS;
    const bool held = !synth_fits_table(spec);
    synth_moment *moment;
    plan p;

    start(&p, spec);
    if (held)
        plan_in_hand(&p, at_least);
    else
        plan_from_table(&p, at_least);
    stretch(&p, at_least);
    moment = lt_arena_array(arena, (size_t)p.n_moments, sizeof(*moment));
    if (!moment)
        return lt_error(LT_ENOMEM, "synth: no memory for a sequence of %d moments", p.n_moments);
    fill(&p, moment);
    *out = (synth_sequence){ .n = p.n_moments, .moment = moment, .held = held };
    return LT_OK;
}

lt_status synth_sequence_join(lt_arena *arena, const synth_sequence *part, int n, synth_sequence *out)
{
    synth_sequence all = { .held = true };
    synth_moment *moment;

    for (int i = 0; i < n; i++)
        all.n += part[i].n;
    all.moment = moment = lt_arena_array(arena, (size_t)all.n, sizeof(*moment));
    if (!moment)
        return lt_error(LT_ENOMEM, "synth: no memory for a sequence of %d moments", all.n);
    for (int i = 0; i < n; i++) {
        all.held = all.held && part[i].held;
        for (int t = 0; t < part[i].n; t++, moment++) {
            *moment = part[i].moment[t];
            moment->round = i;
        }
    }
    *out = all;
    return LT_OK;
}
