/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What estimators of one hand and one object end in: named outputs, and the weighted losses on them.
 *
 * Source: Semi-Hand-Object networks/loss.py and utils/options.py.
 */
#ifndef MODELS_HEADS_HAND_OBJECT_H
#define MODELS_HEADS_HAND_OBJECT_H

#include "models/heads/hourglass.h"
#include "models/heads/mano_regressor.h"
#include "models/heads/object_head.h"
#include "models/model.h"

typedef struct {
    heatmap_out heat;
    mano_out mano;
    object_out object;
} hand_object_out;

/* Weights of the losses; HAND_OBJECT_KEYS are their rows in the table of a configuration's keys. */
typedef struct {
    double heatmap, maps, joints, local, vertices, pose, shape, p2d, conf;
} hand_object_weights;

#define HAND_OBJECT_KEY(config, field, value, what) \
    { .name = "w_" #field, .offset = offsetof(config, w.field), .type = LT_CONFIG_NUMBER, .fallback = value, \
      .doc = "weight of " what }
#define HAND_OBJECT_KEYS(config) \
    HAND_OBJECT_KEY(config, heatmap, "100", "the 2D joints' loss"), \
    HAND_OBJECT_KEY(config, maps, "0", "the heat maps' cross-entropy; the papers have none"), \
    HAND_OBJECT_KEY(config, joints, "10000", "the 3D joints' loss"), \
    HAND_OBJECT_KEY(config, local, "0", "the 3D joints' loss in the wrist's own frame, which only fingers and shape " \
                    "can lower; the papers have none"), \
    HAND_OBJECT_KEY(config, vertices, "10000", "the vertices' loss"), \
    HAND_OBJECT_KEY(config, pose, "10", "the rotations' loss"), \
    HAND_OBJECT_KEY(config, shape, "0.1", "the shape's loss"), \
    HAND_OBJECT_KEY(config, p2d, "500", "the control points' loss; 0: a model of hands alone, asked for no object"), \
    HAND_OBJECT_KEY(config, conf, "100", "the confidences' loss")

/* hand_object_record - the outputs of model_record's list and, with losses, their targets' inputs and the sum;
 * truth passes through the same hand layer */
void hand_object_record(const hand_object_out *o, const lt_hand_layer *hand, const hand_object_weights *w,
                        bool losses, model_record *r);

/* identity_pose_init - the rotation head says "no rotation" at first: (1, 0, 0, 0, 1, 0) for each joint */
void identity_pose_init(lt_param *bias);

#endif
