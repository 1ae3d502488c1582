/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/int8/table.h"

#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- writing --------------------------------------------------------------------------------------------- */

static bool add_layer(cJSON *list, const lt_int8_layer *l)
{
    cJSON *one = cJSON_CreateObject();

    if (!one || !cJSON_AddItemToArray(list, one)) {
        cJSON_Delete(one);
        return false;
    }
    return cJSON_AddStringToObject(one, "name", l->layer)
        && cJSON_AddNumberToObject(one, "scale", (double)l->range.scale)
        && cJSON_AddBoolToObject(one, "signed", l->range.has_negative);
}

static const char *printed(lt_arena *arena, const cJSON *root)
{
    char *text = NULL;
    size_t n;
    FILE *f = open_memstream(&text, &n);
    const char *copy;

    if (!f)
        return NULL;
    lt_json_print(f, root);
    copy = fclose(f) == 0 ? lt_arena_strdup(arena, text) : NULL;
    free(text);
    return copy;
}

const char *int8_table_text(lt_arena *arena, const lt_int8_table *table)
{
    cJSON *root = cJSON_CreateObject(), *list = cJSON_AddArrayToObject(root, "layers");
    const char *text = NULL;
    bool ok = list != NULL;

    for (int i = 0; ok && i < table->n; i++)
        ok = add_layer(list, &table->layer[i]);
    if (ok)
        text = printed(arena, root);
    cJSON_Delete(root);
    return text;
}

/* ---- reading --------------------------------------------------------------------------------------------- */

/* A layer is named as its parameters are, up to their last dot. */
static bool has_layer(const lt_params *set, const char *name)
{
    const size_t n = strlen(name);

    for (const lt_param *p = lt_params_first(set); p; p = p->next) {
        const char *dot = strrchr(p->name, '.');

        if (dot && (size_t)(dot - p->name) == n && memcmp(p->name, name, n) == 0)
            return true;
    }
    return false;
}

static bool usable(double scale)
{
    const lt_real s = (lt_real)scale;

    return s > 0 && isfinite(s) && isfinite(1 / s);
}

static lt_status parse_layer(lt_arena *arena, const char *path, const cJSON *item, const lt_params *params,
                             const lt_int8_table *before, lt_int8_layer *out)
{
    const cJSON *name = cJSON_GetObjectItemCaseSensitive(item, "name");
    const cJSON *scale = cJSON_GetObjectItemCaseSensitive(item, "scale");
    const cJSON *has_sign = cJSON_GetObjectItemCaseSensitive(item, "signed");

    if (!cJSON_IsString(name) || !cJSON_IsNumber(scale) || !cJSON_IsBool(has_sign))
        return lt_error(LT_EFORMAT,
                        "%s: int8: layer %d: want a \"name\", a number \"scale\" and \"signed\", true or false",
                        path, before->n);
    if (!has_layer(params, name->valuestring))
        return lt_error(LT_EFORMAT, "%s: int8: the model has no layer \"%s\"", path, name->valuestring);
    if (lt_int8_find(before, name->valuestring))
        return lt_error(LT_EFORMAT, "%s: int8: layer \"%s\" is there twice", path, name->valuestring);
    if (!usable(scale->valuedouble))
        return lt_error(LT_EFORMAT, "%s: int8: the scale of layer \"%s\" is %g, want a finite number above 0", path,
                        name->valuestring, scale->valuedouble);
    out->layer = lt_arena_strdup(arena, name->valuestring);
    out->range = (lt_int8_range){ (lt_real)scale->valuedouble, cJSON_IsTrue(has_sign) };
    return out->layer ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory for its int8 layers", path);
}

static lt_status parse_layers(lt_arena *arena, const char *path, const cJSON *list, const lt_params *params,
                              const lt_int8_table **out)
{
    lt_int8_table *table = lt_arena_alloc(arena, sizeof(*table));
    lt_int8_layer *layer = lt_arena_array(arena, (size_t)cJSON_GetArraySize(list), sizeof(*layer));
    const cJSON *item;
    lt_status st = table && layer ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory for its int8 layers", path);

    if (st)
        return st;
    *table = (lt_int8_table){ layer, 0 };
    cJSON_ArrayForEach(item, list) {
        st = parse_layer(arena, path, item, params, table, &layer[table->n]);
        if (st)
            return st;
        table->n++;
    }
    *out = table;
    return LT_OK;
}

lt_status int8_table_parse(lt_arena *arena, const char *path, const char *text, const lt_params *params,
                           const lt_int8_table **out)
{
    const cJSON *list;
    cJSON *root;
    lt_status st = lt_json_parse("int8", text, strlen(text), &root);

    if (st)
        return lt_error_prefix(st, "%s", path);
    list = cJSON_GetObjectItemCaseSensitive(root, "layers");
    st = cJSON_IsArray(list) ? parse_layers(arena, path, list, params, out)
                             : lt_error(LT_EFORMAT, "%s: int8: want a list \"layers\"", path);
    cJSON_Delete(root);
    return st;
}
