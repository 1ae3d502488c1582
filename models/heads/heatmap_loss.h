/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A loss on heat maps themselves, beside the one on their mean places: it tells each map at once where to rise,
 * where the mean of a flat map hardly does.
 *
 * Source: Sun et al. 2018, "Integral human pose regression", section 3, which trains with both; the maps' loss here
 * is the cross-entropy of their softmax.
 */
#ifndef MODELS_HEADS_HEATMAP_LOSS_H
#define MODELS_HEADS_HEATMAP_LOSS_H

#include "libtensor/ops/ops.h"

/**
 * heatmap_loss - the cross-entropy of softmax(logits) with maps whose soft-argmax is the true place
 *
 *   logits  (B, J, h w)      a map's rows after each other
 *   places  (B, J, 2)        in [0, 1] of the map without its margin of so many cells on each side
 *   weight  (B)
 *
 * A true map is spread over the four cells around the place, bilinear. Places beyond the outermost cells' centres
 * count as there. No gradient reaches the places.
 */
lt_tensor *heatmap_loss(lt_tensor *logits, lt_tensor *places, int h, int w, int margin, lt_tensor *weight);

#endif
