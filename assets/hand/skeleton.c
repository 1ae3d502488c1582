/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The bones of the synthetic hand: where joints are at rest, how thick the flesh is, which way digits
 * bend. Lengths in millimetres.
 */
#include "assets/hand/internal.h"

#define DEG (M_PI / 180)

typedef struct {
    vec3 base;                      /* from the wrist to the first joint: direction only */
    double base_mm;
    double bone_mm[3];              /* first phalanx, second, last joint to tip */
    double fan_deg;                 /* towards the thumb */
    double droop_deg[3];            /* towards the palm */
    double radius_mm[4];
} digit_design;

/* Rounded joint spacing of a flat hand of mean shape, as a scan of a hand laid flat has it. */
static const digit_design mano_like[DIGITS] = {
    [DIGIT_INDEX]  = { { -88.7, 4, 20 }, 91, { 33, 22, 23 }, 7, { 1, 3, 4 }, { 10.0, 8.8, 7.8, 6.8 } },
    [DIGIT_MIDDLE] = { { -94.8, 5, -3 }, 95, { 32, 23, 25 }, 0.5, { 1, 3, 4 }, { 10.2, 9.0, 8.0, 7.0 } },
    [DIGIT_RING]   = { { -82.8, 3, -23 }, 86, { 29, 25, 24 }, -7, { 1, 3, 4 }, { 9.6, 8.4, 7.5, 6.6 } },
    [DIGIT_LITTLE] = { { -70.4, -2, -42 }, 82, { 21, 19, 21.5 }, -15, { 1, 3, 4 }, { 8.6, 7.4, 6.6, 5.9 } },
    [DIGIT_THUMB]  = { { -25, -12, 26 }, 39, { 31, 27, 26 }, 0, { 0, 0, 0 }, { 14, 11, 9.5, 8.5 } },
};

/* Buryanov and Kotiuk 2010: metacarpal plus 27 mm of carpus; distal phalanx plus soft tip. */
static const digit_design anatomical[DIGITS] = {
    [DIGIT_INDEX]  = { { -88.7, 4, 20 }, 93, { 39.8, 22.4, 19.6 }, 7, { 1, 3, 4 }, { 10.0, 8.8, 7.8, 6.8 } },
    [DIGIT_MIDDLE] = { { -94.8, 5, -3 }, 91.6, { 44.6, 26.3, 21.4 }, 0.5, { 1, 3, 4 }, { 10.2, 9.0, 8.0, 7.0 } },
    [DIGIT_RING]   = { { -82.8, 3, -23 }, 84, { 41.4, 25.7, 21.3 }, -7, { 1, 3, 4 }, { 9.6, 8.4, 7.5, 6.6 } },
    [DIGIT_LITTLE] = { { -70.4, -2, -42 }, 78, { 32.7, 18.1, 19.7 }, -15, { 1, 3, 4 }, { 8.6, 7.4, 6.6, 5.9 } },
    [DIGIT_THUMB]  = { { -20, -12, 22 }, 32, { 46.2, 31.6, 27.4 }, 0, { 0, 0, 0 }, { 14, 11, 9.5, 8.5 } },
};

static const vec3 thumb_bone[3] = { { -0.72, -0.16, 0.67 },
                                    { -0.82, -0.08, 0.57 },
                                    { -0.87, -0.04, 0.49 } };
static const vec3 thumb_dorsal = { 0.35, 0.35, 0.8 };

static void place_bones(hand_skeleton *s, int digit, const digit_design *d)
{
    double droop = 0;

    for (int k = 0; k < 3; k++) {
        droop += d->droop_deg[k] * DEG;
        s->bone[digit][k] = digit == DIGIT_THUMB ? unit(thumb_bone[k])
            : turn(turn(vec(-1, 0, 0), vec(0, 0, 1), droop), vec(0, 1, 0), d->fan_deg * DEG);
        s->joint[digit][k + 1] = madd(s->joint[digit][k], s->bone[digit][k], d->bone_mm[k]);
    }
}

void hand_skeleton_init(hand_skeleton *s, synth_hand_profile profile)
{
    const digit_design *design = profile == SYNTH_HAND_ANATOMICAL ? anatomical : mano_like;

    *s = (hand_skeleton){ .wrist = { 96, 6, 6 }, .cut_x = 106 };
    for (int d = 0; d < DIGITS; d++) {
        const vec3 up = d == DIGIT_THUMB ? thumb_dorsal : vec(0, 1, 0);

        s->joint[d][0] = madd(s->wrist, unit(design[d].base), design[d].base_mm);
        place_bones(s, d, &design[d]);
        s->dorsal[d] = unit(reject(up, s->bone[d][0]));
        s->flex[d] = cross(s->dorsal[d], s->bone[d][0]);
        for (int k = 0; k < 4; k++)
            s->radius[d][k] = design[d].radius_mm[k];
    }
}
