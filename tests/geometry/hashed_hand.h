/* SPDX-License-Identifier: Apache-2.0 */
/* The hand of scripts/vectors/geometry.py. */
#ifndef TESTS_GEOMETRY_HASHED_HAND_H
#define TESTS_GEOMETRY_HASHED_HAND_H

#include "libtensor/geometry/hand/model.h"

#include "tests/geometry/hashed.h"

#include <string.h>

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
