/* SPDX-License-Identifier: Apache-2.0 */
#include "data/detection/internal.h"
#include "data/detection/polygon.h"

#include "libtensor/io/file.h"
#include "libtensor/io/image/coco_rle.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

bool detection_probe(const char *root)
{
    lt_arena *arena = lt_arena_new();
    const char *name;
    const bool is = arena && (detection_coco_list(arena, root, "train", &name) ||
                              detection_coco_list(arena, root, "evaluation", &name) || detection_yaml(arena, root));

    lt_arena_free(arena);
    return is;
}

lt_status detection_fault(lt_arena *arena, detection_set *s, int64_t *counter, const char *line)
{
    ++*counter;
    if (s->first_fault)
        return LT_OK;
    s->first_fault = lt_arena_strdup(arena, line);
    return s->first_fault ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", s->root);
}

static void count_objects(detection_set *s)
{
    for (int64_t i = 0; i < s->count; i++) {
        s->objects += s->image[i].n;
        s->empty += s->image[i].n == 0;
        for (int k = 0; k < s->image[i].n; k++)
            s->masks += s->image[i].object[k].mask != DETECTION_NO_MASK;
    }
}

lt_status detection_open(lt_arena *arena, const char *root, const char *split, detection_set **out)
{
    detection_set *s = lt_arena_alloc(arena, sizeof(*s));
    lt_status st;

    if (!s)
        return lt_error(LT_ENOMEM, "%s: no memory", root);
    *s = (detection_set){ .root = lt_arena_strdup(arena, root), .split = lt_arena_strdup(arena, split), .seed = -1 };
    if (!s->root || !s->split)
        return lt_error(LT_ENOMEM, "%s: no memory", root);
    if (detection_yaml(arena, root))
        st = detection_yolo_open(arena, root, split, s);
    else
        st = detection_coco_open(arena, root, split, s);
    if (st)
        return st;
    if (!s->count)
        return lt_error(LT_EFORMAT, "%s: no image of \"%s\" can be used%s%s", s->list, split,
                        s->first_fault ? "; the first: " : "", s->first_fault ? s->first_fault : "");
    count_objects(s);
    *out = s;
    return LT_OK;
}

const char *detection_summary(lt_arena *arena, const detection_set *s)
{
    return lt_arena_printf(arena, "%" PRId64 " images with %" PRId64 " objects of %d classes, %" PRId64 " with masks; %"
                           PRId64 " without objects, %" PRId64 " not there, %" PRId64 " with labels that cannot be, %"
                           PRId64 " objects left out%s%s", s->count, s->objects, s->classes, s->masks, s->empty,
                           s->missing, s->corrupt, s->dropped, s->first_fault ? "; the first: " : "",
                           s->first_fault ? s->first_fault : "");
}

/* ---- reading ---- */

/* Shares of width and height become pixels. */
static lt_status to_pixels(lt_arena *arena, const detection_image *image, int width, int height, detection_object *list)
{
    const float size[2] = { (float)width, (float)height };

    for (int i = 0; i < image->n; i++) {
        detection_object *o = &list[i];
        int corners = 0;
        float *point;

        for (int k = 0; k < 4; k++)
            o->box[k] = fminf(fmaxf(o->box[k] * size[k % 2], 0), size[k % 2]);
        o->area = (double)(o->box[2] - o->box[0]) * (double)(o->box[3] - o->box[1]);
        for (int k = 0; k < o->n_polygons; k++)
            corners += o->corners[k];
        point = lt_arena_array(arena, (size_t)corners * 2 + 1, sizeof(*point));
        if (!point)
            return lt_error(LT_ENOMEM, "%s: no memory", image->path);
        for (int k = 0; k < 2 * corners; k++)
            point[k] = o->point[k] * size[k % 2];
        o->point = point;
    }
    return LT_OK;
}

lt_status detection_objects(const detection_set *s, int64_t i, int width, int height, lt_arena *arena,
                            const detection_object **out)
{
    const detection_image *image = &s->image[i];
    detection_object *list;

    *out = image->object;
    if (image->width && (width != image->width || height != image->height))
        return lt_error(LT_EFORMAT, "%s: has %d x %d pixels, %s says %d x %d", image->path, width, height, s->list,
                        image->width, image->height);
    if (image->width)
        return LT_OK;
    list = lt_arena_array(arena, (size_t)image->n + 1, sizeof(*list));
    if (!list)
        return lt_error(LT_ENOMEM, "%s: no memory", image->path);
    if (image->n)
        memcpy(list, image->object, (size_t)image->n * sizeof(*list));
    *out = list;
    return to_pixels(arena, image, width, height, list);
}

lt_status detection_read(const detection_set *s, int64_t i, lt_arena *arena, detection_sample *out)
{
    const detection_image *image = &s->image[i];
    lt_image read;
    lt_status st = lt_image_read(arena, image->path, &read);

    *out = (detection_sample){ .image = image, .n = image->n };
    if (st == LT_OK)
        st = lt_image_to_rgb8(arena, &read, &out->rgb);
    return st ? st : detection_objects(s, i, out->rgb.width, out->rgb.height, arena, &out->object);
}

/* ---- masks ---- */

static void fill_box(const float box[4], int width, int height, uint8_t *mask)
{
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            mask[(size_t)y * (size_t)width + (size_t)x] = (float)x + 0.5f > box[0] && (float)x + 0.5f < box[2]
                                                          && (float)y + 0.5f > box[1] && (float)y + 0.5f < box[3];
}

lt_status detection_mask(const detection_object *o, int width, int height, uint8_t *mask)
{
    const float *point = o->point;

    if (o->mask == DETECTION_RLE)
        return lt_rle_decode(o->rle, height, width, mask);
    memset(mask, 0, (size_t)width * (size_t)height);
    if (o->mask == DETECTION_NO_MASK)
        fill_box(o->box, width, height, mask);
    for (int i = 0; o->mask == DETECTION_POLYGONS && i < o->n_polygons; point += 2 * o->corners[i++])
        polygon_fill(point, o->corners[i], o->border, width, height, mask);
    return LT_OK;
}
