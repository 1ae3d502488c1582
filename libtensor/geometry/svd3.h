/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Singular values of a 3 x 3 matrix, for alignments.
 */
#ifndef LT_GEOMETRY_SVD3_H
#define LT_GEOMETRY_SVD3_H

#include "libtensor/base/common.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * lt_svd3 - A = U diag(s) V^T
 *
 *   A, U, V   (3, 3) row-major; U and V orthogonal whatever the rank of A, determinants +1 or -1
 *   s         s[0] >= s[1] >= s[2] >= 0
 *
 * One-sided Jacobi: small singular values come out to high relative accuracy, and the same matrix
 * gives the same bits everywhere. When A is not finite, s is not a number and U = V = I.
 */
LT_API void lt_svd3(const double A[9], double U[9], double s[3], double V[9]);

#ifdef __cplusplus
}
#endif
#endif
