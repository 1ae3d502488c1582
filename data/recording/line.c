/* SPDX-License-Identifier: Apache-2.0 */
#include "data/recording/line.h"

#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

static const char SCHEMA[] = "palmar.set/1";
static const double MOST = 1e9;                 /* of any number that is no id, */
static const double MOST_ID = 9007199254740992; /* and of an id: doubles hold them all */

enum { MOST_ITEMS = 1000 };                     /* of a list */

/* Where an item stands, for the error line; NULL key: the line itself */
typedef struct {
    lt_arena *arena;
    const char *name, *key;
    int64_t number;
    int item;                       /* from 1 */
} place;

static lt_status wrong(const place *at, const char *key, const char *want)
{
    if (at->key)
        return lt_error(LT_EFORMAT, "%s:%lld: \"%s\" of item %d of \"%s\" is missing or wrong, want %s", at->name,
                        (long long)at->number, key, at->item, at->key, want);
    return lt_error(LT_EFORMAT, "%s:%lld: \"%s\" is missing or wrong, want %s", at->name, (long long)at->number, key,
                    want);
}

static lt_status no_memory(const place *at)
{
    return lt_error(LT_ENOMEM, "%s:%lld: no memory", at->name, (long long)at->number);
}

/* ---- values ---- */

static const cJSON *get(const cJSON *o, const char *key)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(o, key);

    return cJSON_IsNull(item) ? NULL : item;
}

static bool is_number(const cJSON *item)
{
    return cJSON_IsNumber(item) && fabs(item->valuedouble) <= MOST;
}

/* NaN where it is not there */
static lt_status take_number(const place *at, const cJSON *o, const char *key, double *out)
{
    const cJSON *item = get(o, key);

    *out = NAN;
    if (item && !is_number(item))
        return wrong(at, key, "a number");
    if (item)
        *out = item->valuedouble;
    return LT_OK;
}

/* 0 where it is not there and may be so */
static lt_status take_id(const place *at, const cJSON *o, const char *key, bool may_lack, int64_t *out)
{
    const cJSON *item = get(o, key);
    const double x = cJSON_IsNumber(item) ? item->valuedouble : -1;

    *out = 0;
    if (!item && may_lack)
        return LT_OK;
    if (!(x >= 0 && x <= MOST_ID && x == floor(x)))
        return wrong(at, key, "a whole number");
    *out = (int64_t)x;
    return LT_OK;
}

/* -1 where it is not there and may be so */
static lt_status take_camera(const place *at, const cJSON *o, bool may_lack, int *out)
{
    int64_t id;
    const lt_status st = take_id(at, o, "camera", may_lack, &id);

    if (!st && id >= RECORDING_CAMERAS)
        return wrong(at, "camera", "the number of a camera, 0 to 3");
    *out = st || !get(o, "camera") ? -1 : (int)id;
    return st;
}

static lt_status take_text(const place *at, const cJSON *o, const char *key, const char **out)
{
    const char *text = cJSON_GetStringValue(get(o, key));

    if (!text)
        return wrong(at, key, "text");
    *out = lt_arena_strdup(at->arena, text);
    return *out ? LT_OK : no_memory(at);
}

/* One of two words */
static lt_status take_choice(const place *at, const cJSON *o, const char *key, const char *no, const char *yes,
                             const char *want, bool *out)
{
    const char *text = cJSON_GetStringValue(get(o, key));

    *out = text && strcmp(text, yes) == 0;
    return *out || (text && strcmp(text, no) == 0) ? LT_OK : wrong(at, key, want);
}

/* n numbers, null for NaN */
static bool read_numbers(const cJSON *list, int n, double *out)
{
    const cJSON *item;
    int i = 0;

    if (!cJSON_IsArray(list))
        return false;
    cJSON_ArrayForEach(item, list) {
        if (i == n || (!cJSON_IsNull(item) && !is_number(item)))
            return false;
        out[i++] = cJSON_IsNull(item) ? NAN : item->valuedouble;
    }
    return i == n;
}

static lt_status take_numbers(const place *at, const cJSON *o, const char *key, int n, const char *want, double *out)
{
    return read_numbers(get(o, key), n, out) ? LT_OK : wrong(at, key, want);
}

static lt_status take_points(const place *at, const cJSON *o, const char *key, int n, const char *want,
                             double (*out)[3])
{
    const cJSON *list = get(o, key), *row;
    int i = 0;

    if (!cJSON_IsArray(list) || cJSON_GetArraySize(list) != n)
        return wrong(at, key, want);
    cJSON_ArrayForEach(row, list)
        if (!read_numbers(row, 3, out[i++]))
            return wrong(at, key, want);
    return LT_OK;
}

