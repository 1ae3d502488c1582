/* SPDX-License-Identifier: Apache-2.0 */
/* Pose correctives: knuckles keep their shape when they bend. */
#include "assets/hand/internal.h"

#include <string.h>

static const double BULGE_MM = 0.5;         /* knuckles stand out when bent */
static const double FOLD_MM = 0.8;          /* the skin inside the bend gives way */

/* The share of a point that turns with a joint: its own weight and those beyond it on the digit. */
static double turning_share(const double weight[LT_HAND_JOINTS], int digit, int k)
{
    double w = 0;

    for (int i = k; i < 3; i++)
        w += weight[digit_joint(digit, i)];
    return w;
}

static void correct(const hand_skeleton *s, int digit, int k, vec3 p, double w,
                    float (*dirs)[LT_HAND_POSE_FEATURES])
{
    const vec3 n = s->flex[digit], up = unit(reject(s->dorsal[digit], s->bone[digit][k]));
    const vec3 from = sub(p, s->joint[digit][k]);
    const double height = clamp(dot(reject(from, n), up) / s->radius[digit][k], -1, 1);
    const double puff = 4 * w * (1 - w) * (height > 0 ? BULGE_MM : FOLD_MM) * fabs(height);
    const surface_hinge hinge = { .joint = digit_joint(digit, k), .axis = n, .puff = scale(up, puff),
                                  .gain = digit == DIGIT_THUMB && k == 0 ? 0.3 : 0.6 - 0.2 * height };

    surface_bend(&hinge, from, w, dirs[0], LT_HAND_POSE_FEATURES);
}

void hand_correctives(const hand_skeleton *s, const hand_rig *rig,
                      float out[LT_HAND_VERTICES][3][LT_HAND_POSE_FEATURES])
{
    memset(out, 0, sizeof(float[LT_HAND_VERTICES][3][LT_HAND_POSE_FEATURES]));
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        for (int d = 0; d < DIGITS; d++)
            for (int k = 0; k < 3; k++) {
                const double w = turning_share(rig->weight[v], d, k);

                if (w > 0.001 && w < 0.999)
                    correct(s, d, k, rig->vertex[v], w, out[v]);
            }
}
