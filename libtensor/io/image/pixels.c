/* SPDX-License-Identifier: Apache-2.0 */
/* Images in memory: limits, sizes, conversion. */
#include "libtensor/io/image/codec.h"

size_t lt_image_bytes(const lt_image *img)
{
    return (size_t)img->width * (size_t)img->height * (size_t)img->channels * (size_t)(img->bits / 8);
}

lt_status lt_image_check(const char *name, uint64_t width, uint64_t height)
{
    if (width < 1 || height < 1 || width > LT_IMAGE_MAX_SIDE || height > LT_IMAGE_MAX_SIDE ||
        width * height > LT_IMAGE_MAX_PIXELS)
        return lt_error(LT_EFORMAT, "%s: image of %ju x %ju pixels, want 1 to %d a side and at most %d",
                        name, (uintmax_t)width, (uintmax_t)height, LT_IMAGE_MAX_SIDE,
                        LT_IMAGE_MAX_PIXELS);
    return LT_OK;
}

lt_status lt_image_init(lt_arena *arena, int width, int height, int channels, int bits, lt_image *out)
{
    lt_image img = { .width = width, .height = height, .channels = channels, .bits = bits };
    void *data;
    lt_status st;

    if (width < 1 || height < 1 || width > LT_IMAGE_MAX_SIDE || height > LT_IMAGE_MAX_SIDE ||
        (int64_t)width * height > LT_IMAGE_MAX_PIXELS ||
        (channels != 1 && channels != 3 && channels != 4) || (bits != 8 && bits != 16))
        return lt_error(LT_EINVAL, "image of %d x %d pixels, %d channels, %d bits cannot be made", width,
                        height, channels, bits);
    st = lt_arena_try(arena, lt_image_bytes(&img), &data);
    if (st)
        return st;
    img.data = data;
    *out = img;
    return LT_OK;
}

lt_status lt_image_to_rgb8(lt_arena *arena, const lt_image *img, lt_image *out)
{
    const size_t n = (size_t)img->width * (size_t)img->height, c = (size_t)img->channels;
    const uint16_t *wide = (const uint16_t *)(const void *)img->data;
    lt_image rgb;
    lt_status st;

    if (img->channels == 3 && img->bits == 8) {
        *out = *img;
        return LT_OK;
    }
    st = lt_image_init(arena, img->width, img->height, 3, 8, &rgb);
    if (st)
        return st;
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < 3; k++) {
            const size_t from = i * c + (c == 1 ? 0 : k);

            rgb.data[3 * i + k] = img->bits == 8 ? img->data[from] : (uint8_t)(wide[from] >> 8);
        }
    }
    *out = rgb;
    return LT_OK;
}