/* A number for each camera, as far as there are; null for NaN */
static lt_status take_by_camera(const place *at, const cJSON *o, const char *key, double out[RECORDING_CAMERAS])
{
    const cJSON *list = get(o, key);
    const int n = cJSON_IsArray(list) ? cJSON_GetArraySize(list) : -1;

    for (int c = 0; c < RECORDING_CAMERAS; c++)
        out[c] = NAN;
    if (!list)
        return LT_OK;
    if (n < 1 || n > RECORDING_CAMERAS || !read_numbers(list, n, out))
        return wrong(at, key, "1 to 4 numbers, by camera");
    return LT_OK;
}

/* ---- items ---- */

static lt_status take_track(const place *at, const cJSON *o, void *to)
{
    session_track *out = to;
    double box[4];
    lt_status st = take_id(at, o, "id", false, &out->id);

    if (!st)
        st = take_text(at, o, "class", &out->cls);
    if (!st)
        st = take_camera(at, o, false, &out->camera);
    if (!st)
        st = take_numbers(at, o, "box", 4, "4 numbers", box);
    for (int k = 0; k < 4 && !st; k++)
        out->box[k] = (float)box[k];
    return st;
}

static lt_status take_hand(const place *at, const cJSON *o, void *to)
{
    session_hand *out = to;
    lt_status st = take_id(at, o, "id", false, &out->id);

    if (!st)
        st = take_id(at, o, "person", true, &out->person);
    if (!st)
        st = take_camera(at, o, true, &out->camera);
    if (!st)
        st = take_choice(at, o, "side", "right", "left", "left or right", &out->left);
    if (!st)
        st = take_choice(at, o, "state", "on", "coast", "on or coast", &out->coasts);
    return st ? st : take_points(at, o, "joints", LT_HAND_KEYPOINTS, "21 rows of 3 numbers", out->joint);
}

static lt_status take_object(const place *at, const cJSON *o, void *to)
{
    session_object *out = to;
    lt_status st = take_id(at, o, "id", false, &out->id);

    if (!st)
        st = take_text(at, o, "class", &out->cls);
    if (!st)
        st = take_choice(at, o, "state", "on", "coast", "on or coast", &out->coasts);
    if (!st)
        st = take_numbers(at, o, "R", 9, "9 numbers", out->R);
    return st ? st : take_numbers(at, o, "t", 3, "3 numbers", out->t);
}

static lt_status take_person(const place *at, const cJSON *o, void *to)
{
    session_person *out = to;
    lt_status st = take_id(at, o, "id", false, &out->id);

    if (!st)
        st = take_camera(at, o, true, &out->camera);
    return st ? st : take_points(at, o, "joints", ACTION_BODY, "65 rows of 3 numbers", out->joint);
}

static lt_status take_contact(const place *at, const cJSON *o, void *to)
{
    session_contact *out = to;
    const lt_status st = take_id(at, o, "hand", false, &out->hand);

    return st ? st : take_id(at, o, "object", false, &out->object);
}

static lt_status take_doing(const place *at, const cJSON *o, const char *key, session_doing *out)
{
    lt_status st = take_id(at, o, "person", true, &out->person);

    if (!st)
        st = take_id(at, o, "object", true, &out->object);
    if (!st)
        st = take_number(at, o, "p", &out->p);
    return st ? st : take_text(at, o, key, &out->what);
}

static lt_status take_action(const place *at, const cJSON *o, void *to)
{
    return take_doing(at, o, "class", to);
}

static lt_status take_interaction(const place *at, const cJSON *o, void *to)
{
    return take_doing(at, o, "state", to);
}

/* ---- lists ---- */

/* A list of objects, or one object alone; *n of them at *out */
static lt_status take_list(const place *line, const cJSON *root, const char *key, size_t size,
                           lt_status (*take)(const place *at, const cJSON *o, void *to), void **out, int *n)
{
    const cJSON *list = get(root, key), *item;
    const int count = !list ? 0 : cJSON_IsObject(list) ? 1 : cJSON_IsArray(list) ? cJSON_GetArraySize(list) : -1;
    place at = *line;
    lt_status st = LT_OK;

    *n = 0;
    if (count < 0 || count > MOST_ITEMS)
        return wrong(line, key, "a list of at most 1000 objects");
    *out = lt_arena_array(line->arena, (size_t)count, size);
    if (!*out)
        return no_memory(line);
    at.key = key;
    for (item = cJSON_IsArray(list) ? list->child : list; count && item && !st; item = item->next) {
        at.item = *n + 1;
        if (!cJSON_IsObject(item))
            return lt_error(LT_EFORMAT, "%s:%lld: item %d of \"%s\" is no object", at.name, (long long)at.number,
                            at.item, key);
        st = take(&at, item, (char *)*out + (size_t)*n * size);
        *n += !st;
        if (!cJSON_IsArray(list))
            break;
    }
    return st;
}

/* ---- the line ---- */

