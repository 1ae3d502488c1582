/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Changes of colour and sharpness, on planar RGB images in [0, 1]; definitions as torchvision's
 * ColorJitter has them, each result clamped to [0, 1].
 */
#ifndef VISION_AUGMENT_H
#define VISION_AUGMENT_H

#include "libtensor/base/rng.h"

#ifdef __cplusplus
extern "C" {
#endif

/* image is (3, n) here: three planes of n pixels. */
void augment_brightness(float *image, int64_t n, double factor);    /* blend with black */
void augment_contrast(float *image, int64_t n, double factor);      /* with the mean grey */
void augment_saturation(float *image, int64_t n, double factor);    /* with the grey image */
void augment_hue(float *image, int64_t n, double shift);            /* shift in turns, -0.5 .. 0.5 */

/* augment_hsv - hue, saturation and value of each pixel times factors; as the detectors' recipes have it */
void augment_hsv(float *image, int64_t n, double hue, double saturation, double value);

/* augment_blur - Gaussian of deviation radius pixels, below 1; the border is repeated. (3, h, w).
 * scratch holds h * w floats. */
void augment_blur(float *image, int height, int width, double radius, float *scratch);

/* How far augment_colour may go: factors 1 +- x, hue +- x turns, radius up to blur. */
typedef struct { double blur, brightness, contrast, saturation, hue; } augment_limits;

/* augment_colour - blur, then the four others in random order; (3, h, w), scratch h * w floats */
void augment_colour(float *image, int height, int width, const augment_limits *limits, lt_rng *rng,
                    float *scratch);

#ifdef __cplusplus
}
#endif
#endif
