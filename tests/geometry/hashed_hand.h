/* SPDX-License-Identifier: Apache-2.0 */
/* The hashed numbers of scripts/vectors/geometry.py, and its hand made of them. */
#ifndef TESTS_GEOMETRY_HASHED_HAND_H
#define TESTS_GEOMETRY_HASHED_HAND_H

#include "libtensor/geometry/hand/model.h"

#include <string.h>

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

/* hand() there */
static inline void hashed_hand(lt_hand_model *h)
{
    static const int joint_step[3] = { 0, 5, 11 }, vertex_step[3] = { 0, 100, 200 };
    static const float share[3] = { .5f, .25f, .25f };

    memset(h, 0, sizeof(*h));
    hashed_floats(1, 1 / 8.f, h->v_template[0], sizeof(h->v_template) / sizeof(float));
    hashed_floats(2, 1 / 256.f, h->shapedirs[0][0], sizeof(h->shapedirs) / sizeof(float));
    hashed_floats(3, 1 / 256.f, h->posedirs[0][0], sizeof(h->posedirs) / sizeof(float));
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < LT_HAND_VERTICES; i++)
            h->weights[i][(i + joint_step[k]) % LT_HAND_JOINTS] += share[k];
        for (int j = 0; j < LT_HAND_JOINTS; j++)
            h->J_regressor[j][(37 * j + vertex_step[k]) % LT_HAND_VERTICES] += share[k];
    }
}

#endif
