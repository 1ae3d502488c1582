/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: linear equations in the 6 unknowns of a rigid motion.
 */
#ifndef LT_GEOMETRY_SOLVE6_H
#define LT_GEOMETRY_SOLVE6_H

#include <stdbool.h>

/* lt_cholesky6 - S = L L^T, L in place of S's lower triangle, which alone is read; false, and S of no use, where S is
 * not positive definite */
bool lt_cholesky6(double S[6][6]);

/* lt_solve6 - b = S^-1 b, with the L that lt_cholesky6 made of S */
void lt_solve6(double L[6][6], double b[6]);

#endif
