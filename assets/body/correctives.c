/* SPDX-License-Identifier: Apache-2.0 */
/* Pose correctives: elbows, knees, hips and shoulders keep their volume when they bend; hands have their own. */
#include "assets/body/internal.h"

#include <string.h>

static const surface_hinge hinges[] = {         /* of the right side */
    { BODY_KNEE + 1, { 1, 0, 0 }, { 0, 0, 2 }, 0.6 },
    { BODY_ELBOW + 1, { 0, 1, 0 }, { 0, 0, -1.5 }, 0.6 },
    { BODY_HIP + 1, { 1, 0, 0 }, { 0, 0, -4 }, 0.4 },
    { BODY_SHOULDER + 1, { 0, 0, 1 }, { 0, 2, 0 }, 0.35 },
};

/* The share of a vertex that turns with a joint: its own weight and those beyond it. */
static double turning_share(const double weight[J], int joint)
{
    bool with[J] = { false };
    double sum = 0;

    for (int j = joint; j < J; j++) {
        with[j] = j == joint || with[body_parent[j]];
        sum += with[j] ? weight[j] : 0;
    }
    return sum;
}

/* The left one is the mirror image: a turn about an axis of the plane of the mirror turns round. */
static surface_hinge mirrored(const surface_hinge *h)
{
    surface_hinge m = *h;

    m.joint--;
    m.axis = scale(body_mirror(h->axis), -1);
    m.puff = body_mirror(h->puff);
    return m;
}

/* Features of a hand's joint k, 1 to 15, begin here in the body. */
static int feature_of(int side, int k) { return 9 * (BODY_FINGERS + side * BODY_HAND_JOINTS + k - 2); }

/* A left hand's are the mirror image of a right one's, as synth_hand_mirror has them. */
static void hand_features(const body_skin *skin, const lt_hand_model *right, float *out)
{
    for (int side = 0; side < 2; side++)
        for (int v = 0; v < HAND; v++)
            for (int c = 0; c < 3; c++) {
                float *dirs = out + ((size_t)skin->hand[side][v] * 3 + (size_t)c) * BODY_FEATURES;

                for (int f = 0; f < LT_HAND_POSE_FEATURES; f++) {
                    const bool turned = (f % 9 / 3 == 0) != (f % 3 == 0);
                    const float d = right->posedirs[v][c][f];

                    dirs[feature_of(side, 1) + f] = side == 0 && (c == 0) != turned ? -d : d;
                }
            }
}

void body_correctives(const body_skeleton *s, const body_skin *skin, const lt_hand_model *hand, float *out)
{
    memset(out, 0, (size_t)V * 3 * BODY_FEATURES * sizeof(*out));
    for (size_t i = 0; i < LT_COUNT(hinges); i++)
        for (int left = 0; left < 2; left++) {
            const surface_hinge h = left ? mirrored(&hinges[i]) : hinges[i];

            for (int v = 0; v < V; v++) {
                const double w = turning_share(skin->weight[v], h.joint);
                surface_hinge here = h;

                if (w < 0.001 || w > 0.999)
                    continue;
                here.puff = scale(h.puff, 4 * w * (1 - w));
                surface_bend(&here, sub(skin->vertex[v], s->joint[h.joint]), w, out + (size_t)v * 3 * BODY_FEATURES,
                             BODY_FEATURES);
            }
        }
    hand_features(skin, hand, out);
}
