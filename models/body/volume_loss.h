/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A loss on the volumes in which OSX finds joints, beside the one on their mean places: it tells each volume at once
 * where to rise, where the mean of a flat one hardly does.
 *
 * Source: Sun et al. 2018, "Integral human pose regression", section 3, which trains with both; the volumes' loss here
 * is the cross-entropy of their softmax.
 */
#ifndef MODELS_BODY_VOLUME_LOSS_H
#define MODELS_BODY_VOLUME_LOSS_H

#include "libtensor/ops/ops.h"

typedef struct { int depth, rows, columns; } volume_size;

/**
 * volume_loss - the cross-entropy of softmax(logits) with volumes whose soft-argmax is the true place
 *
 *   logits  (B, J, depth rows columns)
 *   places  (B, J, 3)        column, row and depth, in cells: 0 is the middle of the first one
 *   known   (B, J)           1: it counts; 0: no place is known
 *   weight  (B)
 *
 * A true volume is spread over the eight cells around the place, trilinear; it is 0, and its loss too, where known is.
 * Places beyond the outermost cells' middles count as there. No gradient reaches places, known and weight.
 */
lt_tensor *volume_loss(lt_tensor *logits, lt_tensor *places, lt_tensor *known, volume_size size, lt_tensor *weight);

#endif
