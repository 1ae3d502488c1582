/* SPDX-License-Identifier: Apache-2.0 */
#include "vision/picture.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* Cameras and cards write capitals, and copies keep them. */
const char *picture_path(lt_arena *arena, const char *stem, const char *usual)
{
    static const char *const ending[] = { "png", "jpg", "jpeg", "PNG", "JPG", "JPEG" };
    const size_t n = strlen(stem), room = n + sizeof(".jpeg");
    char *path = lt_arena_printf(arena, "%s.%s", stem, usual), *other;

    if (!path || access(path, F_OK) == 0)
        return path;
    other = lt_arena_alloc(arena, room);
    if (!other)
        return NULL;
    memcpy(other, stem, n);
    for (size_t i = 0; i < LT_COUNT(ending); i++) {
        snprintf(other + n, room - n, ".%s", ending[i]);
        if (access(other, F_OK) == 0)
            return other;
    }
    return path;
}

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

/* Whether a mask of this size lies evenly over the image. */
static bool divides(const lt_image *mask, int width, int height)
{
    return width % mask->width == 0 && height % mask->height == 0 &&
           width / mask->width == height / mask->height;
}

lt_status picture_read_mask(lt_arena *arena, const char *path, int width, int height, lt_image *out)
{
    lt_image img;
    lt_status st = lt_image_read(arena, path, &img);

    if (!st && !divides(&img, width, height))
        st = lt_error(LT_EFORMAT, "%s: mask of %d x %d, expected %d x %d or a whole fraction of it", path, img.width,
                      img.height, width, height);
    return st ? st : lt_image_to_rgb8(arena, &img, out);
}

static float metres(const lt_image *img, size_t i)
{
    const uint8_t *rgb = img->data + (size_t)img->channels * i;

    if (img->channels == 1)
        return (float)(((const uint16_t *)(const void *)img->data)[i] * 0.001);
    return (float)((rgb[0] + 256 * rgb[1]) * HO3D_DEPTH_UNIT);
}

/* HO3D's depth leaves blue alone; a picture of the same size does not. */
static bool mostly_blue(const lt_image *img, size_t n)
{
    size_t blue = 0;

    for (size_t i = 0; i < n; i++)
        blue += img->data[3 * i + 2] != 0;
    return blue > n / 2;
}

static bool is_depth(const lt_image *img, size_t n)
{
    return img->channels == 1 ? img->bits == 16 : img->channels == 3 && img->bits == 8 && !mostly_blue(img, n);
}

lt_status picture_read_depth(lt_arena *arena, const char *path, int width, int height, float **out)
{
    const size_t n = (size_t)width * (size_t)height;
    float *depth;
    lt_image img;
    lt_status st = lt_image_read(arena, path, &img);

    if (!st)
        st = check_size(path, &img, width, height);
    if (!st && !is_depth(&img, n))
        st = lt_error(LT_EFORMAT, "%s: %d channels of %d bits%s, expected one of 16, depth in millimetres, or HO3D's 3 "
                      "of 8, of which blue is 0", path, img.channels, img.bits, img.channels == 3 ? ", a picture" : "");
    if (!st)
        st = lt_arena_try(arena, n * sizeof(*depth), (void **)&depth);
    if (st)
        return st;
    for (size_t i = 0; i < n; i++)
        depth[i] = metres(&img, i);
    *out = depth;
    return LT_OK;
}
