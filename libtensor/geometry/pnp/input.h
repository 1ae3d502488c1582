/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: what all PnP solvers ask of their input.
 */
#ifndef LT_GEOMETRY_PNP_INPUT_H
#define LT_GEOMETRY_PNP_INPUT_H

#include "libtensor/geometry/pnp/pnp.h"

/* Spread across over the longest one, under which points count as flat (a plane, a line): above the rounding
 * of coordinates kept in float, below the thinnest thing one would hold. */
#define LT_PNP_FLAT 1e-5

/* lt_pnp_check - LT_EINVAL, naming `who`, unless n >= least and all numbers are finite */
lt_status lt_pnp_check(const char *who, const lt_camera *cam, int n, int least, const double *X,
                       const double *uv);

#endif
