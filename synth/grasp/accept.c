/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Whether a hand holds the object: what touches, how deep, whether a finger goes through another, and whether forces
 * inside the friction cones can balance.
 */
#include "synth/grasp/internal.h"

#include "assets/hand/hand.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/mat3.h"

#include <string.h>

enum { MAX_CONTACTS = 16, EDGES = 8, ROUNDS = 300 };

/* The promises are 4, 3, 1.5 mm and 2 cm^3 on the meshes; the grid is exact to a fraction of its step. */
#define NEAR 3.4e-3
#define DEEPEST 2.5e-3
#define MEAN_DEEP 1.3e-3
#define MOST_VOLUME 1.8e-6
#define CLEAR 0.45                      /* share of a sphere's radius: a bone may not come closer */
#define THROUGH 0.9e-3                  /* one finger in another; the promise is 1 mm */
#define FRICTION 0.6
#define RESIDUE 0.12                    /* of the squeezing force */

typedef struct { double at[3], inward[3]; bool thumb; } contact;

typedef struct {
    contact contact[MAX_CONTACTS];
    int n;
} holding;

static const int finger_order[FINGERS] = { 1, 2, 4, 3, 0 };     /* into synth_grasp's contact */

static double lowest_of(const grasp_hand *h, const double (*p)[3])
{
    double z = INFINITY;

    for (int v = 0; v < LT_HAND_VERTICES; v++)
        if (h->finger[v] >= 0)
            z = fmin(z, p[v][2]);
    return z;
}

/* Depths and touching fingers; the nearest vertex of each pad becomes a contact for the balance. */
static void touch(const synth_grasp_ctx *ctx, const double (*p)[3], synth_grasp *out, holding *hold)
{
    const grasp_hand *h = &ctx->hand;
    double best[MAX_CONTACTS], d, g[3], n = 0;
    contact of[MAX_CONTACTS];

    for (int i = 0; i < MAX_CONTACTS; i++)
        best[i] = NEAR;
    for (int v = 0; v < LT_HAND_VERTICES; v++) {
        d = synth_sdf_at(&ctx->sdf, p[v], g);
        if (d < 0) {
            out->penetration = fmax(out->penetration, -d);
            out->mean_penetration -= d;
            out->volume -= d * h->area[v];
            n++;
        }
        if (d < NEAR && h->finger[v] >= 0)
            out->contact[finger_order[h->finger[v]]] = true;
        if (h->pad[v] < 0 || d >= best[h->pad[v]])
            continue;
        best[h->pad[v]] = d;
        lt_vec3_unit(g);
        of[h->pad[v]].thumb = h->finger[v] == THUMB;
        for (int k = 0; k < 3; k++) {
            of[h->pad[v]].at[k] = p[v][k] - ctx->centre[k];
            of[h->pad[v]].inward[k] = -g[k];
        }
    }
    if (n > 0)
        out->mean_penetration /= n;
    for (int i = 0; i < MAX_CONTACTS; i++)
        if (best[i] < NEAR)
            hold->contact[hold->n++] = of[i];
}

static bool bones_free(const synth_grasp_ctx *ctx, const hand_frames *f)
{
    const grasp_hand *h = &ctx->hand;

    for (int i = 0; i < SPHERES; i++) {
        double at[3];

        grasp_hand_sphere(h, f, i, at);
        if (synth_sdf_at(&ctx->sdf, at, NULL) < CLEAR * h->sphere[i].radius)
            return false;
    }
    return true;
}

static bool goes_through_itself(const grasp_hand *h, const hand_frames *f, const double (*p)[3])
{
    double keypoints[LT_HAND_KEYPOINTS][3];

    lt_hand_keypoints(p[0], f->t[0], lt_hand_tips_ho3d, LT_HAND_MANO_ORDER, keypoints[0]);
    return synth_hand_self_depth(h->part, p, (const double (*)[3])keypoints) > THROUGH;
}

