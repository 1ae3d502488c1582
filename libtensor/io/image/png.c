/* SPDX-License-Identifier: Apache-2.0 */
/*
 * PNG, over libpng with limits. libpng reports errors by longjmp: what must survive one lives in a
 * struct of the caller's, and the functions that can be left that way own nothing.
 */
#include "libtensor/io/image/codec.h"

#include "libtensor/io/atomic_file.h"
#include "libtensor/io/image/write.h"
#include "libtensor/io/kind.h"

#include <errno.h>
#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <string.h>
#include <zlib.h>

enum { DEFLATE_RATIO = 1032, CHUNKS_MAX = 128, CHUNK_BYTES_MAX = 64 << 20 };

typedef struct {
    png_structp png;
    png_infop info;
    lt_arena *arena;
    const char *name;
    const uint8_t *bytes;
    size_t n, at;                   /* the input, and where we are in it */
    bool cut;                       /* more was wanted than it has */
    lt_image img;
    lt_status status;
    char message[128];
} decoder;

static void on_error(png_structp png, png_const_charp text)
{
    char *message = png_get_error_ptr(png);

    snprintf(message, sizeof(((decoder *)0)->message), "%s", text);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp text)
{
    (void)png;
    (void)text;
}

static void read_bytes(png_structp png, png_bytep out, size_t n)
{
    decoder *d = png_get_io_ptr(png);

    d->cut = n > d->n - d->at;
    if (d->cut)
        png_error(png, "ends early");
    memcpy(out, d->bytes + d->at, n);
    d->at += n;
}

/* Ask libpng for 8 or 16 bits of gray, RGB or RGBA, whatever the file holds. */
static void set_transforms(decoder *d)
{
    const int color = png_get_color_type(d->png, d->info);
    const bool has_trns = png_get_valid(d->png, d->info, PNG_INFO_tRNS) != 0;
    const bool gray = color == PNG_COLOR_TYPE_GRAY || color == PNG_COLOR_TYPE_GRAY_ALPHA;

    if (color == PNG_COLOR_TYPE_PALETTE)
        png_set_palette_to_rgb(d->png);
    if (color == PNG_COLOR_TYPE_GRAY)
        png_set_expand_gray_1_2_4_to_8(d->png);
    if (has_trns)
        png_set_tRNS_to_alpha(d->png);
    if (gray && (has_trns || color == PNG_COLOR_TYPE_GRAY_ALPHA))
        png_set_gray_to_rgb(d->png);
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    if (png_get_bit_depth(d->png, d->info) == 16)
        png_set_swap(d->png);
#endif
    png_set_interlace_handling(d->png);
}

/* The pixels before any transform cannot be more than deflate makes of all the bytes there are. */
static lt_status check_header(decoder *d)
{
    const uint64_t width = png_get_image_width(d->png, d->info);
    const uint64_t height = png_get_image_height(d->png, d->info);
    const uint64_t packed = png_get_rowbytes(d->png, d->info) * height;
    lt_status st = lt_image_check(d->name, width, height);

    if (!st && packed / DEFLATE_RATIO > d->n)
        return lt_error(LT_EFORMAT, "%s: %ju x %ju pixels cannot be in %zu bytes", d->name,
                        (uintmax_t)width, (uintmax_t)height, d->n);
    return st;
}

static lt_status read_rows(decoder *d)
{
    const size_t row = lt_image_bytes(&d->img) / (size_t)d->img.height;
    png_bytep *rows = lt_arena_array(d->arena, (size_t)d->img.height, sizeof(*rows));

    if (!rows)
        return lt_error(LT_ENOMEM, "%s: no memory for %d rows", d->name, d->img.height);
    for (int y = 0; y < d->img.height; y++)
        rows[y] = d->img.data + (size_t)y * row;
    png_read_image(d->png, rows);
    png_read_end(d->png, NULL);
    return LT_OK;
}

