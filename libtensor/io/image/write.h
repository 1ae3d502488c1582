/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Images as files: PNG and JPEG.
 */
#ifndef LT_IO_IMAGE_WRITE_H
#define LT_IO_IMAGE_WRITE_H

#include "libtensor/io/image/pixels.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lt_png_write - any lt_image, losslessly and atomically; errors of lt_atomic_commit */
LT_API lt_status lt_png_write(const char *path, const lt_image *img);

/* lt_png_write_fast - the same, several times faster; noisy pictures come out about a tenth larger */
LT_API lt_status lt_png_write_fast(const char *path, const lt_image *img);

/* lt_jpeg_write - an 8-bit gray or RGB image, atomically; quality 1..100, chroma at full resolution */
LT_API lt_status lt_jpeg_write(const char *path, const lt_image *img, int quality);

/* lt_jpeg_encode - the same into bytes that the arena owns */
LT_API lt_status lt_jpeg_encode(lt_arena *arena, const lt_image *img, int quality, uint8_t **bytes,
                                size_t *n);

#ifdef __cplusplus
}
#endif
#endif
