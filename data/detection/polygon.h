/* SPDX-License-Identifier: Apache-2.0 */
/* Filling polygons. */
#ifndef DATA_DETECTION_POLYGON_H
#define DATA_DETECTION_POLYGON_H

#include "libtensor/base/common.h"

/**
 * polygon_fill - set the pixels of a (height, width) mask whose centres lie inside, by the even-odd rule
 *
 *   point    (n, 2) in pixels, whose first one covers 0 to 1; corners may lie outside the picture
 *   border   also those that an edge passes through
 */
void polygon_fill(const float *point, int n, bool border, int width, int height, uint8_t *mask);

#endif
