/* SPDX-License-Identifier: Apache-2.0 */
#include "data/picture.h"

static lt_status check_size(const char *path, const lt_image *img, int width, int height)
{
    if (img->width == width && img->height == height)
        return LT_OK;
    return lt_error(LT_EFORMAT, "%s: image of %d x %d, expected %d x %d", path, img->width, img->height, width,
                    height);
}

lt_status picture_read_rgb(lt_arena *arena, const char *path, int width, int height, lt_image *out)
{
    lt_image img;
    lt_status st = lt_image_read(arena, path, &img);

    if (!st)
        st = check_size(path, &img, width, height);
    return st ? st : lt_image_to_rgb8(arena, &img, out);
}

lt_status picture_read_gray16(lt_arena *arena, const char *path, int width, int height, lt_image *out)
{
    lt_image img;
    lt_status st = lt_image_read(arena, path, &img);

    if (!st)
        st = check_size(path, &img, width, height);
    if (!st && (img.channels != 1 || img.bits != 16))
        st = lt_error(LT_EFORMAT, "%s: %d channels of %d bits, expected one of 16: depth in millimetres", path,
                      img.channels, img.bits);
    if (!st)
        *out = img;
    return st;
}
