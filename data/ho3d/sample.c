/* SPDX-License-Identifier: Apache-2.0 */
/* A sample of an HO3D tree: its images, and its annotation. */
#include "data/ho3d/internal.h"

#include "vision/picture.h"

#include <string.h>
#include <unistd.h>

static lt_status rgb_path(const ho3d *h, int64_t index, lt_arena *arena, const char **out)
{
    *out = ho3d_picture(h, index, arena, "rgb");
    if (!*out)
        return lt_error(LT_ENOMEM, "%s: no memory", h->name[index]);
    if (access(*out, F_OK))
        return lt_error(LT_EIO, "%.*s.png: no such file, nor %s.jpg", (int)(strrchr(*out, '.') - *out), *out,
                        strchr(h->name[index], '/') + 1);
    return LT_OK;
}

static lt_status read_rgb(const ho3d *h, int64_t index, lt_arena *arena, dataset_sample *s)
{
    const char *path = NULL;
    lt_image img;
    lt_status st = rgb_path(h, index, arena, &path);

    if (!st)
        st = picture_read_rgb(arena, path, h->width, h->height, &img);
    if (st)
        return st;
    s->rgb = img.data;
    s->width = img.width;
    s->height = img.height;
    return LT_OK;
}

static lt_status read_depth(const ho3d *h, int64_t index, lt_arena *arena, dataset_sample *s)
{
    const char *path = ho3d_picture(h, index, arena, "depth");
    float *depth;
    const lt_status st = path ? picture_read_depth(arena, path, h->width, h->height, &depth)
                              : lt_error(LT_ENOMEM, "%s: no memory", h->name[index]);

    if (st)
        return st;
    s->depth = depth;
    s->flags |= SAMPLE_DEPTH;
    return LT_OK;
}

lt_status ho3d_read_sample(const dataset *d, int64_t index, unsigned want, lt_arena *arena, dataset_sample *out)
{
    const ho3d *h = (const ho3d *)d;
    dataset_sample s = { .name = h->name[index], .object = -1 };
    lt_status st = ho3d_read_meta(h, index, arena, &s);

    if (!st)
        st = dataset_project(d, &s);
    if (!st)
        st = read_rgb(h, index, arena, &s);
    if (!st && (want & SAMPLE_DEPTH))
        st = read_depth(h, index, arena, &s);
    if (!st && (want & SAMPLE_SEGMENTS))
        st = ho3d_read_segments(h, index, arena, &s);
    if (!st && (want & SAMPLE_OBJECT) && s.object >= 0)
        st = dataset_draw_silhouette(d, arena, &s);
    if (!st)
        *out = s;
    return st;
}
