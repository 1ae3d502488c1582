/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which cells are to find which object: the task-aligned assigner.
 * Source: Feng et al. 2021, "TOOD", section 3.2.
 */
#ifndef MODELS_DETECT_ASSIGN_H
#define MODELS_DETECT_ASSIGN_H

#include "models/detect/cells.h"

/* What a cell is assigned. An object goes to the ten cells with their centres inside its box for which
 * score^0.5 CIoU^6 is largest and above 0; of two for one cell it gets the one that it overlaps more. */
enum { ASSIGNED_OBJECT, ASSIGNED_SCORE, ASSIGNED_ALPHA, ASSIGNED_NUMBERS };

/**
 * detect_assign - what each cell is assigned
 *
 *   maps      box and cls of detect_maps
 *   objects   (B, G, 6): class, or below 0 where there is none; x0 y0 x1 y1 in pixels; whether its mask is known
 *   returns   (B, cells, 3): number of the object or -1; the score that its class should have there: the cell's share
 *             of the object's best times the object's best CIoU; alpha of the cell's CIoU
 *
 * No gradient passes. A class that the maps do not have is no object.
 */
lt_tensor *detect_assign(const detect_maps *maps, lt_tensor *objects);

/* assigned_at - the numbers of cell i in image b */
const lt_real *assigned_at(const lt_tensor *assigned, int64_t b, int64_t i);

#define detect_assign(...) LT_HERE(detect_assign(__VA_ARGS__))

#endif
