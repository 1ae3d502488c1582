/* SPDX-License-Identifier: Apache-2.0 */
/*
 * JPEG, over libjpeg-turbo with limits. libjpeg reports errors by a function that must not return: ours
 * jumps, so what must survive lives in a struct of the caller's.
 */
#include "libtensor/io/image/codec.h"

#include "libtensor/io/atomic_file.h"
#include "libtensor/io/image/write.h"
#include "libtensor/io/kind.h"

#include <errno.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jpeglib.h>
#include <jerror.h>

/* A progressive file may repeat scans for ever, each in a few bytes. Real ones have 6 to 20; small pictures may have
 * more of them, up to so many pixels in all scans. */
enum { SCANS_MAX = 500, SCANS_OF_ANY = 24, SCANNED_MAX = 1 << 28, PIXELS_PER_BYTE = 512, PADDING_MAX = 64 };

/* The first member of each is what libjpeg hands back to us. */
typedef struct {
    struct jpeg_error_mgr base;
    jmp_buf jump;
    bool may_end;                   /* behind the only scan: the file, without a marker that says so */
    char message[JMSG_LENGTH_MAX];
} error_state;

typedef struct {
    struct jpeg_decompress_struct jpeg;
    error_state error;
    struct jpeg_progress_mgr progress;
    lt_arena *arena;
    const char *name;
    size_t n;
    lt_image img;
    uint8_t *inks;                  /* a row of CMYK, or NULL */
} decoder;

static void on_error(j_common_ptr jpeg)
{
    error_state *e = (error_state *)jpeg->err;

    e->base.format_message(jpeg, e->message);
    longjmp(e->jump, 1);
}

/* Warnings (level -1) mean that data is missing or damaged, but for a few that cameras earn. A file that ends in the
 * middle of its only scan earns JWRN_HIT_MARKER as well. */
static void on_message(j_common_ptr jpeg, int level)
{
    const error_state *e = (error_state *)jpeg->err;
    const int code = e->base.msg_code;

    if (level < 0 && code != JWRN_EXTRANEOUS_DATA && code != JWRN_ADOBE_XFORM &&
        code != JWRN_JFIF_MAJOR && !(code == JWRN_JPEG_EOF && e->may_end))
        on_error(jpeg);
}

static void on_output(j_common_ptr jpeg)
{
    (void)jpeg;
}

static void on_progress(j_common_ptr jpeg)
{
    const struct jpeg_decompress_struct *d = (j_decompress_ptr)jpeg;
    error_state *e = (error_state *)jpeg->err;
    const int64_t pixels = (int64_t)d->image_width * d->image_height, scans = d->input_scan_number;

    if (scans <= SCANS_OF_ANY || (scans <= SCANS_MAX && scans * pixels <= SCANNED_MAX))
        return;
    snprintf(e->message, sizeof(e->message), "more than %jd scans of %jd pixels", (intmax_t)scans - 1,
             (intmax_t)pixels);
    longjmp(e->jump, 1);
}

static struct jpeg_error_mgr *init_errors(error_state *e)
{
    jpeg_std_error(&e->base);
    e->base.error_exit = on_error;
    e->base.emit_message = on_message;
    e->base.output_message = on_output;
    return &e->base;
}

/* Each block of 64 pixels costs a bit at the very least, so a small file cannot be a huge image. */
static lt_status check_header(const decoder *d)
{
    const uint64_t width = d->jpeg.image_width, height = d->jpeg.image_height;
    const int components = d->jpeg.num_components;
    lt_status st = lt_image_check(d->name, width, height);

    if (st)
        return st;
    if (width * height / PIXELS_PER_BYTE > d->n)
        return lt_error(LT_EFORMAT, "%s: %ju x %ju pixels cannot be in %zu bytes", d->name,
                        (uintmax_t)width, (uintmax_t)height, d->n);
    if (components != 1 && components != 3 && components != 4)
        return lt_error(LT_EFORMAT, "%s: JPEG of %d components, want gray, colour or CMYK", d->name, components);
    return LT_OK;
}

/* Room for the pixels, and what they are asked for as. */
static lt_status make_room(decoder *d)
{
    const int width = (int)d->jpeg.image_width, components = d->jpeg.num_components;
    lt_status st = lt_image_init(d->arena, width, (int)d->jpeg.image_height, components == 1 ? 1 : 3, 8, &d->img);

    d->jpeg.out_color_space = components == 1 ? JCS_GRAYSCALE : components == 3 ? JCS_RGB : JCS_CMYK;
    if (!st && components == 4)
        st = lt_arena_try(d->arena, 4 * (size_t)width, (void **)&d->inks);
    return st ? lt_error_prefix(st, "%s", d->name) : LT_OK;
}

/* Inks are stored as Adobe does, 255 for none; each takes its share of the light. */
static void mix_inks(const uint8_t *cmyk, uint8_t *rgb, int width)
{
    for (int x = 0; x < width; x++, cmyk += 4, rgb += 3)
        for (int k = 0; k < 3; k++)
            rgb[k] = (uint8_t)((cmyk[k] * cmyk[3] + 127) / 255);
}

