/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A candidate: a grip is drawn, the open hand put before it, moved up, and closed finger by finger.
 */
#include "synth/grasp/internal.h"

#include "libtensor/geometry/mat3.h"

#include <string.h>

#define DEG (M_PI / 180)
#define MM 1e-3
#define OPENING (100 * MM)              /* widest thing that goes between thumb and fingers */
#define TOUCH (0.5 * MM)

/* ---- which side ----------------------------------------------------------------------------------- */

/* Sides of the grip's box that the palm may take (a: along which axis, with sign) and where the thumb's
 * side of the hand then points (u). */
typedef struct { int a, u; double sign_a, sign_u, chance; } side;

static double width_across(const grip *g, int a, int u)
{
    return 2 * g->half[3 - a - u];
}

static double side_chance(const grip *g, const side *s)
{
    const double w = width_across(g, s->a, s->u), up = s->sign_a * g->axis[s->a][2];

    if (w > OPENING || up > 0.35)
        return 0;
    if (s->sign_u * g->axis[s->u][2] < -0.5)
        return 0.15;                                    /* thumb down is rare */
    return (w < 70 * MM ? 1 : 0.5) * (g->half[s->u] > 28 * MM ? 1 : 0.4);
}

static bool allowed(unsigned mask, int axis, double sign)
{
    return mask >> (2 * axis + (sign < 0)) & 1;
}

static bool draw_side(const grip *g, lt_rng *rng, side *out)
{
    side sides[24];
    double total = 0, at;
    int n = 0;

    for (int a = 0; a < 3; a++)
        for (int i = 0; i < 8; i++) {
            side s = {
                .a = a, .u = (a + 1 + (i & 1)) % 3, .sign_a = i & 2 ? -1 : 1, .sign_u = i & 4 ? -1 : 1,
            };
            if (!allowed(g->approach, a, s.sign_a) || !allowed(g->thumb, s.u, s.sign_u))
                continue;
            s.chance = side_chance(g, &s);
            total += s.chance;
            sides[n++] = s;
        }
    at = lt_rng_uniform(rng) * total;
    if (!(total > 0))
        return false;
    for (int i = 0; i < n; i++) {
        *out = sides[i];
        at -= sides[i].chance;
        if (at < 0)
            break;
    }
    return true;
}

/* ---- the open hand -------------------------------------------------------------------------------- */

/* What is drawn for a candidate besides its side. */
typedef struct {
    bool power;                         /* palm at the object; else finger tips alone */
    double clearance;                   /* of the palm */
    double curl;                        /* how much the outer joints bend with the first one */
    double anchor[3];                   /* rest frame: where the middle of the grip is to come */
} style;

static style draw_style(const grasp_hand *h, double width, double depth, lt_rng *rng)
{
    const double *knuckle = h->J[4];
    style s;

    s.power = lt_rng_uniform(rng) < (width < 24 * MM ? 0.35 : 0.75) && depth > 10 * MM;
    s.clearance = s.power ? lt_rng_range(rng, 2 * MM, 6 * MM) : lt_rng_range(rng, 15 * MM, 40 * MM);
    s.curl = lt_rng_range(rng, 0.35, 1.1);
    s.anchor[0] = s.power ? fmax(24 * MM, fmin(54 * MM, width / 2 + 9 * MM))
                          : width / 2 + lt_rng_range(rng, -25 * MM, 5 * MM);
    s.anchor[0] += knuckle[0] + lt_rng_range(rng, -7 * MM, 7 * MM);
    s.anchor[1] = knuckle[1];
    s.anchor[2] = knuckle[2] + (s.power ? lt_rng_range(rng, -8 * MM, 8 * MM) : lt_rng_range(rng, 0, 22 * MM));
    return s;
}

