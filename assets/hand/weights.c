/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which joints move a point of the skin, and how much.
 *
 * Along a digit the weight passes from one joint to the next across the plane that halves their bones;
 * between digits it is shared by nearness, so that webs stretch; the ball of the thumb shares with the palm.
 */
#include "assets/hand/internal.h"

enum { MAX_JOINTS = 4 };            /* that may move one point */

/* How far up the digit p is: share[k] of its weight belongs to joint k, the rest to the wrist. */
static void chain_shares(const hand_skeleton *s, int digit, vec3 p, double share[3])
{
    static const double finger_mm[3] = { 9, 6, 5 }, thumb_mm[3] = { 15, 8, 6 };
    const double *half = digit == DIGIT_THUMB ? thumb_mm : finger_mm;
    double passed = 1;

    for (int k = 0; k < 3; k++) {
        const vec3 here = s->joint[digit][k];
        const vec3 before = k ? s->bone[digit][k - 1] : unit(sub(here, s->wrist));
        const vec3 normal = unit(add(before, s->bone[digit][k]));

        passed *= smoothstep(-half[k], half[k], dot(sub(p, here), normal));
        if (k)
            share[k - 1] -= passed;
        share[k] = passed;
    }
}

static double digit_bones(const hand_skeleton *s, int digit, vec3 p)
{
    double d = 1e9;

    for (int k = 0; k < 3; k++)
        d = fmin(d, segment_distance(p, s->joint[digit][k], s->joint[digit][k + 1]));
    return d;
}

/* 1 on the thumb, 0 on palm and fingers, between them on the ball of the thumb and its web. */
static double thumb_share(const hand_skeleton *s, vec3 p)
{
    const double own = digit_bones(s, DIGIT_THUMB, p);
    double other = 1e9;

    for (int d = 0; d < DIGIT_THUMB; d++) {
        other = fmin(other, segment_distance(p, s->wrist, s->joint[d][0]));
        other = fmin(other, segment_distance(p, s->joint[d][0], s->joint[d][1]));
    }
    return smoothstep(0.36, 0.72, other / (other + own));
}

static void keep_largest(double w[LT_HAND_JOINTS])
{
    double sum = 0;
    int left = 0;

    for (int j = 0; j < LT_HAND_JOINTS; j++)
        left += w[j] > 0;
    for (; left > MAX_JOINTS; left--) {
        int least = -1;

        for (int j = 0; j < LT_HAND_JOINTS; j++)
            if (w[j] > 0 && (least < 0 || w[j] < w[least]))
                least = j;
        w[least] = 0;
    }
    for (int j = 0; j < LT_HAND_JOINTS; j++)
        sum += w[j];
    for (int j = 0; j < LT_HAND_JOINTS; j++)
        w[j] /= sum;
}

void hand_weights_at(const hand_skeleton *s, vec3 p, double weight[LT_HAND_JOINTS])
{
    const double thumb = thumb_share(s, p);
    double near[DIGITS], sum = 0, given = 0, share[3];

    for (int d = 0; d < DIGIT_THUMB; d++)
        sum += near[d] = pow(fmax(digit_bones(s, d, p), 1), -6);
    for (int d = 0; d < DIGIT_THUMB; d++)
        near[d] *= (1 - thumb) / sum;
    near[DIGIT_THUMB] = thumb;
    for (int d = 0; d < DIGITS; d++) {
        chain_shares(s, d, p, share);
        for (int k = 0; k < 3; k++) {
            const double w = near[d] * share[k];

            weight[digit_joint(d, k)] = w > 0.002 ? w : 0;      /* no joint pulls at a distance */
            given += weight[digit_joint(d, k)];
        }
    }
    weight[0] = fmax(1 - given, 0);
    keep_largest(weight);
}
