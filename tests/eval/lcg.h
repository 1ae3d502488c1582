/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers that C and scripts/vectors/metrics.py make alike. */
#ifndef TESTS_EVAL_LCG_H
#define TESTS_EVAL_LCG_H

#include <stdint.h>

/* [-1, 1), exact in double */
static inline double lcg(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (*state >> 8) / 8388608.0 - 1.0;
}

#endif
