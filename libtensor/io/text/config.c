/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/io/text/config.h"

#include "libtensor/io/text/nearest.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static int key_count(const lt_config_key *keys)
{
    int n = 0;

    while (keys[n].name)
        n++;
    return n;
}

static lt_status unknown_key(const char *where, const char *name, const lt_config_key *keys)
{
    const char *names[128];
    char all[512] = "there are: none";
    size_t length = strlen("there are: ");
    int n = 0;

    for (; keys[n].name && n < (int)LT_COUNT(names); n++) {
        names[n] = keys[n].name;
        if (length < sizeof(all))
            length += (size_t)snprintf(all + length, sizeof(all) - length, "%s%s", n ? ", " : "", keys[n].name);
    }
    return lt_unknown_name(name, names, (size_t)n, all, "%s.%s: no such key", where, name);
}

static lt_status check_names(const char *where, const cJSON *object, const lt_config_key *keys)
{
    const cJSON *item;

    cJSON_ArrayForEach(item, object) {
        int i = 0;

        while (keys[i].name && strcmp(keys[i].name, item->string) != 0)
            i++;
        if (!keys[i].name)
            return unknown_key(where, item->string, keys);
        if (cJSON_GetObjectItemCaseSensitive(object, item->string) != item)
            return lt_error(LT_EINVAL, "%s.%s: is there twice", where, item->string);
    }
    return LT_OK;
}

static lt_status wrong(const char *where, const lt_config_key *k, const char *want, const cJSON *found)
{
    char *text = cJSON_PrintUnformatted(found);
    const lt_status st = lt_error(LT_EINVAL, "%s.%s: found %s, want %s", where, k->name,
                                  text ? text : "?", want);

    cJSON_free(text);
    return st;
}

static lt_status read_number(const char *where, const lt_config_key *k, const cJSON *v, double *out)
{
    const double x = cJSON_IsNumber(v) ? v->valuedouble : NAN;

    if (!isfinite(x))
        return wrong(where, k, "a number", v);
    if (k->type != LT_CONFIG_NUMBER && x != floor(x))
        return wrong(where, k, "a whole number", v);
    if (k->type != LT_CONFIG_NUMBER && fabs(x) > 2147483647.0)
        return wrong(where, k, "a whole number from -2147483647 to 2147483647", v);
    if ((k->lo != 0 || k->hi != 0) && (x < k->lo || x > k->hi))
        return lt_error(LT_EINVAL, "%s.%s: %.10g is not between %.10g and %.10g", where, k->name, x, k->lo, k->hi);
    *out = x;
    return LT_OK;
}

static lt_status read_choice(const char *where, const lt_config_key *k, const cJSON *v, int *out)
{
    int n = 0;

    while (k->choices[n])
        n++;
    for (int i = 0; cJSON_IsString(v) && i < n; i++)
        if (strcmp(k->choices[i], v->valuestring) == 0) {
            *out = i;
            return LT_OK;
        }
    if (!cJSON_IsString(v))
        return wrong(where, k, "text", v);
    return lt_unknown_name(v->valuestring, k->choices, (size_t)n, NULL, "%s.%s: no such choice \"%s\"", where, k->name,
                           v->valuestring);
}

static lt_status read_ints(const char *where, const lt_config_key *k, const cJSON *v, int *out)
{
    double x;

    if (cJSON_GetArraySize(v) != 4 || !cJSON_IsArray(v))
        return wrong(where, k, "a list of four whole numbers", v);
    for (int i = 0; i < 4; i++) {
        if (read_number(where, k, cJSON_GetArrayItem(v, i), &x))
            return LT_EINVAL;
        out[i] = (int)x;
    }
    return LT_OK;
}

static lt_status read_text(lt_arena *arena, const char *where, const lt_config_key *k, const cJSON *v,
                           const char **out)
{
    if (!cJSON_IsString(v))
        return wrong(where, k, "text", v);
    *out = lt_arena_strdup(arena, v->valuestring);
    return *out ? LT_OK : lt_error(LT_ENOMEM, "no memory for %s.%s", where, k->name);
}

static lt_status read_value(lt_arena *arena, const char *where, const lt_config_key *k, const cJSON *v,
                            void *out)
{
    double x;

    switch (k->type) {
    case LT_CONFIG_INT:
    case LT_CONFIG_NUMBER:
        if (read_number(where, k, v, &x))
            return LT_EINVAL;
        if (k->type == LT_CONFIG_INT)
            *(int *)out = (int)x;
        else
            *(double *)out = x;
        return LT_OK;
    case LT_CONFIG_BOOL:
        if (!cJSON_IsBool(v))
            return wrong(where, k, "true or false", v);
        *(bool *)out = cJSON_IsTrue(v);
        return LT_OK;
    case LT_CONFIG_TEXT:
        return read_text(arena, where, k, v, out);
    case LT_CONFIG_CHOICE:
        return read_choice(where, k, v, out);
    case LT_CONFIG_INTS:
        return read_ints(where, k, v, out);
    }
    return LT_EINVAL;
}