static void open_hand(const grasp_hand *h, const style *s, lt_rng *rng, double q[ANGLES])
{
    for (int f = 0; f < THUMB; f++) {
        double *a = &q[finger_angle(f)];
        a[0] = lt_rng_range(rng, -6, 6) * DEG;
        a[1] = (s->power ? 5 : 25) * DEG;
        a[2] = (s->power ? 12 : 20) * DEG;
        a[3] = (s->power ? 8 : 12) * DEG;
    }
    q[16] = lt_rng_range(rng, 15, 30) * DEG;
    q[17] = lt_rng_range(rng, 25, 45) * DEG;
    q[18] = lt_rng_range(rng, -10, 15) * DEG;
    q[19] = 0;
    q[20] = 0;
    for (int a = 0; a < ANGLES; a++)
        q[a] = fmax(h->angle[a].lo, fmin(h->angle[a].hi, q[a]));
}

/* Rest axes to the object's: the palm (-y) looks along a, the thumb's side (+z) points along u. */
static void face(const double a[3], const double u[3], double R[9])
{
    double x[3], y[3], z[3];
    double d = lt_vec3_dot(a, u);

    for (int k = 0; k < 3; k++) {
        y[k] = -a[k];
        z[k] = u[k] - d * a[k];
    }
    lt_vec3_unit(z);
    lt_vec3_cross(y, z, x);
    for (int k = 0; k < 3; k++) {
        R[3 * k] = x[k];
        R[3 * k + 1] = y[k];
        R[3 * k + 2] = z[k];
    }
}

static void jitter(double v[3], double sigma, lt_rng *rng)
{
    for (int k = 0; k < 3; k++)
        v[k] += sigma * lt_rng_normal(rng);
    lt_vec3_unit(v);
}

/* Smallest distance of the palm's skin. */
static double palm_distance(const synth_grasp_ctx *ctx, const hand_state *s)
{
    const grasp_hand *h = &ctx->hand;
    hand_frames f;
    double best = INFINITY, p[3];

    grasp_hand_frames(h, s, &f);
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        if (h->pad[v] == 15) {
            grasp_hand_skin(h, &f, h->rest, v, p);
            best = fmin(best, synth_sdf_at(&ctx->sdf, p, NULL));
        }
    return best;
}

/* Up to the object along a, as far as the clearance allows, but not past its middle. */
static void move_up(const synth_grasp_ctx *ctx, const double a[3], double clearance, double far,
                    hand_state *s)
{
    for (int step = 0; step < 40 && far > 0; step++) {
        const double way = fmin(far, palm_distance(ctx, s) - clearance);
        if (way < 0.2 * MM)
            return;
        for (int k = 0; k < 3; k++)
            s->t[k] += way * a[k];
        far -= way;
    }
}

static void put_before(const synth_grasp_ctx *ctx, const grip *g, const side *sd, const style *st,
                       lt_rng *rng, hand_state *s)
{
    double a[3], u[3], target[3], from[3], d[3];
    const double turn = lt_rng_range(rng, -g->turn, g->turn), back = 0.16;
    const double room = fmax(0, g->half[sd->u] - 32 * MM) + 4 * MM, slide = lt_rng_range(rng, -room, room);
    double Z[9];

    for (int k = 0; k < 3; k++) {
        a[k] = sd->sign_a * g->axis[sd->a][k];
        u[k] = sd->sign_u * g->axis[sd->u][k];
        target[k] = g->centre[k] + slide * u[k] - g->pivot[k];
    }
    grasp_axis_turn((const double[3]){ 0, 0, 1 }, turn, Z);
    lt_mat3_mulvec(Z, a, a);
    lt_mat3_mulvec(Z, u, u);
    lt_mat3_mulvec(Z, target, target);
    jitter(a, 0.10, rng);
    jitter(u, 0.16, rng);
    face(a, u, s->R);
    lt_vec3_sub(st->anchor, ctx->hand.J[0], from);
    lt_mat3_mulvec(s->R, from, d);
    for (int k = 0; k < 3; k++)
        s->t[k] = g->pivot[k] + target[k] - back * a[k] - d[k];
    move_up(ctx, a, st->clearance, back + g->half[sd->a], s);
}

/* ---- closing -------------------------------------------------------------------------------------- */

