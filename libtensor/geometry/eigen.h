/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: eigenvalues and eigenvectors of symmetric matrices, with the same bits on every machine.
 */
#ifndef LT_GEOMETRY_EIGEN_H
#define LT_GEOMETRY_EIGEN_H

#include "libtensor/base/common.h"

/**
 * lt_eigen_symmetric - by Jacobi's cyclic method
 *
 *   A    (n, n) symmetric, finite; its diagonal becomes the eigenvalues, in no order, and the rest next to nothing
 *   V    (n, n) row i is the unit eigenvector of A[i][i]
 */
void lt_eigen_symmetric(int n, double *A, double *V);

enum { LT_EIGEN_MAX = 12 };

/* lt_eigen_small - A (n, n) symmetric becomes its eigenvectors, row by row, eigenvalues w ascending; n <=
 * LT_EIGEN_MAX */
void lt_eigen_small(int n, double *A, double *w);

#endif
