/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Adam on wrist pose and joint angles: pads to the surface, skin and bones out of it, fingers apart.
 *
 * The gradient is that of the skinned hand, by forces: each vertex pulls at the joints that carry it, and an
 * angle's derivative is the moment about its axis of everything beyond its joint.
 */
#include "synth/grasp/internal.h"

#include "libtensor/geometry/mat3.h"

#include <string.h>

enum { STEPS = 60, PARAMETERS = ANGLES + 6 };

#define PRESS 0.6e-3                    /* how far a pad that touches is pressed flat */
#define BARE 0.8                        /* share of a sphere's radius that stays clear of the object */
#define APART 0.8                       /* share of two radii that fingers keep between them */

/* Forces (gradients of the energy) and their moments about the origin, per joint. */
typedef struct { double force[LT_HAND_JOINTS][3], moment[LT_HAND_JOINTS][3]; } load;

static void pull(load *l, int joint, const double at[3], const double force[3])
{
    double m[3];

    lt_vec3_cross(at, force, m);
    for (int k = 0; k < 3; k++) {
        l->force[joint][k] += force[k];
        l->moment[joint][k] += m[k];
    }
}

/* A force on skinned vertex v acts on each joint at the place where that joint alone would put it. */
static void pull_skin(const grasp_hand *h, const hand_frames *f, const double (*rest)[3], int v,
                      const double force[3], load *l)
{
    for (int i = 0; i < h->n_weights[v]; i++) {
        const int j = h->weight_joint[v][i];
        const double w = h->weight[v][i], part[3] = { w * force[0], w * force[1], w * force[2] };
        double d[3], p[3];
        lt_vec3_sub(rest[v], h->J[j], d);
        lt_rigid_apply(f->R[j], f->t[j], d, p);
        pull(l, j, p, part);
    }
}

/* The vertex of each pad that is nearest to the object. */
typedef struct { int vertex[16]; double distance[16], gradient[16][3]; } nearest;

static void skin_loads(const synth_grasp_ctx *ctx, const hand_frames *f, const double (*rest)[3], load *l,
                       nearest *near)
{
    const grasp_hand *h = &ctx->hand;
    double p[3], g[3], force[3];

    for (int i = 0; i < 16; i++) {
        near->vertex[i] = -1;
        near->distance[i] = INFINITY;
    }
    for (int v = 0; v < LT_HAND_VERTICES; v++) {
        const int pad = h->pad[v];
        double d;
        grasp_hand_skin(h, f, rest, v, p);
        d = synth_sdf_at(&ctx->sdf, p, g);
        if (pad >= 0 && d < near->distance[pad]) {
            near->vertex[pad] = v;
            near->distance[pad] = d;
            memcpy(near->gradient[pad], g, sizeof(g));
        }
        if (d >= -PRESS)
            continue;
        for (int k = 0; k < 3; k++)
            force[k] = 2 * (d + PRESS) * g[k];
        pull_skin(h, f, rest, v, force, l);
    }
}

/* Quadratic when near, fading out from 15 mm: a pad that cannot reach does not drag the hand along. */
static void pad_loads(const grasp_hand *h, const hand_frames *f, const double (*rest)[3], const grasp_wish *wish,
                      const nearest *near, load *l)
{
    for (int i = 0; i < 16; i++) {
        const double d = near->distance[i] + PRESS, q = d / 15e-3;
        const double slope = 6 * wish->pad[i] * d / ((1 + q * q) * (1 + q * q));
        double force[3];
        if (near->vertex[i] < 0 || slope == 0)
            continue;
        for (int k = 0; k < 3; k++)
            force[k] = slope * near->gradient[i][k];
        pull_skin(h, f, rest, near->vertex[i], force, l);
    }
}

static bool may_touch(const hand_sphere *a, const hand_sphere *b)
{
    const int fa = a->joint ? (a->joint - 1) / 3 : -1, fb = b->joint ? (b->joint - 1) / 3 : -1;

    if (fa == fb)
        return true;
    return (fa < 0 && (b->joint - 1) % 3 == 0) || (fb < 0 && (a->joint - 1) % 3 == 0);
}

