/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The learnable skinning field: how much each bone moves a place of the canonical hand. Each subject has its own.
 *
 * Source: mikeqzy/3dgs-avatar-release models/deformer/rigid.py (skinning field).
 */
#ifndef MODELS_HOGS_SKIN_FIELD_H
#define MODELS_HOGS_SKIN_FIELD_H

#include "models/hogs/set_mlp.h"

enum { SKIN_FIELD_BONES = 16 };

/* A set's canonical box, as inputs (3) each: places become (place - centre) * inverse, -1 to 1 inside */
typedef struct {
    lt_tensor *centre, *inverse;    /* inverse: 1 / half of the extent */
} hogs_box;

/* hogs_in_box - places (N, 3) in metres, in the box's units */
lt_tensor *hogs_in_box(const hogs_box *box, lt_tensor *places);

typedef struct {
    set_mlp mlp;                    /* 3 - width x 4 - 16 */
} skin_field;

/* skin_field_new - width: of the hidden layers; 128 in the paper */
void skin_field_new(skin_field *m, lt_params *set, const char *prefix, int sets, int width);
void skin_field_init(const skin_field *m, uint64_t seed);

/* skin_field_forward - places (N, 3) in the box's units -> weights (N, 16) that sum to 1, of the set in which (1) */
lt_tensor *skin_field_forward(const skin_field *m, lt_tensor *places, lt_tensor *which);

/* skin_field_loss - L_skin: the mean over samples of the sum over bones of the squared difference from weights that are
 * known; both (N, 16) */
lt_tensor *skin_field_loss(lt_tensor *weights, lt_tensor *target);

#endif
