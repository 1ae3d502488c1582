/* SPDX-License-Identifier: Apache-2.0 */
/* The time that passes, whatever the day's clock is set to. */
#ifndef LT_BASE_CLOCK_H
#define LT_BASE_CLOCK_H

#include <time.h>

/* lt_clock - seconds since some moment, never going back */
static inline double lt_clock(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

#endif
