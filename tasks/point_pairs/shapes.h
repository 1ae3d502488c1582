/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shapes to tell apart, drawn from random numbers, and partial views of them as points.
 */
#ifndef TASKS_POINT_PAIRS_SHAPES_H
#define TASKS_POINT_PAIRS_SHAPES_H

#include "libtensor/base/arena.h"
#include "libtensor/base/rng.h"
#include "libtensor/geometry/mesh/mesh.h"

/* shape_draw - a shape of one to three parts: balls, boxes, cans, bottles and rings, stretched, tapered and bent. In
 * arena. LT_ENOMEM. */
lt_status shape_draw(lt_arena *arena, lt_rng *rng, lt_mesh *out);

/**
 * shape_view - n points (n, 3) of a mesh, as one view has them
 *
 * Uniform over the area and brought into the unit sphere; then up to half of them cut off by a plane, and what is left
 * turned at random, scaled by 0.8 to 1.25 and moved by 0.01 each.
 *
 * Errors: a mesh without area; LT_ENOMEM.
 */
lt_status shape_view(lt_arena *scratch, const lt_mesh *mesh, lt_rng *rng, int n, lt_real (*out)[3]);

#endif
