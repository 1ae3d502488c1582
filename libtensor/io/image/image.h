/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Images in and out: PNG and JPEG ourselves, other still formats through OpenCV where it was built in.
 */
#ifndef LT_IO_IMAGE_IMAGE_H
#define LT_IO_IMAGE_IMAGE_H

#include "libtensor/io/image/pixels.h"
#include "libtensor/io/image/write.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * lt_image_read - an image file; its first bytes tell the format, not its name
 *
 *   out      data in the arena; touched only on success
 *
 * PNG:   8 and 16 bits stay; 1, 2 and 4 bits become 8. Gray stays gray, palettes become RGB; with
 *        transparency either becomes RGBA. No gamma or colour profile is applied.
 * JPEG:  gray or RGB; the exact integer inverse DCT and smooth chroma, as OpenCV and Pillow do by
 *        default. EXIF orientation is ignored. CMYK and YCCK become RGB, inks inverted as Adobe stores them.
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

#ifdef __cplusplus
}
#endif
#endif
