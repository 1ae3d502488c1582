/* SPDX-License-Identifier: Apache-2.0 */
#include "models/heads/hand_object.h"

#include "models/heads/heatmap_loss.h"

static void add_output(model_record *r, const char *name, lt_tensor *t)
{
    model_port_add(&r->outputs, name, lt_output(t, name));
}

static void add_loss(model_record *r, const char *name, lt_tensor *value, double weight)
{
    lt_tensor *weighted = lt_output(lt_scale(value, weight), name);

    model_port_add(&r->losses, name, weighted);
    r->loss = r->loss ? lt_add(r->loss, weighted) : weighted;
}

/* Joints (B, 21, 3) as they are before the wrist's rotation R_0, the first of (B, 16, 3, 3): R_0^T p */
static lt_tensor *in_wrist_frame(lt_tensor *joints, lt_tensor *rotation)
{
    lt_tensor *R_0 = lt_reshape(lt_slice(rotation, 1, 0, 1), LT_SHAPE(lt_dim(rotation, 0), 3, 3));

    return lt_matmul(joints, R_0);
}

static void record_losses(const hand_object_out *o, const lt_hand_layer *hand, const hand_object_weights *w,
                          model_record *r)
{
    const int64_t B = r->batch, cells = lt_dim(o->object.conf, -1);
    lt_tensor *joints2d = model_input(r, "joints2d", LT_SHAPE(B, LT_HAND_KEYPOINTS, 2));
    lt_tensor *rotation = model_input(r, "rotation", LT_SHAPE(B, LT_HAND_JOINTS, 3, 3));
    lt_tensor *beta = model_input(r, "beta", LT_SHAPE(B, LT_HAND_BETAS));
    lt_tensor *points2d = model_input(r, "points2d", LT_SHAPE(B, OBJECT_POINTS, 2));
    lt_tensor *mask = model_input(r, "mask", LT_SHAPE(B, cells, cells));
    lt_tensor *weight = model_input(r, "weight", LT_SHAPE(B));
    lt_tensor *object_weight = model_input(r, "object_weight", LT_SHAPE(B));
    lt_tensor *vertices = lt_skin(hand, rotation, beta), *joints = lt_result(vertices, 1);
    const object_losses object = object_head_losses(&o->object, points2d, mask, object_weight);

    add_loss(r, "heatmap", lt_mse_loss(o->heat.joints2d, joints2d, weight), w->heatmap);
    if (w->maps > 0)
        add_loss(r, "maps", heatmap_loss(o->heat.logits, joints2d, (int)lt_dim(o->heat.heatmaps, 2),
                                         (int)lt_dim(o->heat.heatmaps, 3), o->heat.margin, weight), w->maps);
    add_loss(r, "joints", lt_mse_loss(o->mano.joints, joints, weight), w->joints);
    if (w->local > 0)
        add_loss(r, "local", lt_mse_loss(in_wrist_frame(o->mano.joints, o->mano.rotation),
                                         in_wrist_frame(joints, rotation), weight), w->local);
    add_loss(r, "vertices", lt_mse_loss(o->mano.vertices, vertices, weight), w->vertices);
    add_loss(r, "pose", lt_mse_loss(o->mano.rotation, rotation, weight), w->pose);
    add_loss(r, "shape", lt_mse_loss(o->mano.beta, beta, weight), w->shape);
    add_loss(r, "p2d", object.p2d, w->p2d);
    add_loss(r, "conf", object.conf, w->conf);
    lt_output(r->loss, "loss");
}

/* (B, J) of square maps (B, J, h, h) */
static lt_tensor *highest_cell(lt_tensor *maps)
{
    return lt_reshape(lt_max_pool2d(maps, (int)lt_dim(maps, 2), 1, 0, false),
                      LT_SHAPE(lt_dim(maps, 0), lt_dim(maps, 1)));
}

void hand_object_record(const hand_object_out *o, const lt_hand_layer *hand, const hand_object_weights *w,
                        bool losses, model_record *r)
{
    add_output(r, "joints2d", o->heat.joints2d);
    add_output(r, "peak", highest_cell(o->heat.heatmaps));
    add_output(r, "rotation", o->mano.rotation);
    add_output(r, "beta", o->mano.beta);
    add_output(r, "vertices", o->mano.vertices);
    add_output(r, "joints", o->mano.joints);
    add_output(r, "conf", o->object.conf);
    add_output(r, "point_x", o->object.x);
    add_output(r, "point_y", o->object.y);
    if (losses)
        record_losses(o, hand, w, r);
}

void identity_pose_init(lt_param *bias)
{
    for (int64_t i = 0; i < lt_param_numel(bias); i++)
        bias->data[i] = i % 6 == 0 || i % 6 == 4;
}
