/* SPDX-License-Identifier: Apache-2.0 */
#include "data/action/action.h"

#include "libtensor/io/array/npy.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

const char *const action_classes[ACTION_CLASSES] = {
    "waving", "walking", "reaching", "crossing hands", "pointing", "waiting", "receiving", "placing", "handing over",
    "picking up",
};

static lt_status no_memory(const char *path)
{
    return lt_error(LT_ENOMEM, "%s: no memory", path);
}

/* ---- label.json ---- */

/* A list of whole numbers; fallback where it is missing and may be */
typedef struct {
    const char *key;
    int lo, hi;
    bool may_lack;
    int fallback;
} whole_list;

static lt_status take_list(const char *path, const cJSON *root, const whole_list *w, int64_t n, int *out)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(root, w->key), *item;
    int64_t i = 0;

    if (!list && w->may_lack) {
        for (i = 0; i < n; i++)
            out[i] = w->fallback;
        return LT_OK;
    }
    if (!cJSON_IsArray(list))
        return lt_error(LT_EFORMAT, "%s: has no list \"%s\"", path, w->key);
    cJSON_ArrayForEach(item, list) {
        const double x = cJSON_IsNumber(item) ? item->valuedouble : NAN;

        if (i >= n)
            break;
        if (!(x >= w->lo && x <= w->hi && x == floor(x)))
            return lt_error(LT_EFORMAT, "%s: %s[%lld]: expected a whole number from %d to %d", path, w->key,
                            (long long)i, w->lo, w->hi);
        out[i++] = (int)x;
    }
    if (item || i < n)
        return lt_error(LT_EFORMAT, "%s: \"%s\" has %d numbers, expected one for each of %lld clips", path, w->key,
                        cJSON_GetArraySize(list), (long long)n);
    return LT_OK;
}

static lt_status take_names(lt_arena *arena, const char *path, const cJSON *root, int64_t n, action_clip *clip)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(root, "names");

    item = cJSON_IsArray(item) ? item->child : NULL;
    for (int64_t i = 0; i < n; i++, item = item ? item->next : NULL) {
        clip[i].name = cJSON_IsString(item) ? lt_arena_strdup(arena, item->valuestring)
                                            : lt_arena_printf(arena, "%lld", (long long)i);
        if (!clip[i].name)
            return no_memory(path);
    }
    return LT_OK;
}

/* Numbers count within our ten classes, so other names of theirs would be other classes. */
static lt_status check_classes(const char *path, const cJSON *root)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(root, "classes"), *item;
    int i = 0;

    cJSON_ArrayForEach(item, list) {
        if (i >= ACTION_CLASSES || !cJSON_IsString(item) || strcmp(item->valuestring, action_classes[i]) != 0)
            return lt_error(LT_EFORMAT, "%s: classes[%d] is \"%.40s\", expected %s%s%s", path, i,
                            cJSON_IsString(item) ? item->valuestring : "?", i < ACTION_CLASSES ? "\"" : "",
                            i < ACTION_CLASSES ? action_classes[i] : "no more", i < ACTION_CLASSES ? "\"" : "");
        i++;
    }
    return LT_OK;
}

static lt_status take_labels(lt_arena *arena, const char *path, const cJSON *root, int64_t n, int length,
                             const action_clip **out)
{
    const whole_list lists[] = {
        { "labels", 0, ACTION_CLASSES - 1, false, 0 }, { "subject", 0, ACTION_MOST_SUBJECTS - 1, false, 0 },
        { "frames", 1, length, true, length }, { "onset", -1, length, true, -1 },
    };
    action_clip *clip = lt_arena_array(arena, (size_t)n, sizeof(*clip));
    int *number = lt_arena_array(arena, (size_t)n * LT_COUNT(lists), sizeof(*number));
    lt_status st = clip && number ? check_classes(path, root) : no_memory(path);

    for (size_t k = 0; !st && k < LT_COUNT(lists); k++)
        st = take_list(path, root, &lists[k], n, number + (int64_t)k * n);
    for (int64_t i = 0; !st && i < n; i++)
        clip[i] = (action_clip){ NULL, number[i], number[n + i], number[2 * n + i], number[3 * n + i] };
    if (!st)
        st = take_names(arena, path, root, n, clip);
    *out = clip;
    return st;
}

lt_status action_parse_labels(lt_arena *arena, const char *path, const char *text, size_t bytes, int64_t n, int length,
                              const action_clip **clip)
{
    cJSON *root;
    lt_status st = lt_json_parse(path, text, bytes, &root);

    if (st)
        return st;
    st = take_labels(arena, path, root, n, length, clip);
    cJSON_Delete(root);
    return st;
}

static lt_status read_labels(lt_arena *arena, action_set *set)
{
    const char *path = lt_path_join(arena, set->root, "label.json");
    uint8_t *text;
    size_t bytes;
    lt_status st = path ? lt_read_file(arena, path, LT_JSON_MAX, &text, &bytes) : no_memory(set->root);

    if (!st)
        st = action_parse_labels(arena, path, (const char *)text, bytes, set->n, set->length, &set->clip);
    for (int64_t i = 0; !st && i < set->n; i++)
        set->subjects = set->clip[i].subject >= set->subjects ? set->clip[i].subject + 1 : set->subjects;
    return st;
}

/* ---- arrays ---- */

static lt_status wrong_shape(const char *path, const lt_array *a, const char *want)
{
    char shape[128];

    return lt_error(LT_EFORMAT, "%s: is %s %s, expected %s", path, lt_elem_name(a->type),
                    lt_array_shape_text(a, shape, sizeof(shape)), want);
}

