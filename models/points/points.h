/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A point backbone that tells shapes apart: PointNet++ and a projection, of two views of each shape, whose embeddings
 * ought to be near each other and far from all others'. HOGS's G-PM begins with its first level.
 *
 * Inputs of B shapes, views 2 i and 2 i + 1 of shape i:
 *   "points" (2 B, P, 3)    in the unit sphere, about
 *   "others" (2 B, 2 B)     added to the similarities: a large negative number for a view and itself, and for views
 *                           that are not there
 *   "weight" (2 B)
 * Output: "embedding" (2 B, 256), of length 1.
 *
 * Source: Qi et al. 2017, "PointNet++"; Chen et al. 2020, "A simple framework for contrastive learning", equation 1.
 */
#ifndef MODELS_POINTS_POINTS_H
#define MODELS_POINTS_POINTS_H

#include "models/model.h"

enum { POINTS_EMBEDDING = 256 };

/* points_view - how many points of a view m looks at: P */
int points_view(const model *m);

extern const model_class points_class;

#endif
