/* SPDX-License-Identifier: Apache-2.0 */
/* Every draw stands in a statement of its own, as C leaves the order of arguments open. */
#include "synth/workplace/choose.h"

#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "synth/workplace/act.h"

#include <math.h>
#include <string.h>

enum { GRASPS = 8, TURNS = 24, SPOTS = 6, LEANS = 3, GRASP = 0x47525350 };

static const double NEAR = 0.003;               /* of choose_miss: as good as there */
static const double SKIN = 0.004;               /* metres from the table to the hand's skin */

void choose_wrist(const workplace_person *p, const synth_settled *at, double wrist[3], double hand[9])
{
    const double *a = p->grip.pose, mirror = p->style.arm == RIGHT ? 1 : -1;
    double root[9];

    lt_rot_from_axis_angle((double[]){ a[0], mirror * a[1], mirror * a[2] }, root);
    lt_mat3_mul(at->R, root, hand);
    lt_rigid_apply(at->R, at->t, p->grip.wrist, wrist);
}

double choose_miss(const workplace_script *s, const workplace_person *p, const workplace_act *act, int k,
                   const double wrist[3], const double hand[9])
{
    const int side = p->style.arm;
    workplace_person alone = *p;
    workplace_act own = *act;
    synth_body_goal goal;
    synth_body_pose body;

    alone.act = &own;
    alone.n_acts = 1;
    act_target(&alone, &own, k, wrist);
    act_goal(s, &alone, k, true, &goal);
    memcpy(goal.wrist[side], wrist, sizeof(goal.wrist[side]));
    memcpy(goal.hand[side], hand, sizeof(goal.hand[side]));
    synth_follow(&alone.body, &goal, &body);
    for (int i = 0; i <= 4; i++) {              /* the forearm is out of the table */
        const double *a = body.joint[BODY_WRIST + side], *b = body.joint[BODY_ELBOW + side];

        if (a[2] + i / 4.0 * (b[2] - a[2]) < 0.04)
            return 1;
    }
    return lt_vec3_distance(body.joint[BODY_WRIST + side], wrist) +
           0.1 * lt_rot_angle(body.world[BODY_WRIST + side], hand);
}

/* How far the hand is turned from where the program has it */
static double strangeness(const workplace_script *s, const workplace_person *p, const workplace_act *act, int k,
                          const double hand[9])
{
    workplace_person alone = *p;
    workplace_act own = *act;
    synth_body_goal goal;

    alone.act = &own;
    alone.n_acts = 1;
    act_goal(s, &alone, k, true, &goal);
    return lt_rot_angle(goal.hand[p->style.arm], hand);
}

/* Whether the hand around the object that stands on the table is above it */
static bool is_above(const workplace_object *o, const synth_grip *g)
{
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        if (g->vertices[v][2] + o->at.t[2] < SKIN)
            return false;
    return true;
}

/* Before the person, towards the arm's side, on the table. */
static void draw_spot(const workplace_script *s, const workplace_person *p, const workplace_object *o, lt_rng *r,
                      double out[2])
{
    const double ahead = lt_rng_range(r, 0.4, 0.56), aside = lt_rng_range(r, -0.04, 0.2);
    const double c = cos(p->facing), d = sin(p->facing), right = p->style.arm == LEFT ? -aside : aside;
    const double x[2] = { p->stand[0] + c * ahead + d * right, p->stand[1] + d * ahead - c * right };

    for (int k = 0; k < 2; k++)
        out[k] = fmax(s->table[k] + o->radius + 0.01, fmin(s->table[2 + k] - o->radius - 0.01, x[k]));
}

static void stand_at(const workplace_object *o, const double spot[2], double turn, synth_settled *out)
{
    const double c = cos(turn), d = sin(turn);

    *out = (synth_settled){ .R = { c, -d, 0, d, c, 0, 0, 0, 1 }, .t = { 0, 0, o->at.t[2] } };
    out->t[0] = spot[0] - (c * o->middle[0] - d * o->middle[1]);
    out->t[1] = spot[1] - (d * o->middle[0] + c * o->middle[1]);
}

typedef struct {
    double cost, lean;
    synth_grip grip;
    synth_settled at;
} best_grasp;

static void try_grasp(const workplace_script *s, workplace_person *p, const workplace_object *o, const double spot[2],
                      workplace_act *act, best_grasp *best)
{
    const int meets = act_meets(act);

    for (int i = 0; i < TURNS; i++) {
        double wrist[3], hand[9];
        synth_settled at;

        stand_at(o, spot, 2 * M_PI * i / TURNS, &at);
        choose_wrist(p, &at, wrist, hand);
        act->lean = 0;
        const double cost = strangeness(s, p, act, meets, hand);
        for (int l = 0; l < LEANS && cost + 0.3 * act->lean < best->cost; l++) {
            act->lean = 0.18 * l;
            if (cost + 0.3 * act->lean < best->cost && choose_miss(s, p, act, meets, wrist, hand) < NEAR)
                *best = (best_grasp){ cost + 0.3 * act->lean, act->lean, p->grip, at };
        }
    }
}

lt_status choose_grasp(const workplace_script *s, workplace_person *p, workplace_object *o, lt_rng *r,
                       workplace_hold *how, double *lean, bool *found)
{
    best_grasp best = { .cost = INFINITY };
    synth_subject who = { .bare = 1 };
    workplace_act act = { .first = 0, .object = 0 };
    double spot[SPOTS][2];

    lt_hand_rest_wrist(s->hand, who.beta, who.rest_wrist);
    action_draw_new(r, ACT_PICK, 0, &p->style, &act.draw);
    act.draw.arm = p->style.arm;
    act.draw.place[0] = act.draw.place[1] = act.draw.yaw = 0;
    act.last = act.draw.frames;
    for (int i = 0; i < SPOTS; i++)
        draw_spot(s, p, o, r, spot[i]);
    for (int i = 0; i < GRASPS; i++) {
        const uint64_t seed = lt_rng_mix(s->seed, lt_rng_mix(GRASP, lt_rng_u32(r)));
        const lt_status st = synth_grip_hold(s->hand, &who, o->prop, p->style.arm == LEFT, seed, &p->grip);

        if (st == LT_ENUMERIC)
            continue;
        if (st)
            return st;
        for (int k = 0; k < SPOTS && is_above(o, &p->grip); k++)
            try_grasp(s, p, o, spot[k], &act, &best);
    }
    *found = best.cost < INFINITY;
    p->grip = best.grip;
    if (!*found)
        return LT_OK;
    o->at = best.at;
    *lean = best.lean;
    choose_wrist(p, &o->at, how->wrist[0], how->hand);
    return LT_OK;
}
