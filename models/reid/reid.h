/* SPDX-License-Identifier: Apache-2.0 */
/*
 * reid: embeds the picture of one thing so that other pictures of it lie near, and pictures of others far.
 *
 * Input: "image" (B, 3, 128, 64) in [0, 1]; for the loss "identity" (B, identities), a 1 in its place, and "weight"
 * (B). Output: "embedding" (B, 128), of length 1. Loss: "identity".
 *
 * Source: Wojke and Bewley 2018, "Deep cosine metric learning for person re-identification".
 */
#ifndef MODELS_REID_REID_H
#define MODELS_REID_REID_H

#include "models/model.h"

enum { REID_HEIGHT = 128, REID_WIDTH = 64, REID_EMBEDDING = 128 };

extern const model_class reid_class;

/* reid_identities - how many m tells apart in training, 0: it cannot be trained */
int reid_identities(const model *m);

#endif
