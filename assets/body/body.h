/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The synthetic body: a procedural stand-in with the array shapes, vertex ids and conventions of SMPL-X, with the
 * embedded hands at its wrists, so that everything runs where the licensed model is not at hand. It is not SMPL-X and
 * is made from published proportions alone.
 *
 * Axes: x to its left, y up, z forward; arms out; the pelvis at the origin. Metres.
 */
#ifndef ASSETS_BODY_BODY_H
#define ASSETS_BODY_BODY_H

#include "assets/body_file.h"
#include "libtensor/geometry/hand/model.h"
#include "libtensor/geometry/skin/rig.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Joints by name; a right one follows its left one, but for the fingers'. */
enum {
    BODY_PELVIS, BODY_HIP, BODY_SPINE1 = 3, BODY_KNEE, BODY_SPINE2 = 6, BODY_ANKLE, BODY_SPINE3 = 9, BODY_FOOT,
    BODY_NECK = 12, BODY_COLLAR, BODY_HEAD = 15, BODY_SHOULDER, BODY_ELBOW = 18, BODY_WRIST = 20, BODY_JAW = 22,
    BODY_EYE, BODY_FINGERS = 25, BODY_HAND_JOINTS = 15,     /* of the left hand; the right one's follow */
};

enum { BODY_SHAPES = 10, BODY_EXPRESSIONS = 10, BODY_DIRECTIONS = BODY_SHAPES + BODY_EXPRESSIONS, BODY_NODES = 65 };

typedef struct {
    body_model *model;
    int32_t hand[2][LT_HAND_VERTICES];          /* rows of the left and the right hand, in the order of a hand model */
} synth_body;

/**
 * synth_body_new - build it around a right hand (its mirror image is the left one); the same bits every time
 *
 *   out      its arrays live in the arena
 *
 * Directions of shape, per standard deviation: stature, girth, trunk against legs, breadth of shoulders, of hips,
 * length of arms, thickness of limbs, depth of the chest, neck and head, feet. Hands stay as they are. Expressions: jaw
 * drops, smile, frown, brows up, brows together, lips pursed, mouth to the left, nose up, cheeks out, lids up.
 *
 * Errors: LT_ENOMEM.
 * Source: proportions of Drillis and Contini 1966, "Body segment parameters".
 */
lt_status synth_body_new(lt_arena *arena, const lt_hand_model *hand, synth_body *out);

/* synth_body_rig - the body as a rig; a file's too */
lt_rig synth_body_rig(const body_model *m);

/**
 * synth_body_nodes_rig - a rig of the nodes alone, in the arena: it poses them as synth_body_rig poses the body's
 *
 *   points   where the nodes are in it: below BODY_JOINTS a joint, else vertex point - BODY_JOINTS
 *
 * m has BODY_SHAPES and BODY_EXPRESSIONS directions, and outlives it. Errors: LT_ENOMEM.
 */
lt_status synth_body_nodes_rig(lt_arena *arena, const body_model *m, lt_rig *out, int points[BODY_NODES]);

/* Least and greatest turn of a joint about x, y and z of the body at rest, radians; fingers: synth_hand_limits. The
 * angles of a joint are those of R = Ry Rx Rz: y, the arm's or the neck's turn in the plane, comes last. */
typedef struct { double lo[3], hi[3]; } synth_body_limit;
extern const synth_body_limit synth_body_limits[BODY_FINGERS];

/* synth_body_rotation - R of such angles; synth_body_angles - back, |x| < 90 degrees; synth_body_within - whether R is
 * a turn that the joint allows, to 1e-5 */
void synth_body_rotation(const double angle[3], double R[9]);
void synth_body_angles(const double R[9], double angle[3]);
bool synth_body_within(int joint, const double R[9]);

/* Where the 65 nodes are: below BODY_JOINTS a joint, else vertex node - BODY_JOINTS. The order is data/action's: 25 of
 * the body, 20 of each hand, left first. Source: IDEA-Research/OSX common/utils/human_models.py. */
extern const int body_node[BODY_NODES];

/* body_nodes - of a posed body */
void body_nodes(const double *vertices, const double *joints, double out[BODY_NODES][3]);

#ifdef __cplusplus
}
#endif
#endif
