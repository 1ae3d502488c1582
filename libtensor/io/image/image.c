/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Image files: telling formats apart.
 */
#include "libtensor/io/image/image.h"

#include "libtensor/io/file.h"
#include "libtensor/io/image/codec.h"
#include "libtensor/io/image/opencv.h"
#include "libtensor/io/kind.h"

lt_status lt_image_decode(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                          lt_image *out)
{
    switch (lt_kind_of(bytes, n)) {
    case LT_KIND_PNG:  return lt_png_decode(arena, name, bytes, n, out);
    case LT_KIND_JPEG: return lt_jpeg_decode(arena, name, bytes, n, out);
    case LT_KIND_WEBP:
    case LT_KIND_TIFF:
    case LT_KIND_BMP:
    case LT_KIND_UNKNOWN: return lt_opencv_decode(arena, name, bytes, n, out);
    default:              return lt_refuse(name, bytes, n, "an image");
    }
}

lt_status lt_image_read(lt_arena *arena, const char *path, lt_image *out)
{
    lt_file file;
    lt_status st = lt_file_load(&file, path, (size_t)1 << 30);

    if (!st)
        st = lt_image_decode(arena, path, file.bytes, file.n, out);
    lt_file_free(&file);
    return st;
}
