/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers in order, and the one in the middle. */
#ifndef LT_BASE_ORDER_H
#define LT_BASE_ORDER_H

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

/* lt_ascending - of two doubles; NaN comes last, so that what is before it is in order */
static inline int lt_ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    if (isnan(x) || isnan(y))
        return isnan(x) - isnan(y);
    return (x > y) - (x < y);
}

/* lt_median - the median of d[n], of the two middle ones their mean; sorts d; NaN for n = 0 */
static inline double lt_median(int64_t n, double *d)
{
    if (n <= 0)
        return NAN;
    qsort(d, (size_t)n, sizeof(*d), lt_ascending);
    return n % 2 ? d[n / 2] : 0.5 * (d[n / 2 - 1] + d[n / 2]);
}

#endif
