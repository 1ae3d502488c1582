/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Depth beside a crop: the same window, and metres turned into numbers that do not depend on how far away the
 * scene is.
 */
#ifndef VISION_DEPTH_H
#define VISION_DEPTH_H

#include "libtensor/base/status.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/**
 * depth_crop - cut out depth, and normalise it: clamp((D - d) / 0.3 m, -1, 1), and 1 where it is unknown
 *
 *   A        from image to crop, row-major (2, 3)
 *   depth    (height, width) metres, 0 where unknown; NULL: unknown everywhere
 *   mask     (height, width) where the object is: d is the median of what is known there; without one, or
 *            when nothing is known there, of the middle third of the crop
 *   metres   (size, size) sampled at the nearest pixel, 0 where unknown
 *   out      (size, size) that, normalised
 *   scratch  (size, size)
 */
void depth_crop(const double A[6], const float *depth, const uint8_t *mask, int width, int height,
                float *metres, float *out, int size, float *scratch);

#ifdef __cplusplus
}
#endif
#endif
