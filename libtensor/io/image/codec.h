/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One function per still image format; lt_image_decode chooses among them.
 */
#ifndef LT_IO_IMAGE_CODEC_H
#define LT_IO_IMAGE_CODEC_H

#include "libtensor/io/image/pixels.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Each reads n > 0 bytes into an image in the arena; name is for the error line. */
lt_status lt_png_decode(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_image *out);
lt_status lt_jpeg_decode(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_image *out);

/* lt_image_check - LT_EFORMAT with the name when a header asks for more than the limits of pixels.h */
lt_status lt_image_check(const char *name, uint64_t width, uint64_t height);

#ifdef __cplusplus
}
#endif
#endif
