/* SPDX-License-Identifier: Apache-2.0 */
/* The hashed numbers of scripts/vectors/geometry.py. */
#ifndef TESTS_GEOMETRY_HASHED_H
#define TESTS_GEOMETRY_HASHED_H

#include <stddef.h>
#include <stdint.h>

/* hashed() there: number i of a seed, in [-1, 1) */
static inline double hashed(uint32_t seed, uint32_t i)
{
    uint32_t x = i * 2654435761u + seed;

    x = (x ^ x >> 16) * 0x85EBCA6Bu;
    x = (x ^ x >> 13) * 0xC2B2AE35u;
    x ^= x >> 16;
    return (x >> 16) / 32768.0 - 1;
}

static inline void hashed_floats(uint32_t seed, float scale, float *out, size_t n)
{
    for (size_t i = 0; i < n; i++)
        out[i] = scale * (float)hashed(seed, (uint32_t)i);
}

#endif
