/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The stages of building the synthetic hand, in order. Private to this folder.
 *
 *   hand_skeleton  joints, radii and bone frames of a profile
 *   hand_shape     the skin as a signed distance: palm, eminences, webs, digits
 *   surface/       its zero set as a mesh of 778 vertices, open at the wrist in a loop of 16
 *   hand_number    the vertex ids that datasets name
 *   hand_weights, hand_betas, hand_regressor, hand_correctives, hand_pose_space  the arrays of the model
 *
 * Lengths are millimetres here, as in the anatomical tables; the model itself is in metres.
 */
#ifndef ASSETS_HAND_INTERNAL_H
#define ASSETS_HAND_INTERNAL_H

#include "assets/hand/hand.h"
#include "assets/surface/surface.h"

enum { DIGIT_INDEX, DIGIT_MIDDLE, DIGIT_LITTLE, DIGIT_RING, DIGIT_THUMB, DIGITS };    /* as the joints */
enum { WRIST_LOOP = 16 };

/* The joint of a digit: k = 0, 1, 2 from base to tip. */
static inline int digit_joint(int digit, int k) { return 1 + 3 * digit + k; }

typedef struct {
    vec3 wrist;
    vec3 joint[DIGITS][4];          /* base, middle, last joint, finger tip on the skin */
    double radius[DIGITS][4];       /* of the flesh around each; the last one is the tip's own */
    vec3 bone[DIGITS][3];           /* unit direction of each phalanx */
    vec3 dorsal[DIGITS]; /* unit, at right angles to the first phalanx: towards the nail */
    vec3 flex[DIGITS];              /* unit axis: turning about it bends the digit */
    double cut_x;                   /* the plane in which the wrist is open */
} hand_skeleton;

void hand_skeleton_init(hand_skeleton *s, synth_hand_profile profile);

/* hand_shape_skin - the skin of s, which must outlive it; its one opening, 1, is the wrist's */
surface_skin hand_shape_skin(const hand_skeleton *s);

/* hand_shape_distance - signed distance to the skin, negative inside; exact near the surface */
double hand_shape_distance(const hand_skeleton *s, vec3 p);

void hand_number(const hand_skeleton *s, surface_mesh *m);

void hand_weights_at(const hand_skeleton *s, vec3 p, double weight[LT_HAND_JOINTS]);

/* The finished surface with what later stages ask of it. */
typedef struct {
    vec3 vertex[LT_HAND_VERTICES];
    double area[LT_HAND_VERTICES];  /* share of the skin; sums to 1 */
    double weight[LT_HAND_VERTICES][LT_HAND_JOINTS];
} hand_rig;

/* How skin and joints move along one shape direction, per unit of beta. */
typedef struct {
    vec3 vertex[LT_HAND_VERTICES], joint[LT_HAND_JOINTS];
} hand_motion;

void hand_betas(const hand_skeleton *s, const hand_rig *rig, hand_motion motion[LT_HAND_BETAS]);
void hand_regressor(const hand_skeleton *s, const hand_rig *rig,
                    const hand_motion motion[LT_HAND_BETAS],
                    float out[LT_HAND_JOINTS][LT_HAND_VERTICES]);
void hand_correctives(const hand_skeleton *s, const hand_rig *rig,
                      float out[LT_HAND_VERTICES][3][LT_HAND_POSE_FEATURES]);

/* hand_pose_space - mean pose and principal directions; needs the model's template and regressor */
lt_status hand_pose_space(lt_arena *arena, lt_hand_model *model);

#endif
