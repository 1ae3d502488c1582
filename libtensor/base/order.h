/* SPDX-License-Identifier: Apache-2.0 */
/* How qsort is to order numbers. */
#ifndef LT_BASE_ORDER_H
#define LT_BASE_ORDER_H

#include <math.h>

/* lt_ascending - of two doubles; NaN comes last, so that what is before it is in order */
static inline int lt_ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    if (isnan(x) || isnan(y))
        return isnan(x) - isnan(y);
    return (x > y) - (x < y);
}

#endif
