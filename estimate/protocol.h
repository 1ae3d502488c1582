/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a paper does around its network: the crop it cuts before, and how votes become a pose after. The network itself
 * is a graph and its parameters (models/model.h).
 */
#ifndef ESTIMATE_PROTOCOL_H
#define ESTIMATE_PROTOCOL_H

#include "data/hand_object.h"
#include "models/model.h"

/* How the object's pose is found from where its control points are seen. */
typedef enum {
    POSE_OPENCV,                    /* in the crop's pixels, as OpenCV's solvePnPRansac does it by default */
    POSE_REFINED,                   /* in the image's pixels, with the guards and the refinement of lt_pnp_refined */
} protocol_pose;

typedef struct {
    const char *model;              /* model_class.name */
    hand_object_crop crop;
    protocol_pose pose;
} protocol;

/* protocol_of - the model's; one that has none of its own is used as HOCAT is */
const protocol *protocol_of(const model *m);

#endif
