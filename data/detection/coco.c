/* SPDX-License-Identifier: Apache-2.0 */
/* A file of COCO's instances: images, annotations, categories. */
#include "data/detection/internal.h"

#include "libtensor/io/file.h"
#include "libtensor/io/image/coco_rle.h"
#include "libtensor/io/text/json.h"
#include "libtensor/io/text/json_object.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_BYTES ((size_t)4 << 30)    /* of a file; COCO's largest has 470 MB */

enum { MAX_SIDE = LT_IMAGE_MAX_SIDE };

/* ---- what is being read ---- */

typedef struct { int64_t id, at; } numbered;

typedef struct {
    numbered *list;
    size_t n, room;
} id_list;

typedef struct {
    lt_arena *arena;
    const char *path, *images;
    detection_set *set;
    detection_image *image;
    const char **name;              /* of categories, as they stand */
    size_t images_room, names_room;
    id_list image_of, class_of;     /* sorted by id, once all are known */
    object_list *objects;           /* of each image */
} reading;

static int by_id(const void *a, const void *b)
{
    const int64_t x = ((const numbered *)a)->id, y = ((const numbered *)b)->id;

    return x < y ? -1 : x > y;
}

static int64_t find(const id_list *in, int64_t id)
{
    const numbered key = { .id = id }, *found = in->n ? bsearch(&key, in->list, in->n, sizeof(key), by_id) : NULL;

    return found ? found->at : -1;
}

static lt_status no_memory(const reading *r)
{
    return lt_error(LT_ENOMEM, "%s: no memory", r->path);
}

/* A whole number that a double holds exactly */
static bool whole(const cJSON *in, const char *key, int64_t lo, int64_t hi, int64_t *out)
{
    const cJSON *v = cJSON_GetObjectItemCaseSensitive(in, key);

    if (!cJSON_IsNumber(v) || !(v->valuedouble >= (double)lo && v->valuedouble <= (double)hi)
        || v->valuedouble != floor(v->valuedouble))
        return false;
    *out = (int64_t)v->valuedouble;
    return true;
}

#define MAX_ID (INT64_C(1) << 53)

/* The id of a list's next item */
static lt_status add_id(const reading *r, const char *what, const cJSON *item, int i, id_list *to)
{
    to->list = lt_arena_grow(r->arena, to->list, to->n, &to->room, sizeof(*to->list));
    if (!to->list)
        return no_memory(r);
    if (!whole(item, "id", -MAX_ID, MAX_ID, &to->list[to->n].id))
        return lt_error(LT_EFORMAT, "%s: %s[%d].id: want a whole number", r->path, what, i);
    to->list[to->n++].at = i;
    return LT_OK;
}

static lt_status sort_ids(const reading *r, const char *what, id_list *ids)
{
    if (ids->n)
        qsort(ids->list, ids->n, sizeof(*ids->list), by_id);
    for (size_t i = 1; i < ids->n; i++)
        if (ids->list[i].id == ids->list[i - 1].id)
            return lt_error(LT_EFORMAT, "%s: %s: the id %" PRId64 " is there twice", r->path, what, ids->list[i].id);
    return LT_OK;
}

/* ---- categories and images ---- */

static lt_status read_category(reading *r, const cJSON *item, int i)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(item, "name"));
    const lt_status st = add_id(r, "categories", item, i, &r->class_of);

    if (st)
        return st;
    r->name = lt_arena_grow(r->arena, r->name, (size_t)i, &r->names_room, sizeof(*r->name));
    if (!r->name)
        return no_memory(r);
    r->name[i] = text ? lt_arena_strdup(r->arena, text)
                      : lt_arena_printf(r->arena, "%" PRId64, r->class_of.list[i].id);
    return r->name[i] ? LT_OK : no_memory(r);
}

/* Classes count in the order of ids. */
static lt_status order_classes(reading *r)
{
    detection_set *s = r->set;
    const size_t n = r->class_of.n;
    const char **name = lt_arena_array(r->arena, n, sizeof(*name));
    int64_t *id = lt_arena_array(r->arena, n, sizeof(*id));
    const lt_status st = sort_ids(r, "categories", &r->class_of);

    if (st || !name || !id)
        return st ? st : no_memory(r);
    for (size_t c = 0; c < n; c++) {
        numbered *of = &r->class_of.list[c];

        id[c] = of->id;
        name[c] = r->name[of->at];
        of->at = (int64_t)c;
    }
    s->classes = (int)n;
    s->class_name = name;
    s->class_id = id;
    return n ? LT_OK : lt_error(LT_EFORMAT, "%s: categories: there are none", r->path);
}

