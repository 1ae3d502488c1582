/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where joints and landmarks are, of a stature of 1.70 m. Lengths of limbs and heights are shares of the stature as
 * Drillis and Contini 1966 have them; what is inside the trunk and the head is placed by anatomy.
 */
#include "assets/body/internal.h"

const int body_parent[J] = {
    -1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19, 15, 15, 15,
    20, 25, 26, 20, 28, 29, 20, 31, 32, 20, 34, 35, 20, 37, 38,
    21, 40, 41, 21, 43, 44, 21, 46, 47, 21, 49, 50, 21, 52, 53,
};

const int body_landmark_id[LANDMARKS][2] = {
    { 9120, -1 }, { 616, 6 }, { 8463, 5770 }, { 8474, 5780 }, { 8635, 8846 },
};

static const double S = 1700;

/* The right one and its mirror image. */
static void pair(body_skeleton *s, int left, vec3 right)
{
    s->joint[left + 1] = right;
    s->joint[left] = body_mirror(right);
}

static void place_trunk(body_skeleton *s)
{
    s->joint[BODY_PELVIS] = vec(0, 0.562 * S, -12);
    s->joint[BODY_SPINE1] = vec(0, 0.618 * S, -18);
    s->joint[BODY_SPINE2] = vec(0, 0.690 * S, -16);
    s->joint[BODY_SPINE3] = vec(0, 0.742 * S, -8);
    s->joint[BODY_NECK] = vec(0, 0.853 * S, -24);
    s->joint[BODY_HEAD] = vec(0, 0.900 * S, -6);
    s->joint[BODY_JAW] = vec(0, 0.909 * S, 14);
    pair(s, BODY_COLLAR, vec(-48, 0.814 * S, -14));
}

static void place_limbs(body_skeleton *s)
{
    const vec3 hip = vec(-88, 0.530 * S, -8), shoulder = vec(-174, 0.818 * S, -20);
    const vec3 knee = add(hip, vec(-6, -0.245 * S, 10)), ankle = add(knee, vec(-6, -0.246 * S, -28));
    const vec3 elbow = add(shoulder, vec(-0.186 * S, -2, -4)), wrist = vec(-742, 0.816 * S, -14);

    pair(s, BODY_HIP, hip);
    pair(s, BODY_KNEE, knee);
    pair(s, BODY_ANKLE, ankle);
    pair(s, BODY_FOOT, vec(-112, 26, 92));
    pair(s, BODY_SHOULDER, shoulder);
    pair(s, BODY_ELBOW, elbow);
    pair(s, BODY_WRIST, wrist);
    s->hand = sub(wrist, vec(96, 6, 6));
    s->wrist_cut = -732;
}

void body_skeleton_init(body_skeleton *s)
{
    *s = (body_skeleton){ .eye = { -32, 0.936 * S, 71.5 }, .eye_radius = 15.5 };
    place_trunk(s);
    place_limbs(s);
    pair(s, BODY_EYE, s->eye);
    s->landmark[0] = vec(0, 0.914 * S, 130);            /* nose */
    s->landmark[1] = vec(-88, 0.930 * S, -8);           /* ear */
    s->landmark[2] = vec(-98, 20, 182);                 /* big toe */
    s->landmark[3] = vec(-150, 16, 138);                /* small toe */
    s->landmark[4] = vec(-100, 30, -95);                /* heel */
}
