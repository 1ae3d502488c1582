/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Images in memory: what all readers and writers of images share.
 */
#ifndef LT_IO_IMAGE_PIXELS_H
#define LT_IO_IMAGE_PIXELS_H

#include "libtensor/base/arena.h"
#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Row-major, interleaved, top row first, no padding. 16-bit samples are uint16_t in host order. */
typedef struct {
    int width, height;
    int channels;                   /* 1 gray, 3 RGB, 4 RGBA (not premultiplied) */
    int bits;                       /* 8 or 16 a sample */
    uint8_t *data;                  /* height * width * channels * bits / 8 bytes */
} lt_image;

#define LT_IMAGE_MAX_PIXELS 100000000       /* a larger image is refused */
enum { LT_IMAGE_MAX_SIDE = 16384 };

/* lt_image_bytes - size of data */
LT_API size_t lt_image_bytes(const lt_image *img);

/* lt_image_init - a black image in the arena; LT_EINVAL beyond the limits above, LT_ENOMEM */
LT_API lt_status lt_image_init(lt_arena *arena, int width, int height, int channels, int bits,
                               lt_image *out);

/**
 * lt_image_to_rgb8 - any image as 8-bit RGB, in the arena; img itself where it is that already
 *
 * Gray is repeated, alpha dropped, 16 bits cut to their upper 8.
 */
LT_API lt_status lt_image_to_rgb8(lt_arena *arena, const lt_image *img, lt_image *out);

#ifdef __cplusplus
}
#endif
#endif
