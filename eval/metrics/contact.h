/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How a hand touches an object, and how far it is in it.
 *
 * Inside is where the surface goes around a point, by its winding number: meshes may have parts that overlap. The hand
 * is closed at its wrist. All is measured in the object's own frame.
 *
 * Source: HOGS, section 4; Hasson et al. 2019, section 4.3, whose voxels have 5 mm as well.
 */
#ifndef EVAL_METRICS_CONTACT_H
#define EVAL_METRICS_CONTACT_H

#include "assets/hand/hand.h"
#include "libtensor/base/arena.h"
#include "libtensor/geometry/hand/model.h"
#include "libtensor/geometry/mesh/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* An object made ready: which of the voxels of its box are in it. Read-only: any number of threads may ask. */
typedef struct eval_contact_object eval_contact_object;

/* eval_contact_object_new - in arena; the mesh, in its own frame, is copied. Uses all threads. Errors: those of
 * lt_mesh_index_new; a box of more than 2 m; LT_ENOMEM. */
lt_status eval_contact_object_new(lt_arena *arena, const lt_mesh *mesh, eval_contact_object **out);

typedef struct {
    double penetration_mm;          /* the largest depth below the object's surface of a hand's vertex; 0: none is in */
    double intersection_cm3;        /* of the object's voxels of 5 mm, those whose centres are in the hand as well */
    bool contact;                   /* a vertex of the hand is in the object, or within 4 mm of its surface */
} eval_contact_score;

/**
 * eval_contact - of one frame
 *
 *   R, t    x_cam = R x_object + t; R is orthogonal, and a mirror where the object is (dataset_model_to_camera)
 *   hand    a closed mesh in the camera's axes
 *
 * Errors: LT_EINVAL where a number is not finite; LT_ENOMEM.
 */
lt_status eval_contact(const eval_contact_object *object, const double R[9], const double t[3], const lt_mesh *hand,
                       eval_contact_score *out);

enum { EVAL_CLOSED_HAND_FACES = LT_HAND_FACES + SYNTH_HAND_CAP_FACES };

/* eval_close_hand - the faces of a hand and those that close its wrist, MANO's too */
void eval_close_hand(const lt_hand_model *hand, int32_t face[EVAL_CLOSED_HAND_FACES][3]);

#ifdef __cplusplus
}
#endif
#endif
