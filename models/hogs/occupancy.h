/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is inside an object that is known as Gaussians alone: a grid of cells over its canonical box. Cells with enough
 * opacity are its shell; whatever cannot be reached from outside without crossing that is inside.
 */
#ifndef MODELS_HOGS_OCCUPANCY_H
#define MODELS_HOGS_OCCUPANCY_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

enum { OCCUPANCY_SIDE = 64, OCCUPANCY_CELLS = OCCUPANCY_SIDE * OCCUPANCY_SIDE * OCCUPANCY_SIDE };

/* Cell (z, y, x) begins at lo + (x, y, z) / per_metre. In graphs inside is an input of LT_U8 and box one of six
 * numbers. */
typedef struct {
    lt_real lo[3], per_metre[3];
    uint8_t inside[OCCUPANCY_CELLS];
} occupancy;

/* Canonical Gaussians: centres in metres, axes M whose M M^T is the covariance, row by row, opacities 0 to 1 */
typedef struct {
    int64_t n;
    const lt_real (*centre)[3], (*axes)[9], *opacity;
} occupancy_gaussians;

/**
 * occupancy_build - the grid of an object, whose canonical box lo .. hi is padded by a twentieth of each extent
 *
 * A cell is shell where the sum over Gaussians of opacity exp(-m / 2), m the squared Mahalanobis distance of its
 * middle, is above a half; beyond four deviations a Gaussian counts as nothing, and one without a volume everywhere.
 * Errors: LT_EINVAL for a box without a volume; LT_ENOMEM.
 */
lt_status occupancy_build(const occupancy_gaussians *g, const double lo[3], const double hi[3], occupancy *out);

/* occupancy_inside - of a place in the object's frame; false outside of the grid */
bool occupancy_inside(const occupancy *o, const lt_real place[3]);

/* occupancy_surface - the Gaussians at the border of what is inside, which it is within one cell of, with an
 * opacity above a half: their numbers, ascending, into index (n); returns how many there are */
int64_t occupancy_surface(const occupancy *o, const occupancy_gaussians *g, int32_t *index);

#endif
