/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/info/detection.h"

#include "data/detection/detection.h"
#include "libtensor/base/arena.h"

#include <cjson/cJSON.h>

static void add_classes(const detection_set *s, cJSON *split)
{
    cJSON *classes = cJSON_AddObjectToObject(split, "objects of each class");

    for (int c = 0; c < s->classes; c++) {
        int64_t n = 0;

        for (int64_t i = 0; i < s->count; i++)
            for (int k = 0; k < s->image[i].n; k++)
                n += s->image[i].object[k].cls == c;
        cJSON_AddNumberToObject(classes, s->class_name[c], (double)n);
    }
}

static void add_split(const detection_set *s, cJSON *splits)
{
    cJSON *split = cJSON_AddObjectToObject(splits, s->split);

    cJSON_AddNumberToObject(split, "images", (double)s->count);
    cJSON_AddNumberToObject(split, "objects", (double)s->objects);
    cJSON_AddNumberToObject(split, "with masks", (double)s->masks);
    cJSON_AddNumberToObject(split, "images without objects", (double)s->empty);
    cJSON_AddNumberToObject(split, "images that are not there", (double)s->missing);
    cJSON_AddNumberToObject(split, "images whose labels cannot be", (double)s->corrupt);
    cJSON_AddNumberToObject(split, "objects left out", (double)s->dropped);
    if (s->first_fault)
        cJSON_AddStringToObject(split, "the first of these", s->first_fault);
    add_classes(s, split);
}

lt_status info_detection(const char *data, struct cJSON *root)
{
    static const char *const names[] = { "train", "evaluation" };
    lt_arena *arena = lt_arena_new();
    cJSON *splits = NULL;
    lt_status st = arena ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", data);

    for (size_t i = 0; i < LT_COUNT(names) && st != LT_ENOMEM; i++) {
        detection_set *s;

        st = detection_open(arena, data, names[i], &s);
        if (st)
            continue;
        if (!splits) {
            cJSON_AddStringToObject(root, "dataset", s->title);
            cJSON_AddBoolToObject(root, "synthetic", s->synthetic);
            splits = cJSON_AddObjectToObject(root, "splits");
        }
        add_split(s, splits);
    }
    lt_arena_free(arena);
    return splits ? LT_OK : st;
}
