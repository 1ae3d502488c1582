/* SPDX-License-Identifier: Apache-2.0 */
/* A view's photo and mask, as a pinhole camera would have taken them. */
#include "data/transforms/internal.h"

#include "libtensor/io/image/image.h"
#include "vision/undistort.h"

#include <string.h>

static lt_status no_memory(const char *path)
{
    return lt_error(LT_ENOMEM, "%s: no memory for it", path);
}

static uint8_t eight_bits(const lt_image *im, int64_t i)
{
    return im->bits == 16 ? (uint8_t)(((const uint16_t *)(const void *)im->data)[i] >> 8)
                          : ((const uint8_t *)im->data)[i];
}

/* Gray or colour of any depth, over the background where there is alpha, which becomes the mask */
static lt_status spread(lt_arena *arena, const char *path, const lt_image *im, bool white, transforms_picture *p)
{
    const size_t pixels = (size_t)im->width * (size_t)im->height;
    const int colours = im->channels >= 3 ? 3 : 1;
    const bool alpha = im->channels == 2 || im->channels == 4;

    p->rgb = lt_arena_array(arena, pixels, 3);
    p->mask = alpha ? lt_arena_array(arena, pixels, 1) : NULL;
    if (!p->rgb || (alpha && !p->mask))
        return no_memory(path);
    for (size_t i = 0; i < pixels; i++) {
        const int64_t at = (int64_t)i * im->channels;
        const int a = alpha ? eight_bits(im, at + colours) : 255;

        for (int k = 0; k < 3; k++)
            p->rgb[3 * i + (size_t)k] = (uint8_t)((eight_bits(im, at + (colours == 3 ? k : 0)) * a
                                                   + (white ? 255 : 0) * (255 - a) + 127) / 255);
        if (alpha)
            p->mask[i] = a >= 128 ? 255 : 0;
    }
    p->width = im->width;
    p->height = im->height;
    return LT_OK;
}

static lt_status read_mask(lt_arena *arena, const char *path, transforms_picture *p)
{
    lt_image im;
    lt_status st = lt_image_read(arena, path, &im);

    if (!st && (im.width != p->width || im.height != p->height))
        st = lt_error(LT_EFORMAT, "%s: is %d x %d, its image %d x %d", path, im.width, im.height, p->width, p->height);
    if (st)
        return st;
    p->mask = lt_arena_array(arena, (size_t)p->width, (size_t)p->height);
    if (!p->mask)
        return no_memory(path);
    for (int64_t i = 0; i < (int64_t)p->width * p->height; i++)
        p->mask[i] = eight_bits(&im, i * im.channels) >= 128 ? 255 : 0;
    return LT_OK;
}

static lt_status straighten(lt_arena *arena, const transforms_view *v, transforms_picture *p)
{
    const undistortion u = { p->camera, v->lens.lens, p->width, p->height };
    const size_t pixels = (size_t)p->width * (size_t)p->height;
    uint8_t *out = lt_arena_array(arena, pixels, 3), *mask = lt_arena_array(arena, pixels, 3);

    if (lt_lens_is_none(&v->lens.lens))
        return LT_OK;
    if (!out || !mask)
        return no_memory(v->image);
    undistort_rgb(&u, p->rgb, out);
    p->rgb = out;
    if (!p->mask)
        return LT_OK;
    for (size_t i = 0; i < 3 * pixels; i++)
        mask[i] = p->mask[i / 3];
    out = lt_arena_array(arena, pixels, 3);
    if (!out)
        return no_memory(v->image);
    undistort_rgb(&u, mask, out);
    for (size_t i = 0; i < pixels; i++)
        p->mask[i] = out[3 * i] >= 128 ? 255 : 0;
    return LT_OK;
}

/* Means of squares of `by` pixels; what is left over at the right and below is cut off. In place. */
static void shrink(uint8_t *x, int width, int height, int channels, int by)
{
    for (int r = 0; r < height / by; r++)
        for (int c = 0; c < width / by; c++)
            for (int k = 0; k < channels; k++) {
                int sum = 0;

                for (int i = 0; i < by * by; i++)
                    sum += x[((int64_t)(r * by + i / by) * width + c * by + i % by) * channels + k];
                x[((int64_t)r * (width / by) + c) * channels + k] = (uint8_t)((sum + by * by / 2) / (by * by));
            }
}

static void shrink_picture(transforms_picture *p, int by)
{
    lt_camera *k = &p->camera;

    shrink(p->rgb, p->width, p->height, 3, by);
    if (p->mask) {
        shrink(p->mask, p->width, p->height, 1, by);
        for (int64_t i = 0; i < (int64_t)(p->width / by) * (p->height / by); i++)
            p->mask[i] = p->mask[i] >= 128 ? 255 : 0;
    }
    *k = (lt_camera){ k->fx / by, k->fy / by, (k->cx + 0.5) / by - 0.5, (k->cy + 0.5) / by - 0.5 };
    p->width /= by;
    p->height /= by;
}

lt_status transforms_read(lt_arena *arena, const transforms_view *v, int downscale, bool white,
                          transforms_picture *out)
{
    transforms_picture p = { .width = 0 };
    lt_image im;
    lt_status st = lt_image_read(arena, v->image, &im);

    if (!st && (im.width < downscale || im.height < downscale))
        st = lt_error(LT_EFORMAT, "%s: is %d x %d: too small to be made %d times smaller", v->image, im.width,
                      im.height, downscale);
    if (!st)
        st = spread(arena, v->image, &im, white, &p);
    if (!st && v->mask)
        st = read_mask(arena, v->mask, &p);
    if (!st)
        st = transforms_camera(v, p.width, p.height, &p.camera);
    if (!st)
        st = straighten(arena, v, &p);
    if (st)
        return st;
    if (downscale > 1)
        shrink_picture(&p, downscale);
    *out = p;
    return LT_OK;
}
