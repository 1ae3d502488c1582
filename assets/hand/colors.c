/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What colour the skin is: six tones, a lighter palm, redder pads, darker knuckles, pale nails.
 */
#include "assets/hand/hand.h"
#include "assets/surface/vec3.h"

#include <string.h>

typedef struct { double back[3], palm[3], nail[3]; } skin_tone;         /* sRGB, 0..255 */

static const skin_tone tones[SYNTH_HAND_TONES] = {
    { { 238, 200, 178 }, { 246, 206, 188 }, { 248, 214, 204 } },
    { { 226, 180, 150 }, { 240, 194, 170 }, { 242, 204, 190 } },
    { { 206, 156, 122 }, { 230, 180, 152 }, { 232, 190, 172 } },
    { { 176, 122, 88 }, { 216, 162, 132 }, { 214, 168, 148 } },
    { { 132, 86, 60 }, { 196, 142, 114 }, { 184, 138, 120 } },
    { { 82, 54, 42 }, { 172, 122, 98 }, { 150, 112, 98 } },
};

static vec3 linear(const double srgb[3])
{
    return vec(pow(srgb[0] / 255, 2.2), pow(srgb[1] / 255, 2.2), pow(srgb[2] / 255, 2.2));
}

static vec3 load(const float p[3]) { return vec(p[0], p[1], p[2]); }
static vec3 load3(const double p[3]) { return vec(p[0], p[1], p[2]); }

static void rest_normals(const lt_hand_model *m, vec3 normal[LT_HAND_VERTICES])
{
    memset(normal, 0, LT_HAND_VERTICES * sizeof(*normal));
    for (int f = 0; f < LT_HAND_FACES; f++) {
        const int32_t *c = m->faces[f];
        const vec3 a = load(m->v_template[c[0]]), b = load(m->v_template[c[1]]),
                   d = load(m->v_template[c[2]]);
        const vec3 n = cross(sub(b, a), sub(d, a));

        for (int k = 0; k < 3; k++)
            normal[c[k]] = add(normal[c[k]], n);
    }
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        normal[v] = unit(normal[v]);
}

static vec3 rest_joint(const lt_hand_model *m, int j)
{
    vec3 p = vec(0, 0, 0);

    for (int v = 0; v < LT_HAND_VERTICES; v++)
        p = madd(p, load(m->v_template[v]), m->J_regressor[j][v]);
    return p;
}

typedef struct {
    vec3 joint[LT_HAND_JOINTS], normal[LT_HAND_VERTICES];
    uint8_t part[LT_HAND_VERTICES];
    synth_hand_frames frames;
} anatomy;

/* 1 on the back of the hand or digit, -1 on the palm side; where parts meet, a mean by weight. */
static double backward(const lt_hand_model *m, const anatomy *a, int v)
{
    double sum = m->weights[v][0] * a->normal[v].y;

    for (int j = 1; j < LT_HAND_JOINTS; j++)
        if (m->weights[v][j] > 0)
            sum += m->weights[v][j] * dot(a->normal[v], load3(a->frames.dorsal[j - 1]));
    return sum;
}

/* The palm ends at the crease of the wrist: 1 in the hand, 0 on the forearm. */
static double in_hand(const lt_hand_model *m, const anatomy *a, int v)
{
    const double past = fabs(m->v_template[v][0]) - fabs(a->joint[0].x);
    const bool same_side = m->v_template[v][0] * a->joint[0].x > 0;

    return same_side ? smoothstep(0.006, -0.012, past) : 1;
}

/* How much of the colour at v is nail: the back of a last phalanx, its outer half. */
static double nail(const lt_hand_model *m, const anatomy *a, int v)
{
    const int part = a->part[v];
    double reach;

    if (part == 0 || part % 3)
        return 0;
    reach = dot(sub(load(m->v_template[v]), a->joint[part]), load3(a->frames.bone[part - 1]));
    return smoothstep(0.45, 0.8, backward(m, a, v)) * smoothstep(0.010, 0.014, reach);
}

/* Creases of the back gather over the knuckles. */
static double knuckle(const lt_hand_model *m, const anatomy *a, int v)
{
    double most = 0;

    for (int j = 1; j < LT_HAND_JOINTS; j++) {
        const double q = dist(load(m->v_template[v]), a->joint[j]) / 0.0115;
        most = fmax(most, exp(-q * q * q * q));
    }
    return most * smoothstep(0.2, 0.8, backward(m, a, v));
}

static double finger_pad(const lt_hand_model *m, const anatomy *a, int v)
{
    const int part = a->part[v];
    double reach;

    if (part == 0 || part % 3)
        return 0;
    reach = dot(sub(load(m->v_template[v]), a->joint[part]), load3(a->frames.bone[part - 1]));
    return smoothstep(0.3, -0.3, backward(m, a, v)) * smoothstep(0.004, 0.016, reach);
}

static vec3 shade(const lt_hand_model *m, const anatomy *a, const skin_tone *tone, int v)
{
    const vec3 red = vec(1.04, 0.86, 0.84), dark = vec(0.80, 0.72, 0.70);
    const double k = knuckle(m, a, v), pad = finger_pad(m, a, v);
    const double palm = in_hand(m, a, v) * smoothstep(0.35, -0.5, backward(m, a, v));
    vec3 c = mix(linear(tone->back), linear(tone->palm), palm);

    c = mix(c, vec(c.x * dark.x, c.y * dark.y, c.z * dark.z), 0.6 * k);
    c = mix(c, vec(c.x * red.x, c.y * red.y, c.z * red.z), 0.8 * pad);
    return mix(c, linear(tone->nail), nail(m, a, v));
}

void synth_hand_colors(const lt_hand_model *model, int tone, float color[LT_HAND_VERTICES][3])
{
    const skin_tone *t = &tones[(int)clamp(tone, 0, SYNTH_HAND_TONES - 1)];
    anatomy a;

    rest_normals(model, a.normal);
    synth_hand_parts(model, a.part);
    synth_hand_frames_init(&a.frames, model);
    for (int j = 0; j < LT_HAND_JOINTS; j++)
        a.joint[j] = rest_joint(model, j);
    for (int v = 0; v < LT_HAND_VERTICES; v++) {
        const vec3 c = shade(model, &a, t, v);

        color[v][0] = (float)fmin(c.x, 1);
        color[v][1] = (float)fmin(c.y, 1);
        color[v][2] = (float)fmin(c.z, 1);
    }
}
