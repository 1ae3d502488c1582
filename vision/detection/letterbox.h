/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Fitting a picture of any size into a square: as large as it goes, in the middle, grey around it.
 */
#ifndef VISION_DETECTION_LETTERBOX_H
#define VISION_DETECTION_LETTERBOX_H

#include "libtensor/io/image/image.h"

#ifdef __cplusplus
extern "C" {
#endif

#define LETTERBOX_GREY (114.0f / 255.0f)

/* From pixels of the picture to those of the square: x scale + left, y scale + top */
typedef struct { double scale, left, top; } letterbox;

letterbox letterbox_of(int width, int height, int size);

/* letterbox_picture - rgb of 8 bits into (3, size, size) in [0, 1], the four nearest pixels mixed */
void letterbox_picture(const letterbox *l, const lt_image *rgb, int size, float *out);

/* letterbox_back - a box x0 y0 x1 y1 of the square in pixels of the picture, cut off at its sides */
void letterbox_back(const letterbox *l, int width, int height, const float box[4], float out[4]);

#ifdef __cplusplus
}
#endif
#endif