static void bone_loads(const synth_grasp_ctx *ctx, const hand_frames *f, load *l)
{
    const grasp_hand *h = &ctx->hand;
    double at[SPHERES][3], g[3], force[3];

    for (int i = 0; i < SPHERES; i++) {
        const double r = BARE * h->sphere[i].radius;
        double d;
        grasp_hand_sphere(h, f, i, at[i]);
        d = synth_sdf_at(&ctx->sdf, at[i], g);
        if (d >= r)
            continue;
        for (int k = 0; k < 3; k++)
            force[k] = 8 * (d - r) * g[k];
        pull(l, h->sphere[i].joint, at[i], force);
    }
    for (int i = 0; i < SPHERES; i++)
        for (int j = 0; j < i; j++) {
            const double r = APART * (h->sphere[i].radius + h->sphere[j].radius);
            double way[3], d2, d;
            if (may_touch(&h->sphere[i], &h->sphere[j]))
                continue;
            lt_vec3_sub(at[i], at[j], way);
            d2 = lt_vec3_dot(way, way);
            if (d2 >= r * r)
                continue;
            d = sqrt(d2) + 1e-9;
            for (int k = 0; k < 3; k++)
                force[k] = 6 * (d - r) * way[k] / d;
            pull(l, h->sphere[i].joint, at[i], force);
            for (int k = 0; k < 3; k++)
                force[k] = -force[k];
            pull(l, h->sphere[j].joint, at[j], force);
        }
}

/* The derivative by each angle, then by the wrist's turn about the object's axes, then by its place. */
static void collect(const grasp_hand *h, const hand_frames *f, load *l, double grad[PARAMETERS])
{
    double arm[3];

    for (int j = LT_HAND_JOINTS - 1; j > 0; j--)
        for (int k = 0; k < 3; k++) {
            l->force[lt_hand_parent[j]][k] += l->force[j][k];
            l->moment[lt_hand_parent[j]][k] += l->moment[j][k];
        }
    for (int a = 0; a < ANGLES; a++) {
        const int j = h->angle[a].joint;
        lt_vec3_cross(f->t[j], l->force[j], arm);
        grad[a] = lt_vec3_dot(f->axis[a], l->moment[j]) - lt_vec3_dot(f->axis[a], arm);
    }
    lt_vec3_cross(f->t[0], l->force[0], arm);
    for (int k = 0; k < 3; k++) {
        grad[ANGLES + k] = l->moment[0][k] - arm[k];
        grad[ANGLES + 3 + k] = l->force[0][k];
    }
}

/* Hands hold their angles near where closing left them, and a last joint follows the one before. */
static void habit(const hand_state *s, const double *q0, double grad[PARAMETERS])
{
    for (int a = 0; a < ANGLES; a++)
        grad[a] += 2e-5 * (s->q[a] - q0[a]);
    for (int finger = 0; finger < THUMB; finger++) {
        const int a = finger_angle(finger) + 2;
        const double off = s->q[a + 1] - 0.67 * s->q[a];
        grad[a + 1] += 4e-5 * off;
        grad[a] -= 4e-5 * 0.67 * off;
    }
}

typedef struct { double m[PARAMETERS], v[PARAMETERS]; } moments;

static double adam(moments *a, int i, double g, int step)
{
    a->m[i] = 0.85 * a->m[i] + 0.15 * g;
    a->v[i] = 0.95 * a->v[i] + 0.05 * g * g;
    return a->m[i] / (1 - pow(0.85, step)) / (sqrt(a->v[i] / (1 - pow(0.95, step))) + 1e-7);
}

static void take_step(const grasp_hand *h, const double grad[PARAMETERS], int step, moments *mo, hand_state *s)
{
    const double fade = 1 - 0.85 * (step - 1.0) / STEPS;
    double turn[3], angle, T[9];

    for (int a = 0; a < ANGLES; a++) {
        s->q[a] -= 0.035 * fade * adam(mo, a, grad[a], step);
        s->q[a] = fmax(h->angle[a].lo, fmin(h->angle[a].hi, s->q[a]));
    }
    for (int k = 0; k < 3; k++) {
        turn[k] = -0.012 * fade * adam(mo, ANGLES + k, grad[ANGLES + k], step);
        s->t[k] -= 1e-3 * fade * adam(mo, ANGLES + 3 + k, grad[ANGLES + 3 + k], step);
    }
    angle = lt_vec3_unit(turn);
    if (angle < 1e-12)
        return;
    grasp_axis_turn(turn, angle, T);
    lt_mat3_mul(T, s->R, s->R);
}

void grasp_refine(const synth_grasp_ctx *ctx, const grasp_wish *wish, hand_state *s)
{
    const grasp_hand *h = &ctx->hand;
    double rest[LT_HAND_VERTICES][3], q0[ANGLES], grad[PARAMETERS];
    moments mo = { 0 };
    hand_frames f;
    nearest near;
    load l;

    memcpy(q0, s->q, sizeof(q0));
    for (int step = 1; step <= STEPS; step++) {
        if (step % 30 == 1)
            grasp_hand_correct(h, s, rest);
        memset(&l, 0, sizeof(l));
        grasp_hand_frames(h, s, &f);
        skin_loads(ctx, &f, (const double (*)[3])rest, &l, &near);
        pad_loads(h, &f, (const double (*)[3])rest, wish, &near, &l);
        bone_loads(ctx, &f, &l);
        collect(h, &f, &l, grad);
        habit(s, q0, grad);
        take_step(h, grad, step, &mo, s);
    }
}
