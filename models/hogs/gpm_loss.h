/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What G-PM's offsets do to a pose, and its losses against a true one.                                  [Eq. 18 to 24]
 */
#ifndef MODELS_HOGS_GPM_LOSS_H
#define MODELS_HOGS_GPM_LOSS_H

#include "models/hogs/gpm.h"

/* An object's pose: x_cam = R x_obj + t; of B frames (B, 3, 3), (B, 3) */
typedef struct {
    lt_tensor *R, *t;
} hogs_pose;

/* hogs_posed - points (B, N, 3) of the object's frame in that of the camera */
lt_tensor *hogs_posed(lt_tensor *points, const hogs_pose *pose);

/* gpm_refined - the initial pose with G-PM's mean offsets added: R is no rotation yet, and becomes one by
 * lt_nearest_rotation(R, initial->R) */
hogs_pose gpm_refined(const hogs_pose *initial, const gpm_out *offsets);

/* What is known of a training frame */
typedef struct {
    hogs_pose initial, truth;
    lt_tensor *translation;         /* (B, 3): the Delta T to be found, each translation from its own hand's root */
    lt_tensor *corners;             /* (B, 8, 3): of the object's canonical box */
    lt_tensor *weight;              /* (B), 0 where a frame has no true pose; NULL: all have one */
} gpm_truth;

typedef struct {
    lt_tensor *rotation, *translation;      /* smooth L1, metres, of every token behind every layer */
    lt_tensor *corner;                      /* of the box under the mean offsets */
    lt_tensor *pose;                        /* 10 rotation + 1e4 translation + 1e3 corner */
} gpm_losses;

gpm_losses gpm_pose_losses(const gpm_out *offsets, const gpm_truth *truth);

#endif
