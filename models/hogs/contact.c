/* SPDX-License-Identifier: Apache-2.0 */
#include "models/hogs/contact.h"

#include "libtensor/base/parallel.h"
#include "libtensor/graph/op.h"
#include "models/hogs/occupancy.h"

#include <math.h>
#include <string.h>

static const double TAU_CONTACT = 0.010, TAU_PENETRATION = 0.020, TIP = 0.015;      /* metres */

/* ---- zones of a template ----------------------------------------------------------------------------------- */

static double distance(const float a[3], const float b[3])
{
    double sum = 0;

    for (int k = 0; k < 3; k++)
        sum += ((double)a[k] - (double)b[k]) * ((double)a[k] - (double)b[k]);
    return sqrt(sum);
}

static int nearest_tip(const contact_template *t, int v)
{
    int best = 0;

    for (int i = 1; i < CONTACT_TIPS; i++)
        if (distance(t->vertex[v], t->vertex[t->tip[i]]) < distance(t->vertex[v], t->vertex[t->tip[best]]))
            best = i;
    return best;
}

static bool on_palm(const contact_template *t, int v)
{
    double facing = 0;

    for (int b = 1; b < SKIN_FIELD_BONES; b++)
        if (t->weight[v][b] > t->weight[v][0])
            return false;
    for (int k = 0; k < 3; k++)
        facing += (double)t->normal[v][k] * t->palm[k];
    return facing > 0;
}

void contact_zones(const contact_template *t, int32_t *zone)
{
    for (int v = 0; v < t->n; v++) {
        const int tip = nearest_tip(t, v);

        if (distance(t->vertex[v], t->vertex[t->tip[tip]]) <= TIP)
            zone[v] = tip;
        else
            zone[v] = on_palm(t, v) ? CONTACT_PALM : CONTACT_NOWHERE;
    }
}

/* ---- contact_points: which points touch, and which are inside -------------------------------------------- */

/* contact_points: 1 for a point that counts, else 0; no gradient
 *   distance (B, N)   point (B, N, 3)   zone (B, N)   inside (B, cells)   box (B, 6)   R (B, 3, 3)   t (B, 3)
 *   ->   touching (B, N): the nearest of each zone, the first of equals, unless it is inside;   inside (B, N)
 */
enum { DISTANCE, POINT, ZONE, INSIDE, BOX, ROTATION, TRANSLATION, INPUTS };

static lt_status infer(lt_call *c)
{
    const lt_shape *d = &c->in[DISTANCE]->shape;
    int64_t B, N;

    if (lt_want_rank(c, DISTANCE, "distance", 2))
        return LT_ESHAPE;
    B = d->dim[0], N = d->dim[1];
    if (lt_want_shape(c, POINT, "points", LT_SHAPE(B, N, 3)) || lt_want_shape(c, ZONE, "zones", LT_SHAPE(B, N))
        || lt_want_shape(c, INSIDE, "cells", LT_SHAPE(B, OCCUPANCY_CELLS))
        || lt_want_shape(c, BOX, "box", LT_SHAPE(B, 6))
        || lt_want_shape(c, ROTATION, "rotation", LT_SHAPE(B, 3, 3))
        || lt_want_shape(c, TRANSLATION, "translation", LT_SHAPE(B, 3)))
        return LT_ESHAPE;
    if (c->in[ZONE]->dtype != LT_I32 || c->in[INSIDE]->dtype != LT_U8)
        return lt_fail(c, "zones are no LT_I32, or cells no LT_U8");
    c->outs[0]->shape = c->outs[1]->shape = *d;
    return LT_OK;
}

static const lt_real *real_of(const lt_call *c, int i, int64_t at)
{
    return (const lt_real *)c->in[i]->data + at;
}

/* The grid of frame b asked about a place of the camera frame: R^T (x - t) */
static bool is_inside(const lt_call *c, int64_t b, const lt_real *x)
{
    const lt_real *R = real_of(c, ROTATION, 9 * b), *t = real_of(c, TRANSLATION, 3 * b), *box = real_of(c, BOX, 6 * b);
    const uint8_t *inside = (const uint8_t *)c->in[INSIDE]->data + b * OCCUPANCY_CELLS;
    int64_t cell = 0;

    for (int k = 2; k >= 0; k--) {
        const lt_real own = R[k] * (x[0] - t[0]) + R[3 + k] * (x[1] - t[1]) + R[6 + k] * (x[2] - t[2]);
        const lt_real at = (own - box[k]) * box[3 + k];

        if (!(at >= 0 && at < OCCUPANCY_SIDE))
            return false;
        cell = cell * OCCUPANCY_SIDE + (int64_t)at;
    }
    return inside[cell];
}

static void forward_frame(void *ctx, int64_t b)
{
    const lt_call *c = ctx;
    const int64_t N = lt_dim(c->out, 1);
    const int32_t *zone = (const int32_t *)c->in[ZONE]->data + b * N;
    const lt_real *d = real_of(c, DISTANCE, b * N);
    lt_real *touching = (lt_real *)c->outs[0]->data + b * N, *inside = (lt_real *)c->outs[1]->data + b * N;
    int64_t nearest[CONTACT_ZONES];

    for (int z = 0; z < CONTACT_ZONES; z++)
        nearest[z] = -1;
    for (int64_t i = 0; i < N; i++) {
        const int32_t z = zone[i];

        touching[i] = 0;
        inside[i] = is_inside(c, b, real_of(c, POINT, 3 * (b * N + i)));
        if (z >= 0 && z < CONTACT_ZONES && (nearest[z] < 0 || d[i] < d[nearest[z]]))
            nearest[z] = i;
    }
    for (int z = 0; z < CONTACT_ZONES; z++)
        if (nearest[z] >= 0)
            touching[nearest[z]] = 1 - inside[nearest[z]];
}

static void forward(const lt_call *c)
{
    lt_parallel_for(lt_dim(c->out, 0), forward_frame, (void *)c);
}

static const lt_op contact_points_op = {
    .name = "contact_points", .n_out = 2, .flags = LT_OP_DETACH,
    .any_type = LT_ANY_TYPE_IN(ZONE) | LT_ANY_TYPE_IN(INSIDE), .infer = infer, .forward = forward,
};

/* ---- losses -------------------------------------------------------------------------------------------------- */

/* The mean of tau tanh(d / tau) over the points that weight has */
static lt_tensor *saturated(lt_tensor *d, double tau, lt_tensor *weight)
{
    const lt_shape flat = LT_SHAPE(lt_numel(d));
    lt_tensor *zeros, *x = lt_reshape(lt_scale(lt_tanh(lt_scale(d, 1 / tau)), tau), flat);

    lt_constant_reals(d->graph, flat, &zeros);
    return lt_l1_loss(x, zeros, lt_reshape(weight, flat));
}

contact_losses contact_losses_of(const contact_in *in)
{
    lt_tensor *hand = lt_detach(in->hand), *object = hogs_posed(lt_detach(in->surface), &in->pose);
    lt_tensor *d = lt_nearest(hand, object), *touching;
    lt_tensor *const ask[INPUTS] = { d, hand, in->zone, in->inside, in->box, in->pose.R, in->pose.t };

    touching = lt_apply(&contact_points_op, NULL, 0, ask, INPUTS);
    return (contact_losses){
        .contact = saturated(d, TAU_CONTACT, touching),
        .penetration = saturated(d, TAU_PENETRATION, lt_result(touching, 1)),
    };
}
