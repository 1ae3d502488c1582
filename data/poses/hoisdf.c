/* SPDX-License-Identifier: Apache-2.0 */
/*
 * HOISDF's pred_ho_pose.json: a member a frame. Its key is the image's path (HO3D), or a key of the annotation list
 * that HOISDF was run on (DexYCB), whose label_file is a path. The hand has no place of its own: HOISDF is given the
 * wrist.
 *
 *   mano_pose6d    48 axis-angle values, whatever its name says, of a flat hand
 *   mano_shape     10
 *   obj_rot        axis-angle
 *   obj_trans + obj_center_cam    metres, OpenCV's axes
 *
 * Source: amathislab/HOISDF; ru1ven/ArGS generate_init_HO3D.py, generate_init_DexYCB.py, which read them.
 */
#include "data/poses/pose_file.h"

#include "libtensor/geometry/rotation.h"
#include "libtensor/io/text/json.h"
#include "libtensor/io/text/json_object.h"

#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>

/* The annotation list by its keys, in order. */
typedef struct { const char *key, *label; } listed;
typedef struct { listed *item; size_t n, room; } label_list;

static int by_key(const void *a, const void *b)
{
    return strcmp(((const listed *)a)->key, ((const listed *)b)->key);
}

static lt_status add_label(lt_arena *arena, label_list *l, const char *key, const lt_json_member *m, const char *path)
{
    cJSON *value = NULL;
    const cJSON *label;
    lt_status st = lt_json_parse(path, m->value, m->n, &value);

    if (st)
        return st;
    label = cJSON_GetObjectItemCaseSensitive(value, "label_file");
    if (cJSON_IsString(label)) {
        l->item = lt_arena_grow(arena, l->item, l->n, &l->room, sizeof(*l->item));
        if (l->item)
            l->item[l->n++] = (listed){ key, lt_arena_strdup(arena, label->valuestring) };
        if (!l->item || !l->item[l->n - 1].label)
            st = lt_error(LT_ENOMEM, "%s: no memory", path);
    }
    cJSON_Delete(value);
    return st;
}

static lt_status read_list(lt_arena *arena, pose_text list, label_list *out)
{
    lt_json_object o;
    lt_json_member m;
    bool more = false;
    lt_status st = list.text ? lt_json_object_open(list.path, list.text, list.n, &o) : LT_OK;

    if (!list.text)
        return LT_OK;
    while (!st && !(st = lt_json_object_next(&o, arena, &m, &more)) && more)
        st = add_label(arena, out, m.key, &m, list.path);
    if (!st && !out->n)
        st = lt_error(LT_EFORMAT, "%s: no entry has a label_file, as DexYCB's annotation lists have", list.path);
    if (!st)
        qsort(out->item, out->n, sizeof(*out->item), by_key);
    return st;
}

/* Where the key is no path, the list has one. */
static lt_status frame_of(const pose_reader *r, const label_list *l, const char *key, const char **out)
{
    const listed want = { key, NULL };
    const listed *found = l->n ? bsearch(&want, l->item, l->n, sizeof(want), by_key) : NULL;

    *out = found ? found->label : key;
    if (!found && !strchr(key, '/'))
        return lt_error(LT_EFORMAT, "%s: is no path of an image, and %s; want the annotation list that HOISDF was run "
                        "on", r->name, l->n ? "not in the annotation list" : "no annotation list was named");
    return LT_OK;
}

static lt_status read_frame(pose_reader *r, const label_list *l, const lt_json_member *m)
{
    pose_record out = { .has_hand = true, .placed = POSE_BY_ANNOTATION, .has_object = true };
    double turn[3], centre[3];
    cJSON *frame = NULL;
    lt_status st;

    pose_reader_at(r, m->key);
    st = frame_of(r, l, m->key, &out.frame);
    if (!st)
        st = lt_json_parse(r->name, m->value, m->n, &frame);
    if (!st)
        st = pose_numbers(r, cJSON_GetObjectItemCaseSensitive(frame, "mano_pose6d"), "mano_pose6d", 48, out.pose);
    if (!st)
        st = pose_numbers(r, cJSON_GetObjectItemCaseSensitive(frame, "mano_shape"), "mano_shape", 10, out.beta);
    if (!st)
        st = pose_numbers(r, cJSON_GetObjectItemCaseSensitive(frame, "obj_rot"), "obj_rot", 3, turn);
    if (!st)
        st = pose_numbers(r, cJSON_GetObjectItemCaseSensitive(frame, "obj_trans"), "obj_trans", 3, out.t);
    if (!st)
        st = pose_numbers(r, cJSON_GetObjectItemCaseSensitive(frame, "obj_center_cam"), "obj_center_cam", 3, centre);
    cJSON_Delete(frame);
    if (st)
        return st;
    lt_rot_from_axis_angle(turn, out.R);
    for (int k = 0; k < 3; k++)
        out.t[k] += centre[k];
    return r->take(r->ctx, &out);
}

lt_status pose_read_hoisdf(pose_reader *r, pose_text list)
{
    lt_arena *arena = lt_arena_new();
    label_list labels = { NULL, 0, 0 };
    lt_json_object o;
    lt_json_member m;
    bool more = false;
    lt_status st = arena ? read_list(arena, list, &labels) : lt_error(LT_ENOMEM, "%s: no memory", r->file.path);

    if (!st)
        st = lt_json_object_open(r->file.path, r->file.text, r->file.n, &o);
    while (!st && !(st = lt_json_object_next(&o, r->scratch, &m, &more)) && more) {
        st = read_frame(r, &labels, &m);
        lt_arena_reset(r->scratch);
    }
    lt_arena_free(arena);
    return st;
}
