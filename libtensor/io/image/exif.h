/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a camera wrote into a JPEG beside the picture, as far as geometry needs it.
 */
#ifndef LT_IO_IMAGE_EXIF_H
#define LT_IO_IMAGE_EXIF_H

#include "libtensor/base/common.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    int orientation;            /* 1 upright .. 8, see lt_exif_turn; 1 when the file does not say */
    double focal_35mm;          /* focal length in mm of a 36 x 24 mm frame with this diagonal; 0: unknown */
} lt_exif;

/**
 * lt_exif_read - from the bytes of an image file
 *
 * Never fails: what is missing, damaged, or no JPEG at all reads as unknown. At most two directories
 * of 512 entries each are looked at.
 *
 * Source: CIPA DC-008 (Exif 2.3), tags 0x0112, 0x8769, 0xA405.
 */
LT_API lt_exif lt_exif_read(const uint8_t *bytes, size_t n);

/* lt_exif_focal_px - focal length in pixels of a width x height image; 0 when unknown */
LT_API double lt_exif_focal_px(const lt_exif *exif, int width, int height);

/**
 * lt_exif_turn - the pixel of the stored image that stands at (x, y) of the upright one
 *
 *   width, height   of the stored image; upright they are swapped for orientations 5 to 8
 */
LT_API void lt_exif_turn(int orientation, int width, int height, int x, int y, int *from_x, int *from_y);

#ifdef __cplusplus
}
#endif
#endif
