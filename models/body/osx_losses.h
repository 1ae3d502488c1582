/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What OSX is trained by beside the truth of each of its outputs: the body that they make, in space and in the picture.
 *
 * Source: Lin et al. 2023, section 3.5; IDEA-Research/OSX main/OSX_WoDecoder.py. All its terms are L1 and weigh 1.
 */
#ifndef MODELS_BODY_OSX_LOSSES_H
#define MODELS_BODY_OSX_LOSSES_H

#include "libtensor/geometry/skin/skin.h"
#include "models/model.h"

enum { OSX_NODES = 65, OSX_RIG_JOINTS = 55 };

static const double OSX_FOCAL = 5000;           /* pixels, of the virtual camera; its centre is the picture's */

/* What losses weigh, where it is not 1. volumes: of the cross-entropy of the body's volumes, which OSX has not. */
typedef struct { double rotation, nodes, volumes; } osx_weights;

/* osx_loss_add - one more loss, a number that is already a mean, times its weight */
void osx_loss_add(model_record *r, const char *name, lt_tensor *loss, double weight);

/* osx_l1 - the mean of |a - b|, samples weighed by the input "weight"; known (B, N), 0 or 1: which of dimension 1
 * count, or NULL */
lt_tensor *osx_l1(const model_record *r, lt_tensor *a, lt_tensor *b, lt_tensor *known);

/**
 * osx_skin - pose a body by what an osx has recorded: the outputs "vertices" (B, V, 3) and "nodes" (B, OSX_NODES, 3),
 * from the pelvis, metres
 *
 *   body     OSX_RIG_JOINTS joints, 10 + 10 directions of shape and expression, OSX_NODES points; outlives the plans
 *   weights  of losses; NULL: without any. record has its own already; two are added: "nodes", and "bearing" of the
 *            nodes as the virtual camera sees them, with inputs of these names, (B, OSX_NODES, 3) and, of osx_bearing,
 *            (B, OSX_NODES, 2), and "node_known" (B, OSX_NODES) for the latter
 */
void osx_skin(const lt_skin_layer *body, const osx_weights *weights, model_record *r);

/* osx_bearing - where the virtual camera sees a point (x, y, z): x and y of its direction times the focal length, in
 * cells of the encoder's map. It is the place from the picture's centre to 0.2 %, and has a gradient wherever the point
 * is. */
void osx_bearing(const double point[3], double out[2]);

#endif
