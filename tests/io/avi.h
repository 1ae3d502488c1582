/* SPDX-License-Identifier: Apache-2.0 */
/* A film as small as one can be: JPEG pictures in a RIFF file.            [AVI RIFF File Reference, OpenDML 1.02] */
#ifndef TESTS_IO_AVI_H
#define TESTS_IO_AVI_H

#include "libtensor/io/image/image.h"

#include <check.h>
#include <stdio.h>
#include <string.h>

static inline void avi_u32(FILE *f, uint32_t x)
{
    for (int i = 0; i < 4; i++)
        fputc((int)(x >> (8 * i) & 255), f);
}

/* A chunk's or list's name and a size that avi_end fills in; returns where. */
static inline long avi_begin(FILE *f, const char *name, const char *kind)
{
    fputs(name, f);
    avi_u32(f, 0);
    fputs(kind, f);
    return ftell(f) - (long)strlen(kind);
}

static inline void avi_end(FILE *f, long start)
{
    const long end = ftell(f);

    fseek(f, start - 4, SEEK_SET);
    avi_u32(f, (uint32_t)(end - start));
    fseek(f, end, SEEK_SET);
    if ((end - start) % 2)
        fputc(0, f);
}

static inline void avi_headers(FILE *f, int width, int height, uint32_t fps, uint32_t n)
{
    const long list = avi_begin(f, "LIST", "hdrl");
    const uint32_t main[14] = { 1000000 / fps, 0, 0, 0x10, n, 0, 1, 1 << 20, (uint32_t)width, (uint32_t)height };
    const uint32_t stream[10] = { 0, 0, 0, 1, fps, 0, n, 1 << 20, UINT32_MAX, 0 };
    long chunk = avi_begin(f, "avih", ""), inner;

    for (int i = 0; i < 14; i++)
        avi_u32(f, main[i]);
    avi_end(f, chunk);
    inner = avi_begin(f, "LIST", "strl");
    chunk = avi_begin(f, "strh", "vidsMJPG");
    for (int i = 0; i < 10; i++)
        avi_u32(f, stream[i]);
    avi_u32(f, 0);
    avi_u32(f, (uint32_t)width | (uint32_t)height << 16);
    avi_end(f, chunk);
    chunk = avi_begin(f, "strf", "");
    avi_u32(f, 40);
    avi_u32(f, (uint32_t)width);
    avi_u32(f, (uint32_t)height);
    avi_u32(f, 1 | 24 << 16);
    fputs("MJPG", f);
    avi_u32(f, (uint32_t)(3 * width * height));
    for (int i = 0; i < 4; i++)
        avi_u32(f, 0);
    avi_end(f, chunk);
    avi_end(f, inner);
    avi_end(f, list);
}

/* n times the same picture */
static inline void avi_write(lt_arena *arena, const char *path, const lt_image *img, uint32_t fps, uint32_t n)
{
    FILE *f = fopen(path, "wb");
    uint32_t at[64];
    uint8_t *jpeg;
    size_t size;
    long riff, list, chunk;

    ck_assert(f && n <= 64);
    ck_assert_int_eq(lt_jpeg_encode(arena, img, 95, &jpeg, &size), LT_OK);
    riff = avi_begin(f, "RIFF", "AVI ");
    avi_headers(f, img->width, img->height, fps, n);
    list = avi_begin(f, "LIST", "movi");
    for (uint32_t i = 0; i < n; i++) {
        at[i] = (uint32_t)(ftell(f) - list);
        chunk = avi_begin(f, "00dc", "");
        fwrite(jpeg, 1, size, f);
        avi_end(f, chunk);
    }
    avi_end(f, list);
    chunk = avi_begin(f, "idx1", "");
    for (uint32_t i = 0; i < n; i++) {
        fputs("00dc", f);
        avi_u32(f, 0x10);
        avi_u32(f, at[i]);
        avi_u32(f, (uint32_t)size);
    }
    avi_end(f, chunk);
    avi_end(f, riff);
    fclose(f);
}

#endif
