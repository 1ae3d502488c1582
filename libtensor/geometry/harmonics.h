/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Real spherical harmonics, as Gaussians that are seen from a direction have them.
 */
#ifndef LT_GEOMETRY_HARMONICS_H
#define LT_GEOMETRY_HARMONICS_H

/* The constant basis function, 1 / (2 sqrt(pi)): a colour is 1/2 + LT_SH_C0 times its first coefficient. */
#define LT_SH_C0 0.28209479177387814

#endif
