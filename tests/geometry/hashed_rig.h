/* SPDX-License-Identifier: Apache-2.0 */
/* rig() of scripts/vectors/geometry.py: a rig of any size, made of hashed numbers. */
#ifndef TESTS_GEOMETRY_HASHED_RIG_H
#define TESTS_GEOMETRY_HASHED_RIG_H

#include "libtensor/base/arena.h"
#include "libtensor/geometry/skin/rig.h"

#include "tests/geometry/hashed.h"

static inline float *hashed_array(lt_arena *arena, uint32_t seed, float scale, size_t n)
{
    float *x = lt_arena_array(arena, n, sizeof(*x));

    hashed_floats(seed, scale, x, n);
    return x;
}

/* Each vertex hangs on four joints, each joint stands between three vertices. */
static inline lt_rig hashed_rig(lt_arena *arena, int V, int J, int S)
{
    static const float joint_share[4] = { .5f, .25f, .125f, .125f }, vertex_share[3] = { .5f, .25f, .25f };
    static const int vertex_step[3] = { 0, 100, 200 };
    const size_t v = (size_t)V, j = (size_t)J;
    int *parents = lt_arena_array(arena, j, sizeof(*parents));
    float *regressor = lt_arena_array(arena, j * v, sizeof(*regressor));
    float *weights = lt_arena_array(arena, v * j, sizeof(*weights));

    for (int i = 0; i < J; i++) {
        parents[i] = i ? (2 * i - 1) / 3 : -1;
        for (int k = 0; k < 3; k++)
            regressor[i * V + (37 * i + vertex_step[k]) % V] += vertex_share[k];
    }
    for (int i = 0; i < V; i++)
        for (int k = 0; k < 4; k++)
            weights[i * J + (i / 8 + k * k) % J] += joint_share[k];
    return (lt_rig){
        .V = V, .J = J, .S = S, .parents = parents, .J_regressor = regressor, .weights = weights,
        .v_template = hashed_array(arena, 1, 1 / 8.f, 3 * v),
        .shapedirs = hashed_array(arena, 2, 1 / 256.f, 3 * v * (size_t)S),
        .posedirs = hashed_array(arena, 3, 1 / 256.f, 27 * v * (j - 1)),
    };
}

#endif
