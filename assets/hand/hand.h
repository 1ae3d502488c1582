/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The embedded hand: a procedural stand-in with the array shapes, vertex ids and conventions of MANO,
 * so that everything runs where the licensed model is not at hand. It is not MANO and is made from
 * published anatomy alone.
 *
 * All functions but synth_hand_new read nothing but the model, so they serve a user's own MANO as well.
 */
#ifndef ASSETS_HAND_HAND_H
#define ASSETS_HAND_HAND_H

#include "libtensor/base/arena.h"
#include "libtensor/base/rng.h"
#include "libtensor/base/status.h"
#include "libtensor/geometry/hand/model.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    SYNTH_HAND_MANO_LIKE,           /* joint spacing near MANO's zero shape: for transfer to real data */
    SYNTH_HAND_ANATOMICAL,          /* bone lengths of Buryanov and Kotiuk 2010, 66 adults */
} synth_hand_profile;

enum {
    SYNTH_HAND_TONES = 6,
    SYNTH_HAND_WRIST_LOOP = 16,
    SYNTH_HAND_CAP_FACES = 14,
    SYNTH_HAND_CAPSULES = 20,       /* five in the palm, three in each digit */
};

/**
 * synth_hand_new - build the right hand of a profile; the same bits every time
 *
 * Errors: LT_ENOMEM.
 * Source: anatomy from Buryanov and Kotiuk 2010, Int. J. Morphol. 28:755.
 */
lt_status synth_hand_new(lt_arena *arena, synth_hand_profile profile, lt_hand_model **out);

/* synth_hand_mirror - the left hand: mirrored in x, faces turned so that they look outwards */
void synth_hand_mirror(const lt_hand_model *right, lt_hand_model *left);

/* The open wrist: its vertices in order, counter-clockwise for whoever looks at the right hand's cut,
 * and the triangles that close it (for a left hand, swap two corners of each). */
extern const int synth_hand_wrist_loop[SYNTH_HAND_WRIST_LOOP];
extern const int32_t synth_hand_cap[SYNTH_HAND_CAP_FACES][3];

/* synth_hand_parts - the joint that moves each vertex most: 0 palm, 1-3 index, ... as joints are numbered */
void synth_hand_parts(const lt_hand_model *model, uint8_t part[LT_HAND_VERTICES]);

/* ---- poses in the words of anatomy --------------------------------------------------------------- */

/* The three numbers of a joint, radians: flexion bends towards the palm, spread is towards the thumb's
 * side (of the thumb: away from the hand), twist turns about the bone. In that order, outermost first. */
enum { SYNTH_HAND_FLEX, SYNTH_HAND_SPREAD, SYNTH_HAND_TWIST };

/* Axes at rest of the 15 joints of a model, in MANO's order without the wrist. */
typedef struct {
    double dorsal[15][3], bone[15][3], flex[15][3];     /* each triple a right-handed orthonormal frame */
    bool left;
} synth_hand_frames;

void synth_hand_frames_init(synth_hand_frames *frames, const lt_hand_model *model);

/* synth_hand_angles_to_pose, synth_hand_pose_to_angles - between joint angles and the 45 axis-angle
 * numbers of a pose (without mean); inverse to each other while |spread| < 90 degrees */
void synth_hand_angles_to_pose(const synth_hand_frames *frames, double angles[15][3], double pose[45]);
void synth_hand_pose_to_angles(const synth_hand_frames *frames, const double pose[45], double angles[15][3]);

/* Least and greatest angle of each joint, radians. */
typedef struct { double lo[3], hi[3]; } synth_hand_limit;
extern const synth_hand_limit synth_hand_limits[15];

/* synth_hand_clamp_angles - into the limits; the spread that a bent knuckle allows shrinks to none at 90
 * degrees, and a last finger joint follows the one before it: two thirds, give or take 10 degrees */
void synth_hand_clamp_angles(double angles[15][3]);

/**
 * synth_hand_draw_angles - a plausible grasp, from open hand to fist: joint angles within the limits
 *
 * Fingers close together more or less, the thumb opposes, all with variation of their own. Self-contact
 * is not looked at: see synth_hand_self_depth.
 */
void synth_hand_draw_angles(lt_rng *rng, double angles[15][3]);

/* ---- the hand as capsules ------------------------------------------------------------------------ */

typedef struct {
    double a[3], b[3];              /* ends, metres */
    double radius_a, radius_b;
    int joint;                      /* that it moves with; 0: palm */
} synth_hand_capsule;

/* synth_hand_capsules - the flesh of a posed hand; keypoints (21, 3) in MANO order */
void synth_hand_capsules(const double keypoints[LT_HAND_KEYPOINTS][3],
                         synth_hand_capsule capsule[SYNTH_HAND_CAPSULES]);

/* synth_hand_capsule_distance - signed, metres; negative inside */
double synth_hand_capsule_distance(const synth_hand_capsule *capsule, const double p[3]);

/**
 * synth_hand_self_depth - how deep the skin reaches into another part of the hand, metres; 0 when nowhere
 *
 *   part (778)          of synth_hand_parts
 *   vertices (778, 3)   posed
 *   keypoints (21, 3)   of the same pose, MANO order
 *
 * Neighbouring parts, which touch at their joint, are not counted.
 */
double synth_hand_self_depth(const uint8_t part[LT_HAND_VERTICES], const double vertices[LT_HAND_VERTICES][3],
                             const double keypoints[LT_HAND_KEYPOINTS][3]);

/* ---- skin ---------------------------------------------------------------------------------------- */

/**
 * synth_hand_colors - albedo of each vertex, linear RGB 0..1
 *
 *   tone   0 (lightest) .. SYNTH_HAND_TONES - 1
 *
 * The palm is lighter than the back, finger pads are redder, knuckles darker, nails pale.
 */
void synth_hand_colors(const lt_hand_model *model, int tone, float color[LT_HAND_VERTICES][3]);

#ifdef __cplusplus
}
#endif
#endif
