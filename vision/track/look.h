/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How something looks: what a box holds of a picture, as a re-identification network takes it.
 */
#ifndef VISION_TRACK_LOOK_H
#define VISION_TRACK_LOOK_H

#include "libtensor/io/image/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * look_cut - what lies in box x0 y0 x1 y1, stretched to width x height pixels
 *
 *   rgb      of 8 bits
 *   person   the box is first made half as wide as it is high, about its middle
 *   out      (3, height, width) in [0, 1]
 *
 * Of a box that reaches outside, what is inside is stretched; the four nearest pixels are mixed. Returns false where
 * nothing of it is in the picture, or a number is not finite: out is as it was.
 */
bool look_cut(const lt_image *rgb, const float box[4], bool person, int width, int height, float *out);

#ifdef __cplusplus
}
#endif
#endif
