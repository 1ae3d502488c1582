/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The posed hand as capsules, for contact with itself.
 */
#include "assets/hand/hand.h"
#include "libtensor/geometry/rotation.h"

#include <string.h>

enum { PALM_CAPSULES = 5 };

/* Radii at base, middle, last joint and tip of index, middle, little, ring, thumb; metres. */
static const double digit_radius[5][4] = {
    { 0.0100, 0.0088, 0.0078, 0.0068 }, { 0.0102, 0.0090, 0.0080, 0.0070 }, { 0.0086, 0.0074, 0.0066, 0.0059 },
    { 0.0096, 0.0084, 0.0075, 0.0066 }, { 0.0130, 0.0110, 0.0095, 0.0085 },
};
static const int tip_keypoint[5] = { 17, 18, 20, 19, 16 };       /* of the same digits */

static synth_hand_capsule between(const double a[3], const double b[3], double ra, double rb,
                                  int joint)
{
    synth_hand_capsule c = { .radius_a = ra, .radius_b = rb, .joint = joint };

    memcpy(c.a, a, sizeof(c.a));
    memcpy(c.b, b, sizeof(c.b));
    return c;
}

/* The last capsule ends 0.7 radii short of the tip keypoint, which lies a little before the very tip. */
static void end_at_tip(synth_hand_capsule *c)
{
    const double len = lt_vec3_distance(c->a, c->b);
    const double keep = len > c->radius_b ? 1 - 0.7 * c->radius_b / len : 0;

    for (int i = 0; i < 3; i++)
        c->b[i] = c->a[i] + keep * (c->b[i] - c->a[i]);
}

void synth_hand_capsules(const double keypoints[LT_HAND_KEYPOINTS][3],
                         synth_hand_capsule capsule[SYNTH_HAND_CAPSULES])
{
    for (int d = 0; d < 5; d++) /* the palm: from the wrist to the root of each digit */
        capsule[d] =
            between(keypoints[0], keypoints[1 + 3 * d], 0.0145, d == 4 ? 0.013 : 0.0105, 0);
    for (int d = 0; d < 5; d++)
        for (int k = 0; k < 3; k++) {
            const int joint = 1 + 3 * d + k;
            synth_hand_capsule *c = &capsule[PALM_CAPSULES + 3 * d + k];

            *c = between(keypoints[joint], keypoints[k == 2 ? tip_keypoint[d] : joint + 1],
                         digit_radius[d][k], digit_radius[d][k + 1], joint);
            if (k == 2)
                end_at_tip(c);
        }
}

double synth_hand_capsule_distance(const synth_hand_capsule *c, const double p[3])
{
    double ab[3], ap[3], off[3], t, len2;

    lt_vec3_sub(c->b, c->a, ab);
    lt_vec3_sub(p, c->a, ap);
    len2 = lt_vec3_dot(ab, ab);
    t = len2 > 0 ? fmin(fmax(lt_vec3_dot(ap, ab) / len2, 0), 1) : 0;
    for (int i = 0; i < 3; i++)
        off[i] = ap[i] - t * ab[i];
    return lt_vec3_norm(off) - (c->radius_a + t * (c->radius_b - c->radius_a));
}

/* Parts that meet at a joint or share a web always touch: neighbours on a digit, the first phalanx and
 * the palm, first phalanges among themselves. */
static bool may_touch(int part, int joint)
{
    const int d = (part - 1) / 3, e = (joint - 1) / 3, k = (part - 1) % 3, l = (joint - 1) % 3;

    if (part == 0 || joint == 0)
        return part == joint || (part ? k : l) == 0;
    if (d == e)
        return k - l < 2 && l - k < 2;
    return k == 0 && l == 0;
}

double synth_hand_self_depth(const uint8_t part[LT_HAND_VERTICES],
                             const double vertices[LT_HAND_VERTICES][3],
                             const double keypoints[LT_HAND_KEYPOINTS][3])
{
    synth_hand_capsule capsule[SYNTH_HAND_CAPSULES];
    double depth = 0;

    synth_hand_capsules(keypoints, capsule);
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        for (int c = 0; c < SYNTH_HAND_CAPSULES; c++)
            if (!may_touch(part[v], capsule[c].joint))
                depth = fmax(depth, -synth_hand_capsule_distance(&capsule[c], vertices[v]));
    return depth;
}
