/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The pictures of a sample, of the one size that a dataset has.
 */
#ifndef VISION_PICTURE_H
#define VISION_PICTURE_H

#include "libtensor/io/image/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * picture_path - the picture that is there, whatever its ending: png, jpg or jpeg, in small letters or capital ones
 *
 *   stem    its path without ending and dot
 *   usual   the ending that is tried first, "png"; also that of the answer where none is there
 *
 * In the arena; NULL without memory.
 */
const char *picture_path(lt_arena *arena, const char *stem, const char *usual);

/* picture_read_rgb - 8-bit RGB of width x height. Errors: those of lt_image_read; another size. */
lt_status picture_read_rgb(lt_arena *arena, const char *path, int width, int height, lt_image *out);

#define HO3D_DEPTH_UNIT 0.00012498664727900177      /* metres in a step of HO3D's depth images */

/**
 * picture_read_depth - likewise, (height, width) metres along the optical axis, 0 where unknown
 *
 * One channel of 16 bits is in millimetres; colour is HO3D's: red the low byte and green the high one of a number
 * of HO3D_DEPTH_UNIT. Any other image is LT_EFORMAT.
 */
lt_status picture_read_depth(lt_arena *arena, const char *path, int width, int height, float **out);

/* picture_read_mask - 8-bit RGB that lies evenly over an image of width x height: its size, or a whole fraction of
 * it */
lt_status picture_read_mask(lt_arena *arena, const char *path, int width, int height, lt_image *out);

#ifdef __cplusplus
}
#endif
#endif