static lt_status read_image(reading *r, const cJSON *item, int i)
{
    const char *file = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(item, "file_name"));
    int64_t width, height;
    const lt_status st = add_id(r, "images", item, i, &r->image_of);

    if (st)
        return st;
    if (!file || !lt_path_is_inside(file))
        return lt_error(LT_EFORMAT, "%s: images[%d].file_name: want the name of a file in %s", r->path, i, r->images);
    if (!whole(item, "width", 1, MAX_SIDE, &width) || !whole(item, "height", 1, MAX_SIDE, &height))
        return lt_error(LT_EFORMAT, "%s: images[%d] \"%s\": width and height: want whole numbers from 1 to %d", r->path,
                        i, file, MAX_SIDE);
    if (width * height > LT_IMAGE_MAX_PIXELS)
        return lt_error(LT_EFORMAT, "%s: images[%d] \"%s\": more than %d pixels", r->path, i, file,
                        LT_IMAGE_MAX_PIXELS);
    r->image = lt_arena_grow(r->arena, r->image, (size_t)i, &r->images_room, sizeof(*r->image));
    if (!r->image)
        return no_memory(r);
    r->image[i] = (detection_image){
        .id = r->image_of.list[i].id, .width = (int)width, .height = (int)height,
        .name = lt_arena_strdup(r->arena, file), .path = lt_path_join(r->arena, r->images, file),
    };
    return r->image[i].name && r->image[i].path ? LT_OK : no_memory(r);
}

/* ---- objects ---- */

/* x y of a polygon's corners into point; false: not pairs of finite numbers, or fewer than three */
static bool read_ring(const cJSON *list, float *point, int *corners)
{
    const cJSON *v;
    int n = 0;

    cJSON_ArrayForEach(v, list) {
        if (!cJSON_IsNumber(v) || !(fabs(v->valuedouble) < 1e6))
            return false;
        point[n++] = (float)v->valuedouble;
    }
    *corners = n / 2;
    return n >= 6 && n % 2 == 0;
}

static lt_status read_polygons(const reading *r, const cJSON *list, int i, detection_object *o)
{
    const int n = cJSON_GetArraySize(list);
    size_t numbers = 0;
    const cJSON *ring;
    float *point;
    int *corners;

    cJSON_ArrayForEach(ring, list)
        numbers += (size_t)cJSON_GetArraySize(ring);
    point = lt_arena_array(r->arena, numbers + 1, sizeof(*point));
    corners = lt_arena_array(r->arena, (size_t)n + 1, sizeof(*corners));
    if (!point || !corners)
        return no_memory(r);
    o->point = point;
    o->corners = corners;
    cJSON_ArrayForEach(ring, list) {
        if (!cJSON_IsArray(ring) || !read_ring(ring, point, &corners[o->n_polygons]))
            return lt_error(LT_EFORMAT, "%s: annotations[%d].segmentation[%d]: want x y of three corners and more",
                            r->path, i, o->n_polygons);
        point += 2 * corners[o->n_polygons++];
    }
    o->mask = n ? DETECTION_POLYGONS : DETECTION_NO_MASK;
    return LT_OK;
}

/* Runs as a list of numbers become the text that all others are; NULL: they do not add up to so many pixels. */
static const char *pack(const reading *r, const cJSON *runs, int64_t pixels)
{
    int64_t *run = lt_arena_array(r->arena, (size_t)cJSON_GetArraySize(runs) + 1, sizeof(*run)), left = pixels;
    const cJSON *v;
    size_t n = 0;

    cJSON_ArrayForEach(v, runs) {
        if (!run || !cJSON_IsNumber(v) || !(v->valuedouble >= 0 && v->valuedouble <= (double)left)
            || v->valuedouble != floor(v->valuedouble))
            return NULL;
        left -= run[n++] = (int64_t)v->valuedouble;
    }
    return run && !left ? lt_rle_of_runs(r->arena, run, n) : NULL;
}

