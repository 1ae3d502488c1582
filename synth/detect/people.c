/* SPDX-License-Identifier: Apache-2.0 */
/* Persons stand or sit around the table; arms reach in from outside the picture. */
#include "synth/detect/internal.h"

#include "libtensor/geometry/mat3.h"

#include <math.h>
#include <string.h>

enum { GRASP = 0x47524153 };

static const double HOLDS = 0.5;                /* share of hands that hold something; of hands from near by: */
static const double HOLDS_NEAR = 0.25;
static const double REACH = 0.7;                /* metres of an arm whose person is not in the picture */

/* ---- hands ---- */

/* A hand of somebody: what it holds, if it does, and its fingers. */
static lt_status draw_grip(layout *l, const synth_person *who, bool left, synth_grip *out)
{
    const uint64_t stream = lt_rng_mix(lt_rng_mix(GRASP, (uint64_t)l->number), (uint64_t)l->n_grasps++);
    const bool holds = lt_rng_uniform(&l->r) < (l->near ? HOLDS_NEAR : HOLDS);
    const synth_prop_pair *what = &l->place->prop[lt_rng_below(&l->r, YCB_COUNT)];
    lt_status st = LT_ENUMERIC;

    if (holds)
        st = synth_grip_hold(l->place->hand, &who->subject, what, left, lt_rng_mix(l->place->seed, stream), out);
    if (st == LT_ENUMERIC) {
        synth_grip_bare(l->place->hand, &who->subject, left, &l->r, out);
        st = LT_OK;
    }
    return st;
}

/* Whether a forearm would pass through the table's top. */
static bool through_table(const layout *l, const double wrist[3], const double elbow[3])
{
    enum { STEPS = 8 };
    const double *table = l->out->room.table;

    for (int i = 0; i <= STEPS; i++) {
        double p[3];
        for (int k = 0; k < 3; k++)
            p[k] = wrist[k] + i * (elbow[k] - wrist[k]) / STEPS;
        if (p[0] > table[0] && p[0] < table[2] && p[1] > table[1] && p[1] < table[3] && p[2] < 0.05 && p[2] > -0.1)
            return true;
    }
    return false;
}

/* The hand with its wrist at `wrist` and its arm towards `elbow`, bent at the wrist by some degrees; whether it is
 * above the table and apart from what is there. */
static bool try_hand(layout *l, synth_held *h, const double wrist[3], const double elbow[3])
{
    const double roll = lt_rng_range(&l->r, -M_PI, M_PI);
    double along[3], shift[3], lowest;
    synth_ball b;

    lt_vec3_sub(elbow, wrist, h->elbow);
    lt_vec3_unit(h->elbow);
    for (int k = 0; k < 3; k++)
        along[k] = h->elbow[k] + 0.22 * lt_rng_normal(&l->r);
    lt_vec3_unit(along);
    synth_grip_turn(h->grip, along, NULL, roll, h->R);
    lt_mat3_mulvec(h->R, h->grip->wrist, shift);
    lt_vec3_sub(wrist, shift, h->t);
    b = layout_ball(l, h->grip, h->grip->prop, h->R, h->t, &lowest);
    b.radius *= 0.85;
    if (through_table(l, wrist, elbow) || !layout_fits(l, &b, lowest))
        return false;
    layout_add_ball(l, b.centre, b.radius);
    return true;
}

static lt_status place_hand(layout *l, synth_held *h)
{
    const int thing = l->out->world.n_things;
    const lt_status st = synth_held_place(l->arena, h, &l->out->world);

    if (st || l->out->world.n_things == thing)
        return st;
    layout_note(l, &(detect_put){ .thing = thing, .grip = h->grip, .who = h->who }, h->R, h->t);
    if (h->grip->prop && l->out->world.n_things > thing + 1)
        layout_note(l, &(detect_put){ .thing = thing + 1, .prop = h->grip->prop }, h->R, h->t);
    return LT_OK;
}

/* ---- persons ---- */

