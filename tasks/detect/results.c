/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/detect/results.h"

#include "libtensor/io/file.h"
#include "libtensor/io/image/coco_rle.h"
#include "libtensor/io/text/json.h"
#include "libtensor/io/text/json_object.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_BYTES ((size_t)4 << 30)

typedef struct { int64_t id, at; } numbered;

typedef struct {
    lt_arena *arena;
    const char *path;
    const detection_set *set;
    numbered *image;                /* sorted by id */
    detect_result *out;
} reading;

static int by_id(const void *a, const void *b)
{
    const int64_t x = ((const numbered *)a)->id, y = ((const numbered *)b)->id;

    return x < y ? -1 : x > y;
}

static lt_status number_images(reading *r)
{
    r->image = lt_arena_array(r->arena, (size_t)r->set->count + 1, sizeof(*r->image));
    if (!r->image)
        return lt_error(LT_ENOMEM, "%s: no memory", r->path);
    for (int64_t i = 0; i < r->set->count; i++)
        r->image[i] = (numbered){ r->set->image[i].id, i };
    qsort(r->image, (size_t)r->set->count, sizeof(*r->image), by_id);
    return LT_OK;
}

static bool number(const cJSON *in, const char *key, double *out)
{
    const cJSON *v = cJSON_GetObjectItemCaseSensitive(in, key);

    *out = cJSON_IsNumber(v) ? v->valuedouble : NAN;
    return isfinite(*out) && fabs(*out) < 9e15;
}

static int class_of(const detection_set *set, double id)
{
    for (int c = 0; c < set->classes; c++)
        if (id == (set->class_id ? (double)set->class_id[c] : c))
            return c;
    return -1;
}

static bool read_box(const cJSON *list, float box[4])
{
    double v[4];

    if (!cJSON_IsArray(list) || cJSON_GetArraySize(list) != 4)
        return false;
    for (int k = 0; k < 4; k++) {
        const cJSON *item = cJSON_GetArrayItem(list, k);

        if (!cJSON_IsNumber(item) || !(fabs(item->valuedouble) < 1e6))
            return false;
        v[k] = item->valuedouble;
    }
    for (int k = 0; k < 2; k++) {
        box[k] = (float)v[k];
        box[k + 2] = (float)(v[k] + v[k + 2]);
    }
    return true;
}

static bool is_side(const cJSON *v)
{
    return cJSON_IsNumber(v) && v->valuedouble >= 1 && v->valuedouble <= LT_IMAGE_MAX_SIDE;
}

/* Runs of the whole picture, whose size they say */
static bool read_mask(const reading *r, const cJSON *segmentation, const detection_image *image, detection_pixels *out)
{
    const cJSON *size = cJSON_GetObjectItemCaseSensitive(segmentation, "size");
    const char *counts = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(segmentation, "counts"));
    const cJSON *h = cJSON_GetArrayItem(size, 0), *w = cJSON_GetArrayItem(size, 1);

    if (!counts || !is_side(h) || !is_side(w))
        return false;
    if (w->valuedouble * h->valuedouble > LT_IMAGE_MAX_PIXELS)
        return false;
    if (image->width && (image->width != (int)w->valuedouble || image->height != (int)h->valuedouble))
        return false;
    *out = (detection_pixels){ 0, 0, (int)w->valuedouble, (int)h->valuedouble, NULL };
    out->pixel = lt_arena_array(r->arena, (size_t)out->x1 * (size_t)out->y1, 1);
    return out->pixel && lt_rle_decode(counts, out->y1, out->x1, out->pixel) == LT_OK;
}

static lt_status read_result(const reading *r, const cJSON *item, int i)
{
    const cJSON *segmentation = cJSON_GetObjectItemCaseSensitive(item, "segmentation");
    double image, category, score;
    detect_found f = { .cls = 0 };
    const numbered *at;
    detect_result *to;

    if (!number(item, "image_id", &image) || !number(item, "category_id", &category) || !number(item, "score", &score))
        return lt_error(LT_EFORMAT, "%s: [%d]: want numbers image_id, category_id and score", r->path, i);
    at = bsearch(&(numbered){ .id = (int64_t)image }, r->image, (size_t)r->set->count, sizeof(*at), by_id);
    f.cls = class_of(r->set, category);
    if (!at || f.cls < 0)
        return lt_error(LT_EFORMAT, "%s: [%d]: %s has no %s %.17g", r->path, i, r->set->list, at ? "category" : "image",
                        at ? category : image);
    if (!read_box(cJSON_GetObjectItemCaseSensitive(item, "bbox"), f.box))
        return lt_error(LT_EFORMAT, "%s: [%d].bbox: want x, y, width, height", r->path, i);
    if (segmentation && !read_mask(r, segmentation, &r->set->image[at->at], &f.window))
        return lt_error(LT_EFORMAT, "%s: [%d].segmentation: want size and counts, the runs of image %.17g", r->path, i,
                        image);
    f.score = score;
    to = &r->out[at->at];
    to->found = lt_arena_grow(r->arena, to->found, to->n, &to->room, sizeof(*to->found));
    if (!to->found)
        return lt_error(LT_ENOMEM, "%s: no memory", r->path);
    to->found[to->n++] = f;
    return LT_OK;
}

/* Item by item: the tree of all of them would take ten times the file. */
static lt_status read_items(const reading *r, const lt_file *file)
{
    lt_json_object items;
    lt_json_member m;
    bool more = true;
    lt_status st = lt_json_list_open(r->path, (const char *)file->bytes, file->n, &items);

    if (st)
        return lt_error(LT_EFORMAT, "%s: want a list of results, as COCO takes them", r->path);
    for (int i = 0; !st && !(st = lt_json_list_next(&items, &m, &more)) && more; i++) {
        char place[512];
        cJSON *item = NULL;

        snprintf(place, sizeof(place), "%s: [%d]", r->path, i);
        st = lt_json_parse(place, m.value, m.n, &item);
        st = st ? st : read_result(r, item, i);
        cJSON_Delete(item);
    }
    return st;
}

lt_status detect_results_read(lt_arena *arena, const char *path, const detection_set *set, detect_result **out)
{
    reading r = { .arena = arena, .path = path, .set = set,
                  .out = lt_arena_array(arena, (size_t)set->count + 1, sizeof(*r.out)) };
    lt_file file;
    lt_status st = lt_file_load(&file, path, MOST_BYTES);

    if (!st)
        st = r.out ? number_images(&r) : lt_error(LT_ENOMEM, "%s: no memory", path);
    st = st ? st : read_items(&r, &file);
    lt_file_free(&file);
    if (st == LT_OK)
        *out = r.out;
    return st;
}
