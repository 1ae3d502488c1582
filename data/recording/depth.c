/* SPDX-License-Identifier: Apache-2.0 */
/* Depth, packed: each row's differences from left to right, all low bytes and then all high ones, deflated. */
#include "data/recording/recording.h"

#include <zlib.h>

static lt_status no_memory(void)
{
    return lt_error(LT_ENOMEM, "no memory for a depth image");
}

lt_status recording_depth_pack(lt_arena *arena, const uint16_t *depth, int width, int height, uint8_t **bytes,
                               size_t *n)
{
    const size_t pixels = (size_t)width * (size_t)height;
    uLongf packed = compressBound(2 * pixels);
    uint8_t *planes = lt_arena_alloc(arena, 2 * pixels), *out = lt_arena_alloc(arena, packed);

    if (!planes || !out)
        return no_memory();
    for (size_t i = 0; i < pixels; i++) {
        const uint16_t d = (uint16_t)(depth[i] - (i % (size_t)width ? depth[i - 1] : 0));

        planes[i] = (uint8_t)d;
        planes[pixels + i] = (uint8_t)(d >> 8);
    }
    if (compress2(out, &packed, planes, 2 * pixels, 1) != Z_OK)
        return no_memory();
    *bytes = out;
    *n = packed;
    return LT_OK;
}

lt_status recording_depth_unpack(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, int width,
                                 int height,
                                 uint16_t *depth)
{
    const size_t pixels = (size_t)width * (size_t)height;
    uint8_t *planes = lt_arena_alloc(arena, 2 * pixels);
    uLongf found = 2 * pixels;

    if (!planes)
        return no_memory();
    if (uncompress(planes, &found, bytes, n) != Z_OK || found != 2 * pixels)
        return lt_error(LT_EFORMAT, "%s: no depth of %d x %d, or it is damaged", name, width, height);
    for (int y = 0; y < height; y++) {
        const uint8_t *low = planes + (size_t)y * (size_t)width, *high = low + pixels;
        uint16_t *row = depth + (size_t)y * (size_t)width;
        uint16_t last = 0;

        for (int x = 0; x < width; x++)
            row[x] = last = (uint16_t)(last + (low[x] | high[x] << 8));
    }
    return LT_OK;
}