static lt_status read_runs(const reading *r, const cJSON *segmentation, int i, const detection_image *image,
                           detection_object *o)
{
    const cJSON *size = cJSON_GetObjectItemCaseSensitive(segmentation, "size");
    const cJSON *counts = cJSON_GetObjectItemCaseSensitive(segmentation, "counts");
    const cJSON *h = cJSON_GetArrayItem(size, 0), *w = cJSON_GetArrayItem(size, 1);

    if (!cJSON_IsNumber(h) || !cJSON_IsNumber(w) || h->valuedouble != image->height || w->valuedouble != image->width)
        return lt_error(LT_EFORMAT, "%s: annotations[%d].segmentation.size: want [%d, %d], the height and width of "
                        "\"%s\"", r->path, i, image->height, image->width, image->name);
    if (cJSON_IsString(counts))
        o->rle = lt_arena_strdup(r->arena, counts->valuestring);
    else if (cJSON_IsArray(counts))
        o->rle = pack(r, counts, (int64_t)image->width * image->height);
    if (!o->rle)
        return lt_error(LT_EFORMAT, "%s: annotations[%d].segmentation.counts: want runs that add up to %d x %d pixels",
                        r->path, i, image->width, image->height);
    o->mask = DETECTION_RLE;
    return LT_OK;
}

/* x y width height; what lies outside the image is cut off. False: nothing is left */
static bool read_box(const cJSON *list, const detection_image *image, float box[4])
{
    const double limit[2] = { image->width, image->height };

    for (int k = 0; k < 2; k++) {
        const double at = cJSON_GetArrayItem(list, k)->valuedouble, side = cJSON_GetArrayItem(list, k + 2)->valuedouble;

        box[k] = (float)fmin(fmax(at, 0), limit[k]);
        box[k + 2] = (float)fmin(fmax(at + side, 0), limit[k]);
    }
    return box[2] > box[0] && box[3] > box[1];
}

static bool four_numbers(const cJSON *list)
{
    const cJSON *v;

    cJSON_ArrayForEach(v, list)
        if (!cJSON_IsNumber(v) || !(fabs(v->valuedouble) < 1e9))
            return false;
    return cJSON_IsArray(list) && cJSON_GetArraySize(list) == 4;
}

static lt_status add_object(reading *r, int64_t at, const detection_object *o)
{
    object_list *to = &r->objects[at];

    to->list = lt_arena_grow(r->arena, to->list, to->n, &to->room, sizeof(*to->list));
    if (!to->list)
        return no_memory(r);
    to->list[to->n++] = *o;
    return LT_OK;
}

static lt_status leave_out(reading *r, int i, const detection_image *image, const char *why)
{
    char line[512];

    snprintf(line, sizeof(line), "%s: annotations[%d].bbox: %s \"%s\"", r->path, i, why, image->name);
    return detection_fault(r->arena, r->set, &r->set->dropped, line);
}

static lt_status read_object(reading *r, const cJSON *item, int i)
{
    const cJSON *bbox = cJSON_GetObjectItemCaseSensitive(item, "bbox");
    const cJSON *area = cJSON_GetObjectItemCaseSensitive(item, "area");
    const cJSON *segmentation = cJSON_GetObjectItemCaseSensitive(item, "segmentation");
    const cJSON *crowd = cJSON_GetObjectItemCaseSensitive(item, "iscrowd");
    int64_t image_id, class_id, at, cls;
    detection_object o = { .cls = 0 };
    lt_status st = LT_OK;

    if (!whole(item, "image_id", -MAX_ID, MAX_ID, &image_id) || !whole(item, "category_id", -MAX_ID, MAX_ID, &class_id))
        return lt_error(LT_EFORMAT, "%s: annotations[%d]: image_id, category_id: want whole numbers", r->path, i);
    at = find(&r->image_of, image_id);
    cls = find(&r->class_of, class_id);
    if (at < 0 || cls < 0)
        return lt_error(LT_EFORMAT, "%s: annotations[%d]: no %s has the id %" PRId64, r->path, i,
                        at < 0 ? "image" : "category", at < 0 ? image_id : class_id);
    if (!four_numbers(bbox))
        return lt_error(LT_EFORMAT, "%s: annotations[%d].bbox: want x, y, width, height", r->path, i);
    if (!read_box(bbox, &r->image[at], o.box))
        return leave_out(r, i, &r->image[at], "nothing of it is inside");
    o.cls = (int)cls;
    o.crowd = cJSON_IsTrue(crowd) || (cJSON_IsNumber(crowd) && crowd->valuedouble != 0);
    if (cJSON_IsArray(segmentation))
        st = read_polygons(r, segmentation, i, &o);
    else if (cJSON_IsObject(segmentation))
        st = read_runs(r, segmentation, i, &r->image[at], &o);
    o.area = cJSON_IsNumber(area) && area->valuedouble >= 0 ? area->valuedouble
             : (double)(o.box[2] - o.box[0]) * (double)(o.box[3] - o.box[1]);
    return st ? st : add_object(r, at, &o);
}

