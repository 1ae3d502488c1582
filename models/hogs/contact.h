/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Contact and penetration of a hand and an object that are known as Gaussians.
 *
 * Source: hassony2/obman_train mano_train/networks/branches/contactloss.py; Hasson et al. 2019, "Learning joint
 * reconstruction of hands and manipulated objects", section 4.
 */
#ifndef MODELS_HOGS_CONTACT_H
#define MODELS_HOGS_CONTACT_H

#include "models/hogs/gpm_loss.h"

/* Fingertips, thumb to little, and the palm; CONTACT_NOWHERE: what may be anywhere */
enum { CONTACT_TIPS = 5, CONTACT_PALM = CONTACT_TIPS, CONTACT_ZONES, CONTACT_NOWHERE = -1 };

/* A hand's template in its zero pose, metres */
typedef struct {
    int n;
    const float (*vertex)[3], (*normal)[3];         /* normals outwards, unit length */
    const float (*weight)[SKIN_FIELD_BONES];        /* of the bones, the first one being the palm's */
    int tip[CONTACT_TIPS];                          /* vertices */
    double palm[3];                                 /* where the palm looks */
} contact_template;

/* contact_zones - the zone of each vertex (n): within 15 mm of a tip that of the nearest one; else the palm's,
 * where the palm's bone moves it most and it looks where the palm does */
void contact_zones(const contact_template *t, int32_t *zone);

/* Of B frames. Only the pose gets a gradient. */
typedef struct {
    lt_tensor *hand;                /* (B, N, 3): posed hand points, metres in the camera frame */
    lt_tensor *zone;                /* (B, N), LT_I32: the zone each is in */
    lt_tensor *surface;             /* (B, M, 3): the object's points at its surface, in its own frame */
    lt_tensor *inside;              /* (B, OCCUPANCY_CELLS), LT_U8: occupancy.inside */
    lt_tensor *box;                 /* (B, 6): occupancy.lo, then per_metre */
    hogs_pose pose;                 /* the object's, refined */
} contact_in;

typedef struct {
    lt_tensor *contact;             /* L_cont: of each zone's nearest point, where it is outside of the object */
    lt_tensor *penetration;         /* L_pen: of all points that are inside */
} contact_losses;

/* contact_losses_of - means over those points in the whole batch of tau tanh(distance / tau), tau 10 mm and 20 mm; 0
 * without a point */
contact_losses contact_losses_of(const contact_in *in);

#endif