/* One edge of a contact's friction cone as force and torque; torques in units of the object's radius. */
static void cone_edge(const contact *c, int edge, double radius, double w[6])
{
    const double ref[3] = { fabs(c->inward[0]) < 0.7, fabs(c->inward[0]) >= 0.7, 0 };
    const double a = 2 * M_PI * edge / EDGES;
    double u[3], v[3], t[3];

    lt_vec3_cross(c->inward, ref, u);
    lt_vec3_unit(u);
    lt_vec3_cross(c->inward, u, v);
    for (int k = 0; k < 3; k++)
        w[k] = c->inward[k] + FRICTION * (cos(a) * u[k] + sin(a) * v[k]);
    lt_vec3_cross(c->at, w, t);
    for (int k = 0; k < 3; k++)
        w[3 + k] = t[k] / radius;
}

/* The smallest sum of forces and torques over convex combinations of cone edges (Frank-Wolfe with the
 * closest point on each segment): 0 when squeezing can be balanced by friction. The thumb must take a tenth. */
static double imbalance(const holding *h, double radius)
{
    double w[MAX_CONTACTS * EDGES][6], sum[6], share = 0, norm2 = 0;

    for (int i = 0; i < h->n * EDGES; i++)
        cone_edge(&h->contact[i / EDGES], i % EDGES, radius, w[i]);
    memcpy(sum, w[0], sizeof(sum));
    for (int round = 0; round < ROUNDS; round++) {
        double best = INFINITY, along = 0, d2 = 0, f;
        int pick = 0;
        for (int i = 0; i < h->n * EDGES; i++) {
            double d = 0;
            for (int k = 0; k < 6; k++)
                d += sum[k] * w[i][k];
            if (d < best) {
                best = d;
                pick = i;
            }
        }
        for (int k = 0; k < 6; k++) {
            const double d = w[pick][k] - sum[k];
            along -= sum[k] * d;
            d2 += d * d;
        }
        if (d2 < 1e-18 || along <= 1e-12)
            break;
        f = fmin(1, along / d2);
        for (int k = 0; k < 6; k++)
            sum[k] += f * (w[pick][k] - sum[k]);
        share += f * ((h->contact[pick / EDGES].thumb ? 1 : 0) - share);
    }
    for (int k = 0; k < 6; k++)
        norm2 += sum[k] * sum[k];
    return share < 0.1 ? INFINITY : sqrt(norm2);
}

static void skin_all(const grasp_hand *h, const hand_state *s, const hand_frames *f, double (*p)[3])
{
    double rest[LT_HAND_VERTICES][3];

    grasp_hand_correct(h, s, rest);
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        grasp_hand_skin(h, f, (const double (*)[3])rest, v, p[v]);
}

grasp_verdict grasp_judge(const synth_grasp_ctx *ctx, const hand_state *s, synth_grasp *out)
{
    double p[LT_HAND_VERTICES][3];
    holding hold = { .n = 0 };
    hand_frames f;
    int fingers = 0;

    *out = (synth_grasp){ 0 };
    grasp_hand_frames(&ctx->hand, s, &f);
    skin_all(&ctx->hand, s, &f, p);
    touch(ctx, (const double (*)[3])p, out, &hold);
    out->lowest = lowest_of(&ctx->hand, (const double (*)[3])p) - ctx->lowest;
    grasp_hand_pose(&ctx->hand, s, out->pose, out->trans);
    for (int i = 0; i < FINGERS; i++)
        fingers += out->contact[i];
    if (fingers < 3 || !out->contact[0])
        return NO_CONTACT;
    if (!bones_free(ctx, &f) || out->penetration > DEEPEST || out->mean_penetration > MEAN_DEEP
        || out->volume > MOST_VOLUME)
        return TOO_DEEP;
    if (goes_through_itself(&ctx->hand, &f, (const double (*)[3])p))
        return CROSSED;
    return hold.n < 2 || imbalance(&hold, ctx->radius) > RESIDUE ? NO_BALANCE : HOLDS;
}
