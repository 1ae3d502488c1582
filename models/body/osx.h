/* SPDX-License-Identifier: Apache-2.0 */
/*
 * osx: a whole body, hands and face with it, from the picture of one person, as SMPL-X's parameters. OSX in the form
 * without decoders, in four sizes; tiny and s are ours, for a CPU.
 *
 * Input: "image" (B, 3, 256, 192) in [0, 1]. Outputs, places in cells as osx_parts.h says:
 *   "rotation" (B, 53, 3, 3)       SMPL-X's joints but the eyes: pelvis and 21 of the body, 15 of the left hand, 15 of
 *                                  the right one, the jaw
 *   "shape", "expression" (B, 10)   "camera" (B, 3)
 *   "body_place" (B, 25, 3)   "hand_place" (B, 40, 3)   "box_centre", "box_size" (B, 3, 2)
 * Losses: L1 to an input of each output's name but the camera's, all with weight 1, as the paper has them, where the
 * config does not say otherwise; of rotations as matrices, which have no jumps, in place of axis-angles. "volumes",
 * where it has a weight, is volume_loss.h's of the body's places. "hand_place" is compared in columns and rows of the
 * picture.
 * Inputs "body_known" (B, 25), "hand_known" (B, 40), "box_known" (B, 3; of centres): 1 where the picture has it, or 0;
 * "weight" (B). osx_losses.h has the losses of the body that all of it makes.
 *
 * Source: Lin et al. 2023, "One-stage 3D whole-body mesh recovery with component aware transformer";
 * IDEA-Research/OSX main/OSX_WoDecoder.py. Parameters have its names.
 */
#ifndef MODELS_BODY_OSX_H
#define MODELS_BODY_OSX_H

#include "models/body/osx_losses.h"
#include "models/model.h"

extern const model_class osx_class;

/* osx_weights_of - what the config of an osx says of its losses, for osx_skin */
osx_weights osx_weights_of(const model *m);

#endif
