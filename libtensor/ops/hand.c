/* SPDX-License-Identifier: Apache-2.0 */
/* hand: the hand layer.                                           [Romero et al. 2017, "Embodied Hands"]
 *   rotations (B, 16, 3, 3)   betas (B, 10)   ->   vertices (B, 778, 3), key points (B, 21, 3)
 *
 * The formula and its gradient are libtensor/geometry/hand_layer.c.
 */
#include "libtensor/ops/common.h"

enum { ROTATIONS, BETAS };
enum { VERTICES, KEYPOINTS };

typedef struct {
    const lt_hand_layer *layer;
} hand_attr;

static lt_status infer(lt_call *c)
{
    int64_t B;

    if (lt_want_rank(c, ROTATIONS, "rotations", 4))
        return LT_ESHAPE;
    B = lt_dim(c->in[ROTATIONS], 0);
    if (lt_want_shape(c, ROTATIONS, "rotations", LT_SHAPE(B, LT_HAND_JOINTS, 3, 3))
        || lt_want_shape(c, BETAS, "betas", LT_SHAPE(B, LT_HAND_BETAS)))
        return LT_ESHAPE;
    c->outs[VERTICES]->shape = LT_SHAPE(B, LT_HAND_VERTICES, 3);
    c->outs[KEYPOINTS]->shape = LT_SHAPE(B, LT_HAND_KEYPOINTS, 3);
    return LT_OK;
}

static void plan(lt_call *c)
{
    const size_t bytes = (size_t)lt_dim(c->in[BETAS], 0) * sizeof(lt_hand_scratch);

    if (c->train)
        c->saved_bytes[0] = bytes;
    else
        c->work_bytes = bytes;
}

static lt_hand_scratch *scratch(const lt_call *c)
{
    return c->train ? c->saved[0] : c->work;
}

static void forward(const lt_call *c)
{
    const hand_attr *a = c->attr;

    lt_hand_layer_forward(a->layer, lt_dim(c->in[BETAS], 0), c->in[ROTATIONS]->data, c->in[BETAS]->data,
                          c->outs[VERTICES]->data, c->outs[KEYPOINTS]->data, scratch(c));
}

static void backward(const lt_call *c)
{
    const hand_attr *a = c->attr;

    lt_hand_layer_backward(a->layer, lt_dim(c->in[BETAS], 0), c->in[ROTATIONS]->data, c->douts[VERTICES],
                           c->douts[KEYPOINTS], c->din[ROTATIONS], c->din[BETAS], scratch(c));
}

static const lt_op hand_op = {
    .name = "hand", .n_out = 2, .keeps = LT_KEEP_IN(ROTATIONS), .infer = infer, .plan = plan,
    .forward = forward, .backward = backward,
};

lt_tensor *(lt_hand)(const lt_hand_layer *layer, lt_tensor *R, lt_tensor *betas)
{
    const hand_attr a = { .layer = layer };

    return lt_apply(&hand_op, &a, sizeof(a), (lt_tensor *[]){ R, betas }, 2);
}