static void read_rows(decoder *d)
{
    const size_t row = lt_image_bytes(&d->img) / (size_t)d->img.height;

    while (d->jpeg.output_scanline < d->jpeg.output_height) {
        uint8_t *out = d->img.data + d->jpeg.output_scanline * row;
        JSAMPROW read = d->inks ? d->inks : out;

        jpeg_read_scanlines(&d->jpeg, &read, 1);
        if (d->inks)
            mix_inks(d->inks, out, d->img.width);
    }
}

/* In its last marker, with a few bytes of padding perhaps: what is bad in one that does not was never all of it. */
static bool ends_whole(const uint8_t *bytes, size_t n)
{
    for (size_t i = n; i-- > 1 && n - i < PADDING_MAX;)
        if (bytes[i - 1] == 0xff && bytes[i] == JPEG_EOI)
            return true;
    return false;
}

static lt_status run_decoder(decoder *d, const uint8_t *bytes)
{
    lt_status st;

    if (setjmp(d->error.jump))
        return errno != ENOMEM && !ends_whole(bytes, d->n)
            ? lt_refuse_cut(d->name, LT_KIND_JPEG, "ends after %zu bytes", d->n)
            : lt_error(lt_decoder_status(errno), "%s: bad JPEG: %s", d->name, d->error.message);
    errno = 0;
    jpeg_create_decompress(&d->jpeg);
    d->progress.progress_monitor = on_progress;
    d->jpeg.progress = &d->progress;
    jpeg_mem_src(&d->jpeg, bytes, d->n);
    jpeg_read_header(&d->jpeg, TRUE);
    st = check_header(d);
    st = st ? st : make_room(d);
    if (st)
        return st;
    d->jpeg.dct_method = JDCT_ISLOW;
    d->error.may_end = !jpeg_has_multiple_scans(&d->jpeg) && !d->jpeg.arith_code;   /* that code reads on in zeros */
    jpeg_start_decompress(&d->jpeg);
    read_rows(d);
    jpeg_finish_decompress(&d->jpeg);
    return LT_OK;
}

lt_status lt_jpeg_decode(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_image *out)
{
    decoder d = { .arena = arena, .name = name, .n = n };
    lt_status st;

    d.jpeg.err = init_errors(&d.error);
    st = run_decoder(&d, bytes);
    if (!st)
        *out = d.img;
    jpeg_destroy_decompress(&d.jpeg);
    return st;
}

/* ---- writing ------------------------------------------------------------------------------------- */

typedef struct {
    struct jpeg_compress_struct jpeg;
    error_state error;
    unsigned char *bytes;           /* malloced by libjpeg */
    unsigned long n;
} encoder;

static bool run_encoder(encoder *e, const lt_image *img, int quality)
{
    const size_t row = lt_image_bytes(img) / (size_t)img->height;

    if (setjmp(e->error.jump))
        return false;
    jpeg_create_compress(&e->jpeg);
    jpeg_mem_dest(&e->jpeg, &e->bytes, &e->n);
    e->jpeg.image_width = (JDIMENSION)img->width;
    e->jpeg.image_height = (JDIMENSION)img->height;
    e->jpeg.input_components = img->channels;
    e->jpeg.in_color_space = img->channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_set_defaults(&e->jpeg);
    jpeg_set_quality(&e->jpeg, quality, TRUE);
    e->jpeg.dct_method = JDCT_ISLOW;
    e->jpeg.comp_info[0].h_samp_factor = 1;     /* 4:4:4 */
    e->jpeg.comp_info[0].v_samp_factor = 1;
    jpeg_start_compress(&e->jpeg, TRUE);
    while (e->jpeg.next_scanline < e->jpeg.image_height) {
        JSAMPROW in = img->data + e->jpeg.next_scanline * row;

        jpeg_write_scanlines(&e->jpeg, &in, 1);
    }
    jpeg_finish_compress(&e->jpeg);
    return true;
}

lt_status lt_jpeg_encode(lt_arena *arena, const lt_image *img, int quality, uint8_t **bytes, size_t *n)
{
    encoder e = { .bytes = NULL };
    lt_status st = LT_OK;
    void *copy;

    if (img->bits != 8 || img->channels == 4 || quality < 1 || quality > 100)
        return lt_error(LT_EINVAL, "JPEG of %d channels, %d bits, quality %d: want 1 or 3 channels of 8 "
                        "bits, quality 1..100", img->channels, img->bits, quality);
    e.jpeg.err = init_errors(&e.error);
    if (!run_encoder(&e, img, quality))
        st = lt_error(LT_ENOMEM, "cannot encode JPEG: %s", e.error.message);
    else
        st = lt_arena_try(arena, e.n, &copy);
    if (!st) {
        memcpy(copy, e.bytes, e.n);
        *bytes = copy;
        *n = e.n;
    }
    jpeg_destroy_compress(&e.jpeg);
    free(e.bytes);
    return st;
}

lt_status lt_jpeg_write(const char *path, const lt_image *img, int quality)
{
    lt_arena *arena = lt_arena_new();
    uint8_t *bytes;
    lt_status st;
    size_t n;

    if (!arena)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    st = lt_jpeg_encode(arena, img, quality, &bytes, &n);
    st = st ? lt_error_prefix(st, "%s", path) : lt_write_file(path, bytes, n);
    lt_arena_free(arena);
    return st;
}
