/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The one door to OpenCV: films, and still formats that we do not read ourselves, by a module that is loaded when
 * it is needed.
 */
#ifndef LT_IO_IMAGE_OPENCV_H
#define LT_IO_IMAGE_OPENCV_H

#include "libtensor/io/image/pixels.h"

/* lt_opencv_decode - n bytes as an image in the arena; LT_EFORMAT when OpenCV does not know it either,
 * or its module is not there. Channels come out as RGB or RGBA. */
lt_status lt_opencv_decode(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                           lt_image *out);

#endif
