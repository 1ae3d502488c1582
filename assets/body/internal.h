/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The stages of building the synthetic body, in order. Private to this folder.
 *
 *   skeleton   where joints and landmarks are
 *   shape      the skin as a signed distance: head, trunk, limbs
 *   half       its right half as a mesh, open at the middle, the wrist and the eye
 *   skin       both halves, hands and eyes in one, with the vertex ids that others expect
 *   weights, shapes, expressions, correctives, regressor   the arrays of the model
 *
 * The right half is designed, at x < 0; the left one is its mirror image. Lengths are millimetres here, heights are
 * from the floor.
 */
#ifndef ASSETS_BODY_INTERNAL_H
#define ASSETS_BODY_INTERNAL_H

#include "assets/body/body.h"
#include "assets/surface/surface.h"

enum { V = BODY_VERTICES, F = BODY_FACES, J = BODY_JOINTS, HAND = LT_HAND_VERTICES };
enum { RIM_MIDDLE = 1, RIM_WRIST, RIM_EYE };
enum { MIDDLE_EDGES = 181, WRIST_EDGES = 16, EYE_EDGES = 17 };
enum { EYE_RINGS = 16, EYE_AROUND = 34, EYE_VERTICES = 2 + EYE_RINGS * EYE_AROUND };

/* Half of what neither hand nor eye has; the wrist's rim is the hand's, the middle's is shared. */
enum { HALF_VERTICES = (V - 2 * (HAND - WRIST_EDGES + EYE_VERTICES) + MIDDLE_EDGES) / 2 };

enum { LANDMARKS = 5 };             /* of a half, in the order of body_landmark_id */

typedef struct {
    vec3 joint[J];                  /* those of the fingers are the hand's */
    vec3 landmark[LANDMARKS];       /* near the skin: nose, ear, big toe, small toe, heel */
    vec3 eye;                       /* centre of the right one */
    double eye_radius;
    vec3 hand;                      /* x_body = x_hand + hand, of the right hand */
    double wrist_cut;               /* the plane in which the right hand begins */
} body_skeleton;

/* of each landmark: right, left; the nose has the right one alone */
extern const int body_landmark_id[LANDMARKS][2];
extern const int body_parent[J];

void body_skeleton_init(body_skeleton *s);

/* body_shape_skin - the skin of s, which must outlive it */
surface_skin body_shape_skin(const body_skeleton *s);
bool body_shape_in_eye(const void *skeleton, vec3 p);       /* in the opening of the right eye */

/* body_half - HALF_VERTICES; those of RIM_WRIST are where the hand has them. wrist[i]: vertex i of the hand's loop */
lt_status body_half(lt_arena *arena, const body_skeleton *s, const lt_hand_model *hand, surface_mesh *m,
                    int wrist[WRIST_EDGES]);

typedef enum { FROM_SKIN, FROM_HAND, FROM_EYE } body_source;

/* The whole skin. */
typedef struct {
    vec3 vertex[V];
    int32_t face[F][3];
    uint8_t source[V];
    int16_t row[V];                 /* of a hand's vertex: in the hand */
    bool left[V];
    int32_t hand[2][HAND];          /* left, right */
    double weight[V][J];
} body_skin;

/* body_skin_join - half is changed: landmarks get a vertex each */
lt_status body_skin_join(lt_arena *arena, const body_skeleton *s, surface_mesh *half, const int wrist[WRIST_EDGES],
                         const lt_hand_model *hand, body_skin *out);

void body_weights(const body_skeleton *s, const lt_hand_model *hand, body_skin *skin);

/* How skin and joints move along one direction, per unit. */
typedef struct { vec3 vertex[V], joint[J]; } body_motion;

void body_shapes(const body_skeleton *s, const body_skin *skin, body_motion motion[BODY_SHAPES]);
void body_expressions(const body_skin *skin, body_motion motion[BODY_EXPRESSIONS]);
void body_regressor(const body_skeleton *s, const body_skin *skin, const lt_hand_model *hand,
                    const body_motion motion[BODY_SHAPES], float *out);
void body_correctives(const body_skeleton *s, const body_skin *skin, const lt_hand_model *hand, float *out);

/* body_mirror - the same on the other side */
static inline vec3 body_mirror(vec3 p) { return vec(-p.x, p.y, p.z); }

#endif
