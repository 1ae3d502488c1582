/* SPDX-License-Identifier: Apache-2.0 */
/* hand: the hand layer, one sample a task.                        [Romero et al. 2017, "Embodied Hands"]
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

static const lt_real *rotations(const lt_call *c, int64_t b)
{
    return (const lt_real *)c->in[ROTATIONS]->data + b * 9 * LT_HAND_JOINTS;
}

static void forward_sample(void *ctx, int64_t b)
{
    const lt_call *c = ctx;
    const hand_attr *a = c->attr;
    lt_hand_scratch *scratch = c->train ? c->saved[0] : c->work;

    lt_hand_layer_forward(a->layer, rotations(c, b), (const lt_real *)c->in[BETAS]->data + b * LT_HAND_BETAS,
                          (lt_real *)c->outs[VERTICES]->data + b * 3 * LT_HAND_VERTICES,
                          (lt_real *)c->outs[KEYPOINTS]->data + b * 3 * LT_HAND_KEYPOINTS, scratch + b);
}

static void forward(const lt_call *c)
{
    lt_parallel_for(lt_dim(c->in[BETAS], 0), forward_sample, (void *)c);
}

/* The layer wants both places to write to; what nobody asked for goes to a bin. */
static void backward_sample(void *ctx, int64_t b)
{
    const lt_call *c = ctx;
    const hand_attr *a = c->attr;
    const lt_real *dv = c->douts[VERTICES], *dk = c->douts[KEYPOINTS];
    lt_real bin_R[9 * LT_HAND_JOINTS] = { 0 }, bin_beta[LT_HAND_BETAS] = { 0 };
    lt_real *dR = c->din[ROTATIONS] ? c->din[ROTATIONS] + b * 9 * LT_HAND_JOINTS : bin_R;
    lt_real *dbeta = c->din[BETAS] ? c->din[BETAS] + b * LT_HAND_BETAS : bin_beta;

    lt_hand_layer_backward(a->layer, rotations(c, b), dv ? dv + b * 3 * LT_HAND_VERTICES : NULL,
                           dk ? dk + b * 3 * LT_HAND_KEYPOINTS : NULL, dR, dbeta,
                           (lt_hand_scratch *)c->saved[0] + b);
}

static void backward(const lt_call *c)
{
    lt_parallel_for(lt_dim(c->in[BETAS], 0), backward_sample, (void *)c);
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