/* ---- a file ---- */

/* Item by item: the tree of all of them would take ten times the file. */
static lt_status read_list(reading *r, const char *what, const lt_json_member *list,
                           lt_status (*read)(reading *r, const cJSON *item, int i))
{
    const char *name = lt_arena_printf(r->arena, "%s: %s", r->path, what);
    char place[512];
    lt_json_object items;
    lt_json_member m;
    bool more = true;
    lt_status st = name ? lt_json_list_open(name, list->value, list->n, &items) : no_memory(r);

    for (int i = 0; !st && !(st = lt_json_list_next(&items, &m, &more)) && more; i++) {
        cJSON *item = NULL;

        snprintf(place, sizeof(place), "%s[%d]", name, i);
        st = lt_json_parse(place, m.value, m.n, &item);
        st = st ? st : read(r, item, i);
        cJSON_Delete(item);
    }
    return st;
}

static lt_status read_lists(reading *r, const lt_json_member list[3])
{
    lt_status st = read_list(r, "categories", &list[0], read_category);

    st = st ? st : order_classes(r);
    st = st ? st : read_list(r, "images", &list[1], read_image);
    st = st ? st : sort_ids(r, "images", &r->image_of);
    if (st)
        return st;
    r->set->count = (int64_t)r->image_of.n;
    r->set->image = r->image;
    r->objects = lt_arena_array(r->arena, r->image_of.n, sizeof(*r->objects));
    if (!r->objects)
        return no_memory(r);
    st = read_list(r, "annotations", &list[2], read_object);
    for (size_t k = 0; k < r->image_of.n; k++) {
        r->image[k].object = r->objects[k].list;
        r->image[k].n = (int)r->objects[k].n;
    }
    return st;
}

/* What the file says of itself; anything may stand there. */
static lt_status read_info(const reading *r, const lt_json_member *m)
{
    cJSON *info;
    const lt_status st = lt_json_parse(r->path, m->value, m->n, &info);

    if (st)
        return st == LT_ENOMEM ? st : LT_OK;
    r->set->synthetic = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(info, "synthetic"));
    cJSON_Delete(info);
    return LT_OK;
}

/* Where the three lists stand in the text; of two of a name the first counts. */
static lt_status find_lists(const reading *r, const lt_file *file, lt_json_member list[3])
{
    static const char *const names[] = { "categories", "images", "annotations" };
    lt_json_object all;
    lt_json_member m;
    bool more = true, there = lt_json_object_open(r->path, (const char *)file->bytes, file->n, &all) == LT_OK;
    lt_status st = LT_OK;

    while (there && !st && !(st = lt_json_object_next(&all, r->arena, &m, &more)) && more) {
        for (int k = 0; k < 3; k++)
            if (strcmp(m.key, names[k]) == 0 && !list[k].value)
                list[k] = m;
        if (strcmp(m.key, "info") == 0)
            st = read_info(r, &m);
    }
    for (int k = 0; k < 3; k++)
        there = there && list[k].value && *list[k].value == '[';
    return st || there ? st : lt_error(LT_EFORMAT, "%s: want the lists images, annotations and categories, as COCO's "
                                       "instances have them", r->path);
}

lt_status detection_parse_coco(lt_arena *arena, const char *path, const char *images, detection_set *out)
{
    reading r = { .arena = arena, .path = path, .images = images, .set = out };
    lt_json_member list[3] = { { NULL, NULL, 0 } };
    lt_file file;
    lt_status st = lt_file_load(&file, path, MOST_BYTES);

    out->title = "COCO";
    out->list = path;
    st = st ? st : find_lists(&r, &file, list);
    st = st ? st : read_lists(&r, list);
    lt_file_free(&file);
    return st;
}
