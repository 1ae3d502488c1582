/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Images in and out: PNG and JPEG ourselves, other still formats through OpenCV where it was built in.
 */
#ifndef LT_IO_IMAGE_IMAGE_H
#define LT_IO_IMAGE_IMAGE_H

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
 * lt_image_read - an image file; its first bytes tell the format, not its name
 *
 *   out      data in the arena; touched only on success
 *
 * PNG:   8 and 16 bits stay; 1, 2 and 4 bits become 8. Gray stays gray, palettes become RGB; with
 *        transparency either becomes RGBA. No gamma or colour profile is applied.
 * JPEG:  gray or RGB; the exact integer inverse DCT and smooth chroma, as OpenCV and Pillow do by
 *        default. EXIF orientation is ignored. CMYK is refused.
 * Other: as OpenCV reads it, if the library was built with it; otherwise refused. The module for that is
 *        looked for in $PALMAR_MODULES, in a build folder beside the program, and where it was installed.
 *
 * Errors: LT_EFORMAT: truncated, damaged, larger than LT_IMAGE_MAX_SIDE or LT_IMAGE_MAX_PIXELS, more
 * than 500 JPEG scans, not an image. LT_EIO, LT_ENOMEM.
 */
LT_API lt_status lt_image_read(lt_arena *arena, const char *path, lt_image *out);

/* lt_image_decode - the same from n bytes in memory; name is for the error line */
LT_API lt_status lt_image_decode(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                                 lt_image *out);

/**
 * lt_image_to_rgb8 - any image as 8-bit RGB, in the arena; img itself where it is that already
 *
 * Gray is repeated, alpha dropped, 16 bits cut to their upper 8.
 */
LT_API lt_status lt_image_to_rgb8(lt_arena *arena, const lt_image *img, lt_image *out);

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
