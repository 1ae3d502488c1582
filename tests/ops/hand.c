/* SPDX-License-Identifier: Apache-2.0 */
/* hand: both results of the hand layer, against the NumPy formula of scripts/vectors/geometry.py. */
#include "tests/ops/suite.h"

#include <stdlib.h>

/* The numbers of hashed() in that script. */
static float hashed(uint32_t seed, uint32_t i)
{
    uint32_t x = i * 2654435761u + seed;

    x = (x ^ x >> 16) * 0x85EBCA6Bu;
    x = (x ^ x >> 13) * 0xC2B2AE35u;
    x ^= x >> 16;
    return (float)((x >> 16) / 32768.0 - 1);
}

static void fill_model(uint32_t seed, float scale, float *out, size_t n)
{
    for (size_t i = 0; i < n; i++)
        out[i] = scale * hashed(seed, (uint32_t)i);
}

static void share_out(lt_hand_model *hand)
{
    static const int joint_step[3] = { 0, 5, 11 }, vertex_step[3] = { 0, 100, 200 };
    static const float share[3] = { .5f, .25f, .25f };

    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < LT_HAND_VERTICES; i++)
            hand->weights[i][(i + joint_step[k]) % LT_HAND_JOINTS] += share[k];
        for (int j = 0; j < LT_HAND_JOINTS; j++)
            hand->J_regressor[j][(37 * j + vertex_step[k]) % LT_HAND_VERTICES] += share[k];
    }
}

/* Made once, kept for the life of the program. */
static const lt_hand_layer *the_layer(void)
{
    static lt_arena *arena;
    static lt_hand_layer *layer;
    lt_hand_model *hand;

    if (layer)
        return layer;
    arena = lt_arena_new();
    hand = lt_arena_alloc(arena, sizeof(*hand));
    fill_model(1, 1 / 8.f, hand->v_template[0], sizeof(hand->v_template) / sizeof(float));
    fill_model(2, 1 / 256.f, hand->shapedirs[0][0], sizeof(hand->shapedirs) / sizeof(float));
    fill_model(3, 1 / 256.f, hand->posedirs[0][0], sizeof(hand->posedirs) / sizeof(float));
    share_out(hand);
    if (lt_hand_layer_new(arena, hand, lt_hand_tips_ho3d, &layer))
        abort();
    return layer;
}

static lt_tensor *build(lt_tensor **in) { return lt_hand(the_layer(), in[0], in[1]); }
static lt_tensor *vertices(lt_tensor **in) { return lt_scale(lt_hand(the_layer(), in[0], in[1]), 1); }
static lt_tensor *keypoints(lt_tensor **in)
{
    return lt_scale(lt_result(lt_hand(the_layer(), in[0], in[1]), 1), 1);
}

static const op_case cases[] = {
    { "both", build, .in = { S(2, 16, 3, 3), S(2, 10) } },
    { "vertices", vertices, .in = { S(1, 16, 3, 3), S(1, 10) } },
    { "keypoints", keypoints, .in = { S(1, 16, 3, 3), S(1, 10) } },
    { "empty", build, .in = { S(0, 16, 3, 3), S(0, 10) } },
    { "long", build, .in = { S(9, 16, 3, 3), S(9, 10) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(2, 15, 3, 3), S(2, 10) }, "hand: rotations is (2, 15, 3, 3), want (2, 16, 3, 3)" },
    { build, { S(2, 16, 3, 3), S(3, 10) }, "hand: betas is (3, 10), want (2, 10)" },
    { build, { S(2, 48), S(2, 10) }, "hand: rotations is (2, 48), want 4 dimensions" },
};

const op_suite hand_suite = { "hand", CASES(cases), BAD(bad) };