static lt_status read_fallback(lt_arena *arena, const char *where, const lt_config_key *k, void *out)
{
    cJSON *v = cJSON_Parse(k->fallback);
    lt_status st = v ? read_value(arena, where, k, v, out)
                     : lt_error(LT_ENOMEM, "no memory for %s.%s", where, k->name);

    cJSON_Delete(v);
    return st;
}

lt_status lt_config_read(lt_arena *arena, const char *where, const cJSON *object,
                         const lt_config_key *keys, void *out)
{
    lt_status st = LT_OK;

    if (object && !cJSON_IsObject(object))
        return lt_error(LT_EINVAL, "%s: want an object of keys", where);
    if (object && check_names(where, object, keys))
        return LT_EINVAL;
    for (int i = 0; st == LT_OK && i < key_count(keys); i++) {
        const cJSON *v = object ? cJSON_GetObjectItemCaseSensitive(object, keys[i].name) : NULL;
        void *field = (char *)out + keys[i].offset;

        st = v ? read_value(arena, where, &keys[i], v, field) : read_fallback(arena, where, &keys[i], field);
    }
    return st;
}

static cJSON *write_value(const lt_config_key *k, const void *field)
{
    switch (k->type) {
    case LT_CONFIG_INT:
        return cJSON_CreateNumber(*(const int *)field);
    case LT_CONFIG_NUMBER:
        return cJSON_CreateNumber(*(const double *)field);
    case LT_CONFIG_BOOL:
        return cJSON_CreateBool(*(const bool *)field);
    case LT_CONFIG_TEXT:
        return cJSON_CreateString(*(const char *const *)field);
    case LT_CONFIG_CHOICE:
        return cJSON_CreateString(k->choices[*(const int *)field]);
    case LT_CONFIG_INTS:
        return cJSON_CreateIntArray(field, 4);
    }
    return NULL;
}

cJSON *lt_config_write(const lt_config_key *keys, const void *from)
{
    cJSON *object = cJSON_CreateObject();

    for (int i = 0; object && i < key_count(keys); i++) {
        cJSON *v = write_value(&keys[i], (const char *)from + keys[i].offset);

        if (!cJSON_AddItemToObject(object, keys[i].name, v)) {
            cJSON_Delete(v);
            cJSON_Delete(object);
            return NULL;
        }
    }
    return object;
}

/* What is called name inside parent, an object made for it when it is missing; NULL without memory. */
static cJSON *child(cJSON *parent, const char *name)
{
    cJSON *c = cJSON_GetObjectItemCaseSensitive(parent, name);

    return c ? c : cJSON_AddObjectToObject(parent, name);
}

static lt_status put(cJSON *object, const char *where, const char *key, const char *value)
{
    cJSON *v = cJSON_ParseWithOpts(value, NULL, true);

    if (!v)
        v = cJSON_CreateString(value);
    cJSON_DeleteItemFromObjectCaseSensitive(object, key);
    if (!v || !cJSON_AddItemToObject(object, key, v)) {
        cJSON_Delete(v);
        return lt_error(LT_ENOMEM, "no memory for %s %s", where, key);
    }
    return LT_OK;
}

lt_status lt_config_set(cJSON *root, const char *where, const char *assignment)
{
    const char *equals = strchr(assignment, '=');
    char path[256], *key = path, *dot;

    if (!equals || equals == assignment || (size_t)(equals - assignment) >= sizeof(path))
        return lt_error(LT_EUSAGE, "%s %s: want key=value, as in optim.lr=3e-4", where, assignment);
    memcpy(path, assignment, (size_t)(equals - assignment));
    path[equals - assignment] = '\0';
    for (; (dot = strchr(key, '.')); key = dot + 1) {
        *dot = '\0';
        root = child(root, key);
        if (!root)
            return lt_error(LT_ENOMEM, "no memory for %s %s", where, assignment);
        if (!cJSON_IsObject(root))
            return lt_error(LT_EUSAGE, "%s %s: %s is no group of keys", where, assignment, key);
    }
    return put(root, where, key, equals + 1);
}

/* Whether a line is about the key of an assignment, or about its group. */
static bool is_about(const char *line, const char *assignment)
{
    const size_t key = strcspn(assignment, "="), group = strcspn(assignment, ".=");

    return (strncmp(line, assignment, key) == 0 && line[key] == ':')
        || (strncmp(line, assignment, group) == 0 && line[group] == ':');
}

lt_status lt_config_blame(const char *path, const char *where, const char *const *set, int n, lt_status st)
{
    const size_t length = strlen(path);
    char line[1024];

    snprintf(line, sizeof(line), "%s", lt_last_error());
    for (int i = 0; i < n && strncmp(line, path, length) == 0; i++) {
        const char *about = line + length + strspn(line + length, ": ");

        if (is_about(about, set[i]))
            return lt_error(LT_EUSAGE, "%s %s", where, about);
    }
    return st;
}