static synth_stance draw_stance(layout *l)
{
    static const double side[3][4] = { { 0.5, 1, 0, 1 }, { 0, 0.4, -1, 0 }, { 1, 0.4, 1, 0 } };   /* of the table */
    const double *table = l->out->room.table, *q = side[lt_rng_below(&l->r, 5) % 3];
    const double slide = lt_rng_range(&l->r, -0.45, 0.45), off = lt_rng_range(&l->r, 0.1, 0.3);
    const double turn = lt_rng_range(&l->r, -0.5, 0.5);
    synth_stance s = { .facing = atan2(-q[3], -q[2]) + turn };

    s.sits = lt_rng_below(&l->r, 5) < 3;
    s.lean = lt_rng_range(&l->r, 0, s.sits ? 0.3 : 0.45);
    s.nod = lt_rng_range(&l->r, -0.1, 0.6);
    s.look = lt_rng_range(&l->r, -0.7, 0.7);
    s.stride[0] = lt_rng_range(&l->r, -0.12, 0.12);
    s.stride[1] = lt_rng_range(&l->r, -0.12, 0.12);
    s.at[0] = table[0] + q[0] * (table[2] - table[0]) + off * q[2] + slide * q[3];
    s.at[1] = table[1] + q[1] * (table[3] - table[1]) + off * q[3] + slide * fabs(q[2]);
    s.at[2] = LAYOUT_FLOOR;
    return s;
}

/* The person as balls, to keep others out of him. */
static void occupy(layout *l, const synth_person *p, const synth_stance *s, const synth_reach *reach)
{
    double seat[3] = { s->at[0], s->at[1], s->at[2] + p->stature * (s->sits ? 0.31 : 0.53) }, chest[3], head[3];

    for (int k = 0; k < 3; k++) {
        chest[k] = (reach->shoulder[0][k] + reach->shoulder[1][k]) / 2;
        head[k] = chest[k] + (k == 2) * 0.16 * p->stature;
    }
    layout_add_rod(l, seat, chest, 0.15);
    layout_add_ball(l, head, 0.12);
}

static bool stands_free(const layout *l, const synth_stance *s)
{
    for (int i = 0; i < l->n_balls; i++)
        if (hypot(s->at[0] - l->ball[i].centre[0], s->at[1] - l->ball[i].centre[1]) < 0.2 + l->ball[i].radius)
            return false;
    return true;
}

/* Where a wrist may be before a person. */
static void draw_wrist(layout *l, const synth_reach *reach, int arm, double out[3])
{
    const double ahead = lt_rng_range(&l->r, 0.12, 0.5), inward = lt_rng_range(&l->r, -0.12, 0.26);
    const double up = lt_rng_range(&l->r, -0.5, 0.15);

    for (int k = 0; k < 3; k++)
        out[k] = reach->shoulder[arm][k] + ahead * reach->forward[k] + (arm ? 1 : -1) * inward * reach->left[k] +
                 (k == 2) * up;
}

/* The hands of a person's arms, before his body is placed: hands need its place in the list, so it comes first. */
typedef struct {
    double wrist[2][3], elbow[2][3];
    synth_grip *grip[2];
    synth_held held[2];
    bool seen[2];                               /* false: no place was free, the arm hangs down */
} arms;

static lt_status draw_arms(layout *l, const synth_person *p, const synth_reach *reach, arms *a)
{
    for (int arm = 0; arm < 2; arm++) {
        synth_grip *g = lt_arena_alloc(l->arena, sizeof(*g));
        const lt_status st = g ? draw_grip(l, p, arm == 0, g) : lt_error(LT_ENOMEM, "synth: no memory for a hand");

        if (st)
            return st;
        a->grip[arm] = g;
        a->held[arm] = (synth_held){ .hand = l->place->hand, .who = &p->subject, .grip = g,
                                     .arm = reach->fore + 0.012, .cloth = p->shirt, .seed = p->seed,
                                     .stream = p->stream + (uint64_t)arm };
        for (int i = 0; i < LAYOUT_DRAWS && !a->seen[arm]; i++) {
            const double swivel = lt_rng_range(&l->r, 0, 0.9);
            draw_wrist(l, reach, arm, a->wrist[arm]);
            synth_reach_elbow(reach, arm, swivel, a->wrist[arm], a->elbow[arm]);
            a->seen[arm] = try_hand(l, &a->held[arm], a->wrist[arm], a->elbow[arm]);
        }
        if (a->seen[arm])
            layout_add_rod(l, a->wrist[arm], a->elbow[arm], 0.05);
    }
    return LT_OK;
}

