/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Image files: telling formats apart.
 */
#include "libtensor/io/image/image.h"

#include "libtensor/io/file.h"
#include "libtensor/io/image/codec.h"
#include "libtensor/io/image/opencv.h"

#include <string.h>

static bool starts_with(const uint8_t *bytes, size_t n, const char *magic, size_t length)
{
    return n >= length && memcmp(bytes, magic, length) == 0;
}

lt_status lt_image_decode(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                          lt_image *out)
{
    if (n == 0)
        return lt_error(LT_EFORMAT, "%s: empty file, want an image", name);
    if (starts_with(bytes, n, "\x89PNG\r\n\x1a\n", 8))
        return lt_png_decode(arena, name, bytes, n, out);
    if (starts_with(bytes, n, "\xff\xd8\xff", 3))
        return lt_jpeg_decode(arena, name, bytes, n, out);
    return lt_opencv_decode(arena, name, bytes, n, out);
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
