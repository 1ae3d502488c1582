/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The pictures of a sample, of the one size that a dataset has.
 */
#ifndef DATA_PICTURE_H
#define DATA_PICTURE_H

#include "libtensor/io/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* picture_read_rgb - 8-bit RGB of width x height. Errors: those of lt_image_read; another size. */
lt_status picture_read_rgb(lt_arena *arena, const char *path, int width, int height, lt_image *out);

/* picture_read_gray16 - likewise, one channel of 16 bits, as depth comes in millimetres */
lt_status picture_read_gray16(lt_arena *arena, const char *path, int width, int height, lt_image *out);

#ifdef __cplusplus
}
#endif
#endif
