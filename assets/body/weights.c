/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which joints move a point of the skin, and how much. As the body stands with its arms out, weight passes from one
 * joint to the next across planes: heights in the trunk and the legs, widths in the arms. Hands have their own.
 */
#include "assets/body/internal.h"

#include <string.h>

enum { MAX_JOINTS = 4 };            /* that may move one point */

/* Left joints that a right one follows. */
static const int pairs[] = { BODY_HIP, BODY_KNEE, BODY_ANKLE, BODY_FOOT, BODY_COLLAR, BODY_SHOULDER, BODY_ELBOW,
                             BODY_WRIST, BODY_EYE };

static int other_side(int j)
{
    if (j >= BODY_FINGERS)
        return j < BODY_FINGERS + BODY_HAND_JOINTS ? j + BODY_HAND_JOINTS : j - BODY_HAND_JOINTS;
    for (size_t i = 0; i < LT_COUNT(pairs); i++)
        if (j == pairs[i] || j == pairs[i] + 1)
            return 2 * pairs[i] + 1 - j;
    return j;
}

/* Hands the share of weight on from one joint to the next. */
static void pass(double w[J], int from, int to, double share)
{
    w[to] = w[from] * share;
    w[from] -= w[to];
}

static void along_trunk(const body_skeleton *s, vec3 p, double w[J])
{
    const double y = p.y;

    pass(w, BODY_PELVIS, BODY_SPINE1, smoothstep(-55, 55, y - s->joint[BODY_SPINE1].y));
    pass(w, BODY_SPINE1, BODY_SPINE2, smoothstep(-55, 55, y - s->joint[BODY_SPINE2].y));
    pass(w, BODY_SPINE2, BODY_SPINE3, smoothstep(-50, 50, y - s->joint[BODY_SPINE3].y));
    pass(w, BODY_SPINE3, BODY_NECK, smoothstep(-32, 32, y - s->joint[BODY_NECK].y + 0.35 * p.z + 10) *
                                        smoothstep(-130, -80, -fabs(p.x)));
    pass(w, BODY_NECK, BODY_HEAD, smoothstep(-26, 26, y - s->joint[BODY_HEAD].y + 0.55 * p.z));
    pass(w, BODY_HEAD, BODY_JAW, smoothstep(-5, 9, 1515 - y) * smoothstep(5, 50, p.z));
}

/* From the trunk over the collar to the arm. */
static void along_arm(const body_skeleton *s, vec3 p, double w[J])
{
    const vec3 shoulder = s->joint[BODY_SHOULDER + 1];
    const double out = shoulder.x - p.x, above = p.y - shoulder.y;
    const double collar = smoothstep(-125, -35, out) * smoothstep(-130, -30, above) * (1 - w[BODY_HEAD] - w[BODY_NECK]);
    const double arm = smoothstep(-48, 42, out - 0.25 * above - 6) * smoothstep(-150, -85, above);

    for (int j = 0; j < BODY_COLLAR; j++)
        w[j] *= 1 - collar;
    w[BODY_COLLAR + 1] = collar;
    for (int j = 0; j <= BODY_COLLAR + 1; j++)
        w[j] *= 1 - arm;
    w[BODY_SHOULDER + 1] = arm;
    pass(w, BODY_SHOULDER + 1, BODY_ELBOW + 1, smoothstep(-36, 36, s->joint[BODY_ELBOW + 1].x - p.x));
    pass(w, BODY_ELBOW + 1, BODY_WRIST + 1, smoothstep(-60, 0, s->wrist_cut - p.x));
}

static void along_leg(const body_skeleton *s, vec3 p, double w[J])
{
    const vec3 hip = s->joint[BODY_HIP + 1], knee = s->joint[BODY_KNEE + 1], ankle = s->joint[BODY_ANKLE + 1];
    const vec3 out = unit(vec(-0.35, -0.94, p.z < hip.z ? -0.25 : 0.15));
    const double leg = smoothstep(-62, 62, dot(sub(p, hip), out) + 12) * smoothstep(1010, 950, p.y);
    const double right = smoothstep(-24, 24, -p.x);

    w[BODY_PELVIS] *= 1 - leg;
    w[BODY_SPINE1] *= 1 - leg;
    w[BODY_HIP + 1] = leg * right;
    w[BODY_HIP] = leg * (1 - right);
    pass(w, BODY_HIP + 1, BODY_KNEE + 1, smoothstep(-52, 52, knee.y - p.y));
    pass(w, BODY_KNEE + 1, BODY_ANKLE + 1, smoothstep(-34, 34, ankle.y - p.y + 0.5 * (p.z - ankle.z)));
    pass(w, BODY_ANKLE + 1, BODY_FOOT + 1, smoothstep(-24, 24, p.z - s->joint[BODY_FOOT + 1].z));
}

static void keep_largest(double w[J])
{
    double sum = 0;
    int left = 0;

    for (int j = 0; j < J; j++) {
        w[j] = w[j] > 0.002 ? w[j] : 0;
        left += w[j] > 0;
    }
    for (; left > MAX_JOINTS; left--) {
        int least = -1;

        for (int j = 0; j < J; j++)
            if (w[j] > 0 && (least < 0 || w[j] < w[least]))
                least = j;
        w[least] = 0;
    }
    for (int j = 0; j < J; j++)
        sum += w[j];
    for (int j = 0; j < J; j++)
        w[j] /= sum;
}

/* Of a point of the right half. */
static void weights_at(const body_skeleton *s, vec3 p, double w[J])
{
    memset(w, 0, J * sizeof(*w));
    w[BODY_PELVIS] = 1;
    along_trunk(s, p, w);
    along_arm(s, p, w);
    along_leg(s, p, w);
    keep_largest(w);
}

void body_weights(const body_skeleton *s, const lt_hand_model *hand, body_skin *skin)
{
    for (int v = 0; v < V; v++) {
        const bool left = skin->left[v];
        double w[J] = { 0 };

        if (skin->source[v] == FROM_SKIN)
            weights_at(s, left ? body_mirror(skin->vertex[v]) : skin->vertex[v], w);
        else if (skin->source[v] == FROM_EYE)
            w[BODY_EYE + 1] = 1;
        else
            for (int k = 0; k < LT_HAND_JOINTS; k++)
                w[k ? BODY_FINGERS + BODY_HAND_JOINTS + k - 1 : BODY_WRIST + 1] = hand->weights[skin->row[v]][k];
        for (int j = 0; j < J; j++)
            skin->weight[v][left ? other_side(j) : j] = w[j];
    }
}