static lt_status take_sum(const place *at, const cJSON *root, session_sum *out)
{
    const cJSON *age = get(root, "age_ms"), *rss = get(root, "rss_mb");
    const struct { const cJSON *in; const char *key; double *to; } number[] = {
        { root, "captured", &out->captured }, { root, "taken", &out->taken }, { root, "dropped", &out->dropped },
        { root, "fps", &out->fps }, { age, "p50", &out->age_p50 }, { age, "p95", &out->age_p95 },
        { rss, "first", &out->rss_first }, { rss, "last", &out->rss_last },
    };
    lt_status st = LT_OK;

    out->crc = "";
    for (size_t i = 0; i < LT_COUNT(number) && !st; i++)
        st = take_number(at, number[i].in, number[i].key, number[i].to);
    return st || !get(root, "crc32") ? st : take_text(at, root, "crc32", &out->crc);
}

static lt_status take_stages(const place *at, const cJSON *root, session_line *out)
{
    const cJSON *stages = get(root, "stages_ms");
    lt_status st = LT_OK;

    for (int k = 0; k < SESSION_STAGES && !st; k++) {
        const char key[] = { 'S', (char)('1' + k), '\0' };

        st = take_number(at, stages, key, &out->stage_ms[k]);
    }
    return st;
}

/* The reference's time alone, or that of each camera; the truth tells of moments too of which no camera kept a frame. */
static lt_status take_time(const place *at, const cJSON *root, bool truth, session_line *out)
{
    lt_status st;

    if (truth && is_number(get(root, "t")))
        return take_number(at, root, "t", &out->t[0]);
    st = take_by_camera(at, root, "t", out->t);
    for (int c = 0; c < RECORDING_CAMERAS && !st; c++)
        if (isfinite(out->t[c]))
            return LT_OK;
    return st || truth ? st : wrong(at, "t", "seconds of at least one camera");
}

static lt_status take_people(const place *at, const cJSON *root, session_line *out)
{
    lt_status st = take_list(at, root, "people", sizeof(*out->person), take_person, (void **)&out->person,
                             &out->n_people);

    if (!st)
        st = take_list(at, root, "action", sizeof(*out->action), take_action, (void **)&out->action, &out->n_actions);
    return st ? st : take_list(at, root, "interaction", sizeof(*out->interaction), take_interaction,
                               (void **)&out->interaction, &out->n_interactions);
}

static lt_status take_things(const place *at, const cJSON *root, session_line *out)
{
    lt_status st = take_list(at, root, "tracks", sizeof(*out->track), take_track, (void **)&out->track, &out->n_tracks);

    if (!st)
        st = take_list(at, root, "hands", sizeof(*out->hand), take_hand, (void **)&out->hand, &out->n_hands);
    if (!st)
        st = take_list(at, root, "objects", sizeof(*out->object), take_object, (void **)&out->object, &out->n_objects);
    return st ? st : take_list(at, root, "contact", sizeof(*out->contact), take_contact, (void **)&out->contact,
                               &out->n_contacts);
}

static lt_status take_set(const place *at, const cJSON *root, session_line *out)
{
    const char *schema = cJSON_GetStringValue(get(root, "schema"));
    lt_status st;

    if (!schema || strcmp(schema, SCHEMA) != 0)
        return wrong(at, "schema", SCHEMA);
    st = take_time(at, root, false, out);
    if (!st)
        st = take_by_camera(at, root, "dropped", out->dropped);
    if (!st)
        st = take_number(at, root, "pair_ms", &out->pair_ms);
    if (!st)
        st = take_number(at, root, "age_ms", &out->age_ms);
    if (!st)
        st = take_stages(at, root, out);
    if (!st)
        st = take_things(at, root, out);
    return st ? st : take_people(at, root, out);
}

static lt_status take_truth(const place *at, const cJSON *root, session_line *out)
{
    const lt_status st = take_time(at, root, true, out);

    return st ? st : take_people(at, root, out);
}

lt_status session_line_parse(lt_arena *arena, const char *name, int64_t number, const char *text, size_t n, bool truth,
                             session_line *out)
{
    const place at = { .arena = arena, .name = name, .number = number };
    cJSON *root;
    lt_status st = lt_json_parse("line", text, n, &root);

    memset(out, 0, sizeof(*out));
    for (int c = 0; c < RECORDING_CAMERAS; c++)
        out->t[c] = NAN;
    if (st == LT_ENOMEM)
        return no_memory(&at);
    if (st || !cJSON_IsObject(root)) {
        if (!st)
            cJSON_Delete(root);
        return lt_error(LT_EFORMAT, "%s:%lld: no JSON object; was the file cut off or changed by hand?", name,
                        (long long)number);
    }
    out->is_sum = !truth && get(root, "summary");
    st = out->is_sum ? take_sum(&at, root, &out->sum) : truth ? take_truth(&at, root, out) : take_set(&at, root, out);
    cJSON_Delete(root);
    return st;
}
