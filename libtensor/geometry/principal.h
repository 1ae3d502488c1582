/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: the principal axes of a point set.
 */
#ifndef LT_GEOMETRY_PRINCIPAL_H
#define LT_GEOMETRY_PRINCIPAL_H

#include "libtensor/base/common.h"

typedef struct {
    double centre[3];
    double axis[3][3];          /* unit, orthogonal, of either hand; by descending spread */
    double spread[3];           /* standard deviation along each, metres */
} lt_principal;

/* lt_principal_of - of n >= 1 points (n, 3), finite */
void lt_principal_of(int n, const double *X, lt_principal *out);

#endif
