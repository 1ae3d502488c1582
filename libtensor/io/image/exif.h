/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a camera wrote beside the picture, as far as geometry needs it, and turning pictures upright.
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
    double focal_mm;            /* focal length; 0: unknown */
    double sensor_px_per_mm;    /* of a picture whose longer side has longer_px; 0: unknown */
    double longer_px;           /* as the camera stored the picture; 0: unknown, as large as it is */
} lt_exif;

/**
 * lt_exif_read - from the bytes of an image file: a JPEG's APP1, a PNG's eXIf chunk, a WebP's EXIF chunk
 *
 * Never fails: what is missing, damaged, or in no such file reads as unknown. At most two directories
 * of 512 entries each are looked at.
 *
 * Source: CIPA DC-008 (Exif 2.3), tags 0x0112, 0x8769, 0x920A, 0xA002, 0xA003, 0xA20E, 0xA210, 0xA405; PNG 3, 11.3.5;
 * RFC 9649, 2.7.1.5.
 */
LT_API lt_exif lt_exif_read(const uint8_t *bytes, size_t n);

/* lt_exif_focal_px - focal length in pixels of a width x height image, by its length of 35 mm film or else by the
 * sensor's pixels; 0 when unknown, or less than a tenth or more than a hundred times the longer side */
LT_API double lt_exif_focal_px(const lt_exif *exif, int width, int height);

/**
 * lt_exif_turn - the pixel of the stored image that stands at (x, y) of the upright one
 *
 *   width, height   of the stored image; upright they are swapped for orientations 5 to 8
 */
LT_API void lt_exif_turn(int orientation, int width, int height, int x, int y, int *from_x, int *from_y);

/**
 * lt_exif_upright - a whole image turned
 *
 *   stored          (height, width) pixels of pixel_bytes each
 *   upright         as many, (width, height) of them for orientations 5 to 8; another place than stored
 */
LT_API void lt_exif_upright(int orientation, int width, int height, size_t pixel_bytes, const void *stored,
                            void *upright);

#ifdef __cplusplus
}
#endif
#endif