/* Distance of each phalanx's skin, the nearest vertex. */
static void finger_distance(const synth_grasp_ctx *ctx, const hand_state *s, int finger, double d[3])
{
    const grasp_hand *h = &ctx->hand;
    hand_frames f;
    double p[3];

    grasp_hand_frames(h, s, &f);
    d[0] = d[1] = d[2] = INFINITY;
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        if (h->finger[v] == finger) {
            const int k = (h->weight_joint[v][0] - 1) % 3;
            grasp_hand_skin(h, &f, h->rest, v, p);
            d[k] = fmin(d[k], synth_sdf_at(&ctx->sdf, p, NULL));
        }
}

/* Bend all joints at their rates; what touches stops itself and every joint nearer to the palm. */
static void close_finger(const synth_grasp_ctx *ctx, int finger, const double rate[3], hand_state *s)
{
    const grasp_hand *h = &ctx->hand;
    const int first = finger_angle(finger) + (finger == THUMB ? 2 : 1);
    double d[3], step;
    int free_from = 0;

    for (int i = 0; i < 60 && free_from < 3; i++) {
        finger_distance(ctx, s, finger, d);
        for (int k = free_from; k < 3; k++)
            if (d[k] < TOUCH)
                free_from = k + 1;
        step = fmin(7, fmax(1, fmin(fmin(d[0], d[1]), d[2]) / MM)) * DEG;
        for (int k = free_from; k < 3; k++)
            s->q[first + k] = fmin(h->angle[first + k].hi, s->q[first + k] + rate[k] * step);
    }
}

/* A finger that starts inside the object is stretched first. */
static void open_finger(const synth_grasp_ctx *ctx, int finger, hand_state *s)
{
    const grasp_hand *h = &ctx->hand;
    const int first = finger_angle(finger) + (finger == THUMB ? 2 : 1);
    double d[3];

    for (int i = 0; i < 12; i++) {
        finger_distance(ctx, s, finger, d);
        if (fmin(fmin(d[0], d[1]), d[2]) > 0)
            return;
        for (int k = 0; k < 3; k++)
            s->q[first + k] = fmax(h->angle[first + k].lo, s->q[first + k] - 5 * DEG);
    }
}

static void close_hand(const synth_grasp_ctx *ctx, const style *st, hand_state *s)
{
    const double finger[3] = { 1, 1.1 * st->curl, 0.7 * st->curl }, thumb[3] = { 1, 0.7, 0.5 };

    for (int f = 0; f < FINGERS; f++) {
        open_finger(ctx, f, s);
        close_finger(ctx, f, f == THUMB ? thumb : finger, s);
    }
}

static const grip *draw_grip(const synth_grasp_ctx *ctx, lt_rng *rng)
{
    double total = 0, at;
    int i = 0;

    for (int k = 0; k < ctx->n_grips; k++)
        total += ctx->grips[k].chance;
    at = lt_rng_uniform(rng) * total;
    while (i + 1 < ctx->n_grips && at >= ctx->grips[i].chance)
        at -= ctx->grips[i++].chance;
    return &ctx->grips[i];
}

/* Finger tips always; for a power grasp the other phalanges and the palm follow as far as they can. */
static void make_wish(const style *st, grasp_wish *wish)
{
    for (int f = 0; f < FINGERS; f++) {
        wish->pad[3 * f] = st->power && f != THUMB ? 0.25 : 0;
        wish->pad[3 * f + 1] = st->power ? 0.35 : 0.05;
        wish->pad[3 * f + 2] = f == THUMB ? 1.5 : 1;
    }
    wish->pad[15] = st->power ? 0.5 : 0;
}

bool grasp_place(const synth_grasp_ctx *ctx, lt_rng *rng, hand_state *s, grasp_wish *wish, const char **kind)
{
    const grip *g = draw_grip(ctx, rng);
    style st;
    side sd;

    if (!draw_side(g, rng, &sd))
        return false;
    st = draw_style(&ctx->hand, width_across(g, sd.a, sd.u), 2 * g->half[sd.a], rng);
    open_hand(&ctx->hand, &st, rng, s->q);
    put_before(ctx, g, &sd, &st, rng, s);
    close_hand(ctx, &st, s);
    make_wish(&st, wish);
    *kind = st.power ? g->kind : "pinch";
    return true;
}
