/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Joints as weighted means of the skin in a thin slice across their bone. Those of the hands are the hand's own.
 */
#include "assets/body/internal.h"

#include <string.h>

static const double FOLLOW = 0.003;

/* The slice of a joint of the middle or of the right side: across which direction, and how far from the joint. */
typedef struct { int joint; vec3 across; double reach; } slice;

static const slice slices[] = {
    { BODY_PELVIS, { 0, 1, 0 }, 190 }, { BODY_SPINE1, { 0, 1, 0 }, 190 }, { BODY_SPINE2, { 0, 1, 0 }, 190 },
    { BODY_SPINE3, { 0, 1, 0 }, 190 }, { BODY_NECK, { 0, 1, 0.5 }, 110 }, { BODY_HEAD, { 0, 1, 0.3 }, 110 },
    { BODY_JAW, { 0, 1, 0.2 }, 110 }, { BODY_HIP + 1, { 0.5, 1, 0 }, 130 }, { BODY_KNEE + 1, { 0, 1, 0 }, 80 },
    { BODY_ANKLE + 1, { 0, 1, 0.3 }, 65 }, { BODY_FOOT + 1, { 0, 0, 1 }, 60 }, { BODY_COLLAR + 1, { 0.4, 1, 0 }, 125 },
    { BODY_SHOULDER + 1, { 1, 0.2, 0 }, 80 }, { BODY_ELBOW + 1, { 1, 0, 0 }, 70 },
};

static void add_row(float *out, int j, const surface_ring *r)
{
    for (int i = 0; i < r->n; i++)
        out[(size_t)j * V + (size_t)r->id[i]] = (float)r->w[i];
}

/* Joint j from the vertices that cost least. */
static void regress(const body_skeleton *s, const body_skin *skin, const body_motion *motion, int j, const double *cost,
                    float *out)
{
    const vec3 *moves[BODY_SHAPES];
    vec3 way[BODY_SHAPES];
    surface_ring r;

    for (int k = 0; k < BODY_SHAPES; k++) {
        moves[k] = motion[k].vertex;
        way[k] = motion[k].joint[j];
    }
    surface_ring_near(skin->vertex, cost, V, s->joint[j], &r);
    surface_regress(skin->vertex, moves, s->joint[j], way, BODY_SHAPES, FOLLOW, &r);
    add_row(out, j, &r);
}

static void slice_costs(const body_skin *skin, const slice *c, vec3 joint, bool left, double *cost)
{
    const vec3 across = unit(left ? body_mirror(c->across) : c->across);

    for (int v = 0; v < V; v++) {
        const vec3 off = sub(skin->vertex[v], joint);

        cost[v] = 1 + fabs(dot(off, across)) + 10 * fmax(0, norm(off) - c->reach);
        if (skin->source[v] != FROM_SKIN)
            cost[v] += 1e6;
    }
}

/* An eye's joint, from around its middle. */
static void eye_costs(const body_skin *skin, vec3 joint, bool left, double *cost)
{
    for (int v = 0; v < V; v++) {
        const bool own = skin->source[v] == FROM_EYE && skin->left[v] == left;

        cost[v] = 1 + fabs(skin->vertex[v].z - joint.z) + (own ? 0 : 1e6);
    }
}

static void hand_rows(const body_skin *skin, const lt_hand_model *hand, float *out)
{
    for (int side = 0; side < 2; side++)
        for (int k = 0; k < LT_HAND_JOINTS; k++)
            for (int v = 0; v < HAND; v++) {
                const int j = k ? BODY_FINGERS + side * BODY_HAND_JOINTS + k - 1 : BODY_WRIST + side;

                out[(size_t)j * V + (size_t)skin->hand[side][v]] = hand->J_regressor[k][v];
            }
}

void body_regressor(const body_skeleton *s, const body_skin *skin, const lt_hand_model *hand,
                    const body_motion motion[BODY_SHAPES], float *out)
{
    double cost[V];

    memset(out, 0, (size_t)J * V * sizeof(*out));
    for (size_t i = 0; i < LT_COUNT(slices); i++) {
        const int j = slices[i].joint;
        const bool paired = s->joint[j].x != 0;

        for (int left = 0; left <= paired; left++) {
            slice_costs(skin, &slices[i], s->joint[j - left], left, cost);
            regress(s, skin, motion, j - left, cost, out);
        }
    }
    for (int left = 0; left < 2; left++) {
        eye_costs(skin, s->joint[BODY_EYE + 1 - left], left, cost);
        regress(s, skin, motion, BODY_EYE + 1 - left, cost, out);
    }
    hand_rows(skin, hand, out);
}