/* An arm for which no place was free hangs down, with an empty hand. */
static void let_hang(layout *l, const synth_person *p, const synth_reach *reach, int arm, arms *a)
{
    synth_held *h = &a->held[arm];
    double down[3], shift[3];

    if (h->grip->prop)
        synth_grip_bare(l->place->hand, &p->subject, arm == 0, &l->r, a->grip[arm]);
    for (int k = 0; k < 3; k++)
        a->wrist[arm][k] = reach->shoulder[arm][k] + 0.05 * reach->forward[k] +
                           (arm ? -0.07 : 0.07) * reach->left[k] - (k == 2) * (reach->upper + reach->fore);
    synth_reach_elbow(reach, arm, 0.3, a->wrist[arm], a->elbow[arm]);
    lt_vec3_sub(a->elbow[arm], a->wrist[arm], down);
    lt_vec3_unit(down);
    memcpy(h->elbow, down, sizeof(down));
    synth_grip_turn(h->grip, down, NULL, lt_rng_range(&l->r, -M_PI, M_PI), h->R);
    lt_mat3_mulvec(h->R, h->grip->wrist, shift);
    lt_vec3_sub(a->wrist[arm], shift, h->t);
}

lt_status layout_add_person(layout *l, const synth_person *p)
{
    synth_stance s = draw_stance(l);
    synth_reach reach;
    arms a = { .seen = { false } };
    int thing;
    lt_status st;

    for (int i = 0; i < LAYOUT_DRAWS && !stands_free(l, &s); i++)
        s = draw_stance(l);
    if (!stands_free(l, &s))
        return LT_OK;
    synth_person_reach(p, &s, &reach);
    occupy(l, p, &s, &reach);
    st = draw_arms(l, p, &reach, &a);
    for (int arm = 0; !st && arm < 2; arm++)
        if (!a.seen[arm])
            let_hang(l, p, &reach, arm, &a);
    if (!st)
        st = synth_person_place(l->arena, p, &s, a.elbow, 0, &l->out->world, &thing);
    for (int arm = 0; !st && arm < 2; arm++) {
        a.held[arm].owner = thing;
        st = place_hand(l, &a.held[arm]);
    }
    return st;
}

/* ---- arms from outside the picture ---- */

/* From the camera; a hand from near by takes so much of the picture as it is drawn to. */
static double draw_distance(layout *l)
{
    static const double length = 0.19;          /* metres of a hand */
    const double lo = l->near ? 80 : 0.24, hi = l->near ? 300 : 1.5, drawn = exp(lt_rng_range(&l->r, log(lo), log(hi)));

    return l->near ? length * l->out->camera.fx / drawn : drawn;
}

/* A wrist in the picture and an elbow outside it, as far as the arm is long at most. */
static bool draw_reach(layout *l, double wrist[3], double elbow[3])
{
    const synth_camera *c = &l->out->camera;
    const double u = lt_rng_range(&l->r, -5, DETECT_SIDE + 5), v = lt_rng_range(&l->r, -5, DETECT_SIDE + 5);
    const double z = draw_distance(l), nearer = lt_rng_range(&l->r, 0.5, 1.1);
    const double past = lt_rng_range(&l->r, 40, 120), across = lt_rng_range(&l->r, -60, 60);
    const uint32_t side = lt_rng_below(&l->r, 6);
    const double eu = side == 4 ? -past : side == 5 ? DETECT_SIDE + past : u + across;
    const double ev = side < 4 ? DETECT_SIDE + past : v + across;

    layout_unproject(c, u, v, z, wrist);
    layout_unproject(c, eu, ev, fmax(0.12, z * nearer), elbow);
    return lt_vec3_distance(wrist, elbow) < REACH - 0.04;
}

lt_status layout_add_arm(layout *l)
{
    const bool left = lt_rng_below(&l->r, 2);
    const synth_person *p = &l->place->person[lt_rng_below(&l->r, DETECT_PEOPLE)];
    synth_grip *g = lt_arena_alloc(l->arena, sizeof(*g));
    synth_held h = { .hand = l->place->hand, .who = &p->subject, .grip = g, .arm = REACH, .cloth = p->shirt,
                     .owner = -1, .seed = p->seed, .stream = p->stream + left };
    const lt_status st = g ? draw_grip(l, p, left, g) : lt_error(LT_ENOMEM, "synth: no memory for a hand");

    for (int i = 0; !st && i < 4 * LAYOUT_DRAWS; i++) {
        double wrist[3], elbow[3];
        if (!draw_reach(l, wrist, elbow) || !try_hand(l, &h, wrist, elbow))
            continue;
        layout_add_rod(l, wrist, elbow, 0.045);
        return place_hand(l, &h);
    }
    return st;
}