static lt_status run_decoder(decoder *d)
{
    if (setjmp(png_jmpbuf(d->png)))
        return d->cut ? lt_refuse_cut(d->name, LT_KIND_PNG, "ends after %zu bytes", d->n)
                      : lt_error(lt_decoder_status(errno), "%s: bad PNG: %s", d->name, d->message);
    errno = 0;
    png_set_user_limits(d->png, LT_IMAGE_MAX_SIDE, LT_IMAGE_MAX_SIDE);
    png_set_chunk_cache_max(d->png, CHUNKS_MAX);
    png_set_chunk_malloc_max(d->png, CHUNK_BYTES_MAX);
    png_set_keep_unknown_chunks(d->png, PNG_HANDLE_CHUNK_NEVER, NULL, -1);      /* nor known ones but pixels' own */
    png_set_read_fn(d->png, d, read_bytes);
    png_read_info(d->png, d->info);
    d->status = check_header(d);
    if (d->status)
        return d->status;
    set_transforms(d);
    png_read_update_info(d->png, d->info);
    d->status = lt_image_init(d->arena, (int)png_get_image_width(d->png, d->info),
                              (int)png_get_image_height(d->png, d->info),
                              png_get_channels(d->png, d->info), png_get_bit_depth(d->png, d->info),
                              &d->img);
    if (d->status)
        return lt_error_prefix(d->status, "%s", d->name);
    return read_rows(d);
}

lt_status lt_png_decode(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_image *out)
{
    decoder d = { .arena = arena, .name = name, .bytes = bytes, .n = n };
    lt_status st;

    d.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, d.message, on_error, on_warning);
    d.info = d.png ? png_create_info_struct(d.png) : NULL;
    if (d.info)
        st = run_decoder(&d);
    else
        st = lt_error(LT_ENOMEM, "%s: no memory", name);
    if (!st)
        *out = d.img;
    png_destroy_read_struct(&d.png, &d.info, NULL);
    return st;
}

/* ---- writing ------------------------------------------------------------------------------------- */

typedef struct {
    png_structp png;
    png_infop info;
    const lt_image *img;
    bool fast;
    char message[sizeof(((decoder *)0)->message)];
} encoder;

static void write_bytes(png_structp png, png_bytep bytes, size_t n)
{
    FILE *f = png_get_io_ptr(png);

    if (fwrite(bytes, 1, n, f) != n)
        png_error(png, "cannot write");
}

static void flush_nothing(png_structp png)
{
    (void)png;
}

/* Noise holds no repeats worth a search: runs and Huffman's code alone take an eighth of the time. */
static void set_fast(png_structp png)
{
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    png_set_compression_level(png, 1);
    png_set_compression_strategy(png, Z_RLE);
}

/* False when libpng gave up: the stream's error, which lt_atomic_commit finds again, or no memory. */
static bool run_encoder(encoder *e, FILE *f)
{
    const lt_image *img = e->img;
    const size_t row = lt_image_bytes(img) / (size_t)img->height;
    const int color = img->channels == 1 ? PNG_COLOR_TYPE_GRAY
                    : img->channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGB_ALPHA;

    if (setjmp(png_jmpbuf(e->png)))
        return false;
    png_set_write_fn(e->png, f, write_bytes, flush_nothing);
    if (e->fast)
        set_fast(e->png);
    png_set_IHDR(e->png, e->info, (png_uint_32)img->width, (png_uint_32)img->height, img->bits, color,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(e->png, e->info);
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    if (img->bits == 16)
        png_set_swap(e->png);
#endif
    for (int y = 0; y < img->height; y++)
        png_write_row(e->png, img->data + (size_t)y * row);
    png_write_end(e->png, e->info);
    return true;
}

static lt_status write_file(const char *path, const lt_image *img, bool fast)
{
    encoder e = { .img = img, .fast = fast };
    lt_atomic_file f;
    lt_status st = lt_atomic_open(&f, path);

    if (st)
        return st;
    e.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, e.message, on_error, on_warning);
    e.info = e.png ? png_create_info_struct(e.png) : NULL;
    if (e.info && (run_encoder(&e, f.stream) || ferror(f.stream))) {
        st = lt_atomic_commit(&f);
    } else {
        lt_atomic_abort(&f);
        st = lt_error(LT_ENOMEM, "%s: cannot encode PNG: %s", path, e.info ? e.message : "no memory");
    }
    png_destroy_write_struct(&e.png, &e.info);
    return st;
}

lt_status lt_png_write(const char *path, const lt_image *img)
{
    return write_file(path, img, false);
}

lt_status lt_png_write_fast(const char *path, const lt_image *img)
{
    return write_file(path, img, true);
}
