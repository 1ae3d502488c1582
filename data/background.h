/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Another background behind hand and object: what few rooms lack, so that a network learns the hand and not the
 * room. Backgrounds are drawn, not photographed: surfaces of noise, stripes and checkers, things on them, light.
 */
#ifndef DATA_BACKGROUND_H
#define DATA_BACKGROUND_H

#include "data/dataset.h"
#include "libtensor/base/rng.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * background_keep - how much of each crop pixel is hand, object or forearm
 *
 *   s     has segments (SAMPLE_SEGMENTS)
 *   A     image to crop
 *   out   (size, size) in [0, 1]; 0 outside the image
 *
 * The mask is sampled smoothly, for it may be coarser than the image. It ends at the wrist; where the hand's pose
 * is known (SAMPLE_HAND_POSE) a forearm is added, going off from the wrist along the hand's x axis.
 */
void background_keep(const dataset_sample *s, const double A[6], float *out, int size);

/**
 * background_draw - a new background where keep is below 1
 *
 *   image   (3, size, size) in [0, 1], mixed with the background in the share 1 - keep
 *
 * The same picture at any size but for its grain; rng decides all of it.
 */
void background_draw(const float *keep, int size, lt_rng *rng, float *image);

#ifdef __cplusplus
}
#endif
#endif