/* (N, 3, T, points) or, of one person, (N, 3, T, points, 1) */
static lt_status read_points(lt_arena *arena, const char *root, const char *name, int points, lt_array *a)
{
    const char *path = lt_path_join(arena, root, name);
    const int64_t five[] = { -1, 3, -1, points, 1 };
    lt_status st = path ? lt_npy_read(arena, path, a) : no_memory(root);

    if (st)
        return st;
    if (a->type != LT_ELEM_F4 || !(lt_array_has_shape(a, 5, five) || lt_array_has_shape(a, 4, five)))
        return wrong_shape(path, a, points == ACTION_BODY ? "f4 (N, 3, T, 65, 1)" : "f4 (N, 3, T, 30, 1)");
    if (a->shape[0] < 1 || a->shape[2] < 1 || a->shape[2] > ACTION_MOST_FRAMES)
        return wrong_shape(path, a, "clips, of 1 to 10000 frames");
    return LT_OK;
}

static bool finite_at(const float *x, int length, int points, int k)
{
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < points; i++)
            if (!isfinite(x[(c * (int64_t)length + k) * points + i]))
                return false;
    return true;
}

static void copy_frame(float *x, int length, int points, int from, int to)
{
    for (int64_t c = 0; c < 3; c++)
        memcpy(x + (c * length + to) * points, x + (c * length + from) * points, (size_t)points * sizeof(*x));
}

bool action_hold_body(const action_clip *c, float *x, int length)
{
    int last = 0;

    while (last < c->frames && !finite_at(x, length, ACTION_BODY, last))
        last++;
    if (last == c->frames)
        return false;
    for (int k = 0; k < c->frames; k++) {
        if (k > last && finite_at(x, length, ACTION_BODY, k))
            last = k;
        else if (k != last)
            copy_frame(x, length, ACTION_BODY, last, k);
    }
    return true;
}

static lt_status read_body(lt_arena *arena, action_set *set)
{
    lt_array a;
    lt_status st = read_points(arena, set->root, "body.npy", ACTION_BODY, &a);

    if (st)
        return st;
    set->n = a.shape[0];
    set->length = (int)a.shape[2];
    set->body = a.data;
    st = read_labels(arena, set);
    for (int64_t i = 0; !st && i < set->n; i++)
        if (!action_hold_body(&set->clip[i], (float *)a.data + i * 3 * set->length * ACTION_BODY, set->length))
            st = lt_error(LT_EFORMAT, "%s/body.npy: clip %s: nobody is seen in any of its %d frames", set->root,
                          set->clip[i].name, set->clip[i].frames);
    return st;
}

static lt_status read_hand_object(lt_arena *arena, action_set *set)
{
    const char *path = lt_path_join(arena, set->root, "hand_object.npy");
    const char *valid_path = lt_path_join(arena, set->root, "valid.npy");
    const int64_t want[] = { set->n, set->length };
    lt_array a, valid;
    uint8_t *known;
    lt_status st;

    if (!path || !valid_path)
        return no_memory(set->root);
    if (access(path, F_OK) != 0)
        return LT_OK;
    st = read_points(arena, set->root, "hand_object.npy", ACTION_HAND_OBJECT, &a);
    if (!st && (a.shape[0] != set->n || a.shape[2] != set->length))
        st = wrong_shape(path, &a, "as many clips and frames as body.npy");
    if (!st)
        st = lt_npy_read(arena, valid_path, &valid);
    if (!st && (valid.type != LT_ELEM_U1 || !lt_array_has_shape(&valid, 2, want)))
        st = wrong_shape(valid_path, &valid, "u1, a number for each clip and frame of body.npy");
    if (st)
        return st;
    known = valid.data;
    for (int64_t i = 0; i < set->n; i++)
        for (int k = 0; k < set->length; k++)
            known[i * set->length + k] = known[i * set->length + k]
                && finite_at((float *)a.data + i * 3 * set->length * ACTION_HAND_OBJECT, set->length,
                             ACTION_HAND_OBJECT, k);
    set->hand_object = a.data;
    set->valid = known;
    return LT_OK;
}

/* ---- the whole ---- */

static void read_manifest(lt_arena *arena, action_set *set)
{
    const char *path = lt_path_join(arena, set->root, "manifest.json");
    const cJSON *difficulty;
    cJSON *root;

    set->difficulty = NAN;
    if (!path || access(path, F_OK) != 0 || lt_json_read(path, &root))
        return;
    set->synthetic = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(root, "synthetic"));
    difficulty = cJSON_GetObjectItemCaseSensitive(root, "difficulty");
    set->difficulty = cJSON_IsNumber(difficulty) ? difficulty->valuedouble : NAN;
    cJSON_Delete(root);
}

bool action_probe(const char *root)
{
    lt_arena *arena = lt_arena_new();
    const char *path = arena ? lt_path_join(arena, root, "body.npy") : NULL;
    const bool found = path && access(path, F_OK) == 0;

    lt_arena_free(arena);
    return found;
}

lt_status action_open(lt_arena *arena, const char *root, action_set *out)
{
    action_set set = { .root = lt_arena_strdup(arena, root) };
    lt_status st = set.root ? read_body(arena, &set) : no_memory(root);

    if (!st)
        st = read_hand_object(arena, &set);
    if (st)
        return st;
    read_manifest(arena, &set);
    *out = set;
    return LT_OK;
}
