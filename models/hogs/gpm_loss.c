/* SPDX-License-Identifier: Apache-2.0 */
#include "models/hogs/gpm_loss.h"

static const double W_ROTATION = 10, W_TRANSLATION = 1e4, W_CORNER = 1e3;

hogs_pose gpm_refined(const hogs_pose *initial, const gpm_out *offsets)
{
    return (hogs_pose){ .R = lt_add(initial->R, offsets->delta_R), .t = lt_add(initial->t, offsets->delta_T) };
}

/* Each token's numbers (B, M, C) against a frame's (B, C) */
static lt_tensor *loss_of_tokens(lt_tensor *x, lt_tensor *target, lt_tensor *weight)
{
    lt_tensor *zeros, *want = lt_reshape(target, LT_SHAPE(lt_dim(x, 0), 1, lt_dim(x, 2)));

    lt_constant_reals(x->graph, x->shape, &zeros);
    return lt_smooth_l1_loss(lt_sub(x, want), zeros, weight);
}

/* The mean over the encoder's layers */
static lt_tensor *loss_of_layers(lt_tensor *const *x, int layers, lt_tensor *target, lt_tensor *weight)
{
    lt_tensor *sum = loss_of_tokens(x[0], target, weight);

    for (int i = 1; i < layers; i++)
        sum = lt_add(sum, loss_of_tokens(x[i], target, weight));
    return lt_scale(sum, 1.0 / layers);
}

/* Rows are x R^T + t. */
lt_tensor *hogs_posed(lt_tensor *points, const hogs_pose *pose)
{
    lt_tensor *turned = lt_matmul(points, lt_permute(pose->R, (int[]){ 0, 2, 1 }));

    return lt_add(turned, lt_reshape(pose->t, LT_SHAPE(lt_dim(points, 0), 1, 3)));
}

gpm_losses gpm_pose_losses(const gpm_out *offsets, const gpm_truth *truth)
{
    const hogs_pose found = gpm_refined(&truth->initial, offsets);
    lt_tensor *turn = lt_sub(truth->truth.R, truth->initial.R), *rotation, *translation;
    lt_tensor *corner = lt_smooth_l1_loss(hogs_posed(truth->corners, &found),
                                          hogs_posed(truth->corners, &truth->truth), truth->weight), *pose;

    turn = lt_reshape(turn, LT_SHAPE(lt_dim(turn, 0), 9));
    rotation = loss_of_layers(offsets->rotation, offsets->layers, turn, truth->weight);
    translation = loss_of_layers(offsets->translation, offsets->layers, truth->translation, truth->weight);
    pose = lt_add(lt_add(lt_scale(rotation, W_ROTATION), lt_scale(translation, W_TRANSLATION)),
                  lt_scale(corner, W_CORNER));
    return (gpm_losses){ .rotation = rotation, .translation = translation, .corner = corner, .pose = pose };
}
