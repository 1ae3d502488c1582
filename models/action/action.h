/* SPDX-License-Identifier: Apache-2.0 */
/*
 * action: which of ten things somebody does, from two streams: the skeleton, and a hand with an object where one is.
 *
 * Inputs: "body" (B, 3, T, 65) metres, less the pelvis of the first frame; "hand_object" (B, 3, T, 30) metres, less the
 * wrist of the first valid frame, zeros where not valid; "valid" (B, T) 1 or 0; "on" (B) 1 where stream 2 is looked at,
 * else 0, and its feature is zeros; for the loss "class" (B, 10), a 1 in its place, and "weight" (B).
 * Output: "logits" (B, 10). Loss: "class".
 *
 * Source: Bandi and Thomas 2025, "Action recognition via multi-view perception feature tracking for human-robot
 * interaction", section 4.
 */
#ifndef MODELS_ACTION_ACTION_H
#define MODELS_ACTION_ACTION_H

#include "models/action/object_stream.h"
#include "models/action/stgcn.h"
#include "models/model.h"

enum { ACTION_OUTPUTS = 10 };

extern const model_class action_class;

/* Three linear layers, two norms */
typedef struct {
    lt_linear_layer fc1, fc2, fc3;
    lt_layer_norm_layer norm1, norm2;
} action_head;

/* A model's parts, for stream.h; it lives as long as the model. action_frames - T */
const stgcn *action_stgcn(const model *m);
int action_frames(const model *m);

/* action_classify - from stream 1's feature (B, C), and stream 2's (B, 128), times on (B): logits */
lt_tensor *action_classify(const model *m, lt_tensor *body, lt_tensor *hand_object, lt_tensor *on);

/* action_hand_object - stream 2's feature */
lt_tensor *action_hand_object(const model *m, lt_tensor *x, lt_tensor *valid);

#endif
