/* SPDX-License-Identifier: Apache-2.0 */
/* hand: both results of the hand layer, against the NumPy formula of scripts/vectors/geometry.py. */
#include "tests/geometry/hashed_hand.h"
#include "tests/ops/suite.h"

#include <stdlib.h>

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
    hashed_hand(hand);
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
