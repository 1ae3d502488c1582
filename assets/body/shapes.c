/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Ten directions in which bodies differ, as displacements of skin and joints per standard deviation. Each is designed
 * on the skeleton: bones become longer, flesh around them thicker; the skin follows by its weights.
 */
#include "assets/body/internal.h"

/* Parts that change together. */
enum { TRUNK, CHEST, HIPS, LEGS, FEET, SHOULDERS, ARMS, NECK, HEAD, HANDS, PARTS };

static int part_of(int joint)
{
    static const int8_t part[BODY_FINGERS] = {
        TRUNK, HIPS, HIPS, TRUNK, LEGS, LEGS, CHEST, LEGS, LEGS, CHEST, FEET, FEET, NECK, CHEST, CHEST, NECK, SHOULDERS,
        SHOULDERS, ARMS, ARMS, ARMS, ARMS, HEAD, HEAD, HEAD,
    };

    return joint < BODY_FINGERS ? part[joint] : HANDS;
}

/* By which share the bones that end in joints of a part become longer, and the flesh that moves with a joint thicker,
 * or, of the chest, deeper. */
typedef struct { double length[PARTS], girth[PARTS], depth; } change;

static const change changes[BODY_SHAPES] = {
    { { 0.053, 0.053, 0.04, 0.053, 0.05, 0.04, 0.053, 0.045, 0.03 },
      { 0.035, 0.035, 0.035, 0.035, 0.05, 0.035, 0.03, 0.03, 0.03 }, 0 },
    { { [HIPS] = 0.02, [SHOULDERS] = 0.02 },
      { [TRUNK] = 0.08, [CHEST] = 0.06, [HIPS] = 0.07, [LEGS] = 0.05, [SHOULDERS] = 0.06, [ARMS] = 0.05,
        [NECK] = 0.03 },
      0 },
    { { [TRUNK] = 0.035, [CHEST] = 0.035, [LEGS] = -0.025 }, { 0 }, 0 },
    { { [SHOULDERS] = 0.08 }, { [CHEST] = 0.02, [SHOULDERS] = 0.02 }, 0 },
    { { [HIPS] = 0.08 }, { [TRUNK] = 0.03, [HIPS] = 0.03 }, 0 },
    { { [ARMS] = 0.035 }, { 0 }, 0 },
    { { 0 }, { [HIPS] = 0.03, [LEGS] = 0.06, [SHOULDERS] = 0.06, [ARMS] = 0.06 }, 0 },
    { { 0 }, { 0 }, 0.06 },
    { { [NECK] = 0.06, [HEAD] = 0.03 }, { [NECK] = 0.02, [HEAD] = 0.03 }, 0 },
    { { [FEET] = 0.05 }, { [FEET] = 0.04 }, 0 },
};

/* Flesh of the head swells about the head's joint, which is where its bone begins. */
static bool is_point(int j)
{
    return j == BODY_HEAD || j == BODY_FOOT || j == BODY_FOOT + 1 || (j >= BODY_JAW && j < BODY_FINGERS);
}

/* The joint at the end of the bone that begins in j. */
static int bone_end(int j)
{
    static const int8_t end[BODY_JAW] = {
        BODY_SPINE1, 4, 5, 6, 7, 8, 9, 10, 11, 12, 0, 0, 15, 16, 17, 0, 18, 19, 20, 21, 0, 0,
    };

    return end[j];
}

/* What girth does to the point p that moves with joint j. */
static vec3 swell(const body_skeleton *s, const change *c, int j, vec3 p)
{
    const vec3 from = s->joint[j];
    vec3 off;
    double share;

    if (j >= BODY_FINGERS || j == BODY_WRIST || j == BODY_WRIST + 1)
        return vec(0, 0, 0);
    off = is_point(j) ? sub(p, from) : sub(p, mix(from, s->joint[bone_end(j)], along(p, from, s->joint[bone_end(j)])));
    share = c->girth[j == BODY_HEAD ? HEAD : part_of(is_point(j) ? j : bone_end(j))];
    return add(scale(off, share), vec(0, 0, part_of(j) == CHEST ? c->depth * off.z : 0));
}

/* How far along its bone p is takes it between the ways of the bone's ends. */
static vec3 ride(const body_skeleton *s, const body_motion *m, int j, vec3 p)
{
    double t;

    if (j >= BODY_JAW || is_point(j) || j == BODY_WRIST || j == BODY_WRIST + 1)
        return m->joint[j];
    t = along(p, s->joint[j], s->joint[bone_end(j)]);
    return mix(m->joint[j], m->joint[bone_end(j)], t);
}

/* Fingers go with the wrist; eyes and jaw stay where they are in a head that swells. */
static void move_joints(const body_skeleton *s, const change *c, body_motion *m)
{
    for (int j = 1; j < J; j++) {
        const int parent = body_parent[j];
        const double share = j >= BODY_JAW && j < BODY_FINGERS ? c->girth[HEAD] : c->length[part_of(j)];

        m->joint[j] = m->joint[parent];
        if (j < BODY_FINGERS)
            m->joint[j] = madd(m->joint[j], sub(s->joint[j], s->joint[parent]), share);
    }
}

void body_shapes(const body_skeleton *s, const body_skin *skin, body_motion motion[BODY_SHAPES])
{
    for (int k = 0; k < BODY_SHAPES; k++) {
        body_motion *m = &motion[k];

        move_joints(s, &changes[k], m);
        for (int v = 0; v < V; v++)
            for (int j = 0; j < J; j++)
                if (skin->weight[v][j] > 0) {
                    const vec3 p = skin->vertex[v];
                    const vec3 way = add(ride(s, m, j, p), swell(s, &changes[k], j, p));

                    m->vertex[v] = madd(m->vertex[v], way, skin->weight[v][j]);
                }
    }
}
