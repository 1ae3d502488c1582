/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The one door to OpenCV, which is C++: still formats that we do not read ourselves.
 */
#ifndef LT_IO_OPENCV_H
#define LT_IO_OPENCV_H

#include "libtensor/io/image.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lt_opencv_decode - n bytes as an image in the arena; LT_EFORMAT when OpenCV does not know it either,
 * or was not built in. Channels come out as RGB or RGBA. No exception leaves it. */
lt_status lt_opencv_decode(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                           lt_image *out);

#ifdef __cplusplus
}
#endif
#endif
