/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Ten directions in which hands differ, as displacements of skin and joints per unit of beta.
 *
 * Each is designed on the skeleton (the palm deforms by a formula, bones stretch, swell or turn), spread
 * to the skin by the skinning weights, made orthogonal to those before it, and scaled to its size.
 */
#include "assets/hand/internal.h"

/* Change of one digit: bones longer by this share, flesh thicker, thicker at the tip, turned sideways. */
typedef struct { double length, girth, tip_girth, spread; } digit_change;

typedef struct {
    vec3 (*palm)(const hand_skeleton *s, vec3 p);
    digit_change digit[DIGITS];
} hand_change;

static vec3 still(const hand_skeleton *s, vec3 p)
{
    (void)s, (void)p;
    return vec(0, 0, 0);
}

static vec3 larger(const hand_skeleton *s, vec3 p) { return sub(p, s->wrist); }

static vec3 broader(const hand_skeleton *s, vec3 p)
{
    return vec(0, 0.8 * (p.y - s->wrist.y), p.z - s->wrist.z);
}

/* The edges of the palm sink below its middle, more so towards the fingers. */
static vec3 arched(const hand_skeleton *s, vec3 p)
{
    const double across = (p.z - s->joint[DIGIT_MIDDLE][0].z + 8) / 35;
    const double reach = clamp((s->wrist.x - p.x) / 90, 0, 1.2);

    return vec(0, (0.4 - fmin(across * across, 2.5)) * reach, 0);
}

static const hand_change changes[LT_HAND_BETAS] = {
    { larger, { { 1, 1, 0, 0 }, { 1, 1, 0, 0 }, { 1, 1, 0, 0 }, { 1, 1, 0, 0 }, { 1, 1, 0, 0 } } },
    { broader, { { 0, 1, 0, 0 }, { 0, 1, 0, 0 }, { 0, 1, 0, 0 }, { 0, 1, 0, 0 }, { 0, 1, 0, 0 } } },
    { still, { { 1, 0, 0, 0 }, { 1, 0, 0, 0 }, { 1, 0, 0, 0 }, { 1, 0, 0, 0 }, { 0.5, 0, 0, 0 } } },
    { still, { [DIGIT_THUMB] = { 1, 0, 0, 0 } } },
    { still, { [DIGIT_INDEX] = { 1, 0, 0, 0 }, [DIGIT_RING] = { -1, 0, 0, 0 } } },
    { still, { [DIGIT_LITTLE] = { 1, 0, 0, 0 } } },
    { still, { { 0, 1, 0, 0 }, { 0, 1, 0, 0 }, { 0, 1, 0, 0 }, { 0, 1, 0, 0 }, { 0, 1, 0, 0 } } },
    { arched, { { 0, 0, 0, 0 } } },
    { still, { [DIGIT_INDEX] = { 0, 0, 0, 0.8 }, [DIGIT_MIDDLE] = { 0, 0, 0, 0.1 },
               [DIGIT_RING] = { 0, 0, 0, -0.7 }, [DIGIT_LITTLE] = { 0, 0, 0, -1.5 },
               [DIGIT_THUMB] = { 0, 0, 0, -0.8 } } },
    { still, { { 0, 0, -1, 0 }, { 0, 0, -1, 0 }, { 0, 0, -1, 0 }, { 0, 0, -1, 0 }, { 0, 0, -1, 0 } } },
};

static const double rms_mm[LT_HAND_BETAS] = { 3.0,  1.6,  1.2,  0.9,  0.75,
                                              0.65, 0.55, 0.45, 0.38, 0.3 };

/* How a point that is fixed to bone k of a digit moves, when the bone's joint moves by dj. */
static vec3 with_bone(const hand_skeleton *s, const hand_change *c, int digit, int k, vec3 dj,
                      vec3 p)
{
    const digit_change *g = &c->digit[digit];
    const vec3 b = s->bone[digit][k], r = sub(p, s->joint[digit][k]), ax = scale(b, dot(r, b));
    const double t = clamp((k + along(p, s->joint[digit][k], s->joint[digit][k + 1])) / 3, 0, 1);
    const vec3 turned = cross(scale(s->dorsal[digit], g->spread), r);

    return add(add(add(dj, turned), scale(ax, g->length)),
               scale(sub(r, ax), g->girth + g->tip_girth * t * t));
}

static void move_joints(const hand_skeleton *s, const hand_change *c, vec3 dj[LT_HAND_JOINTS])
{
    dj[0] = c->palm(s, s->wrist);
    for (int d = 0; d < DIGITS; d++) {
        dj[digit_joint(d, 0)] = c->palm(s, s->joint[d][0]);
        for (int k = 0; k < 2; k++)
            dj[digit_joint(d, k + 1)] =
                with_bone(s, c, d, k, dj[digit_joint(d, k)], s->joint[d][k + 1]);
    }
}

static void move_skin(const hand_skeleton *s, const hand_change *c, const hand_rig *rig,
                      hand_motion *out)
{
    move_joints(s, c, out->joint);
    for (int v = 0; v < LT_HAND_VERTICES; v++) {
        const vec3 p = rig->vertex[v];

        out->vertex[v] = scale(c->palm(s, p), rig->weight[v][0]);
        for (int j = 1; j < LT_HAND_JOINTS; j++)
            if (rig->weight[v][j] > 0)
                out->vertex[v] = madd(out->vertex[v],
                                      with_bone(s, c, (j - 1) / 3, (j - 1) % 3, out->joint[j], p),
                                      rig->weight[v][j]);
    }
}

static double inner(const hand_rig *rig, const hand_motion *a, const hand_motion *b)
{
    double sum = 0;

    for (int v = 0; v < LT_HAND_VERTICES; v++)
        sum += rig->area[v] * dot(a->vertex[v], b->vertex[v]);
    return sum;                     /* areas add up to 1 */
}

/* m += factor * from, for skin and joints alike */
static void blend(hand_motion *m, const hand_motion *from, double factor)
{
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        m->vertex[v] = madd(m->vertex[v], from->vertex[v], factor);
    for (int j = 0; j < LT_HAND_JOINTS; j++)
        m->joint[j] = madd(m->joint[j], from->joint[j], factor);
}

void hand_betas(const hand_skeleton *s, const hand_rig *rig, hand_motion motion[LT_HAND_BETAS])
{
    for (int k = 0; k < LT_HAND_BETAS; k++) {
        move_skin(s, &changes[k], rig, &motion[k]);
        for (int i = 0; i < k; i++)
            blend(&motion[k], &motion[i],
                  -inner(rig, &motion[k], &motion[i]) / inner(rig, &motion[i], &motion[i]));
        blend(&motion[k], &motion[k], rms_mm[k] / sqrt(inner(rig, &motion[k], &motion[k])) - 1);
    }
}
