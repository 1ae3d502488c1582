/* SPDX-License-Identifier: Apache-2.0 */
/* skin: both results, of a hand and of a small rig, against the formula of scripts/vectors/geometry.py in PyTorch. */
#include "tests/geometry/hashed_hand.h"
#include "tests/geometry/hashed_rig.h"
#include "tests/ops/suite.h"

#include "libtensor/geometry/hand/layer.h"

#include <stdlib.h>

/* Made once, kept for the life of the program. */
static lt_arena *arena(void)
{
    static lt_arena *a;

    return a ? a : (a = lt_arena_new());
}

static const lt_skin_layer *hand(void)
{
    static lt_skin_layer *layer;
    lt_hand_model *model;

    if (layer)
        return layer;
    model = lt_arena_alloc(arena(), sizeof(*model));
    hashed_hand(model);
    if (lt_hand_layer_new(arena(), model, lt_hand_tips_ho3d, &layer))
        abort();
    return layer;
}

/* 37 vertices, 5 joints, 3 shapes; one rig goes without pose blends and without points. */
static const lt_skin_layer *small(bool bare)
{
    static const int points[] = { 5 + 36, 4, 0, 5 + 2 };
    static lt_skin_layer *layers[2];
    lt_rig rig;

    if (layers[bare])
        return layers[bare];
    rig = hashed_rig(arena(), 37, 5, 3);
    if (bare)
        rig.posedirs = NULL;
    if (lt_skin_layer_new(arena(), &rig, points, bare ? 0 : (int)LT_COUNT(points), &layers[bare]))
        abort();
    return layers[bare];
}

static lt_tensor *both(lt_tensor **in) { return lt_skin(hand(), in[0], in[1]); }
static lt_tensor *vertices(lt_tensor **in) { return lt_scale(both(in), 1); }
static lt_tensor *keypoints(lt_tensor **in) { return lt_scale(lt_result(both(in), 1), 1); }
static lt_tensor *small_both(lt_tensor **in) { return lt_skin(small(false), in[0], in[1]); }
static lt_tensor *bare(lt_tensor **in) { return lt_scale(lt_skin(small(true), in[0], in[1]), 1); }

static const op_case cases[] = {
    { "both", both, .in = { S(2, 16, 3, 3), S(2, 10) } },
    { "vertices", vertices, .in = { S(1, 16, 3, 3), S(1, 10) } },
    { "keypoints", keypoints, .in = { S(1, 16, 3, 3), S(1, 10) } },
    { "empty", both, .in = { S(0, 16, 3, 3), S(0, 10) } },
    { "small", small_both, .in = { S(3, 5, 3, 3), S(3, 3) } },
    { "bare", bare, .in = { S(5, 5, 3, 3), S(5, 3) } },
    { "long", both, .in = { S(9, 16, 3, 3), S(9, 10) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { both, { S(2, 15, 3, 3), S(2, 10) }, "skin: rotations is (2, 15, 3, 3), want (2, 16, 3, 3)" },
    { both, { S(2, 16, 3, 3), S(3, 10) }, "skin: shape is (3, 10), want (2, 10)" },
    { both, { S(2, 48), S(2, 10) }, "skin: rotations is (2, 48), want 4 dimensions" },
};

const op_suite skin_suite = { "skin", CASES(cases), BAD(bad) };
