/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/export/meta.h"

#include "estimate/param_arrays.h"
#include "libtensor/io/array/safetensors.h"
#include "libtensor/io/text/json.h"
#include "libtensor/io/text/utf8.h"

#include <cjson/cJSON.h>
#include <string.h>
#include <sys/stat.h>

const char *export_config(lt_arena *arena, const model *m)
{
    cJSON *config = lt_config_write(m->cls->keys, m->self);
    char *text = config ? cJSON_PrintUnformatted(config) : NULL;
    const char *copy = text ? lt_arena_strdup(arena, text) : NULL;

    cJSON_free(text);
    cJSON_Delete(config);
    return copy;
}

const char *export_text(lt_arena *arena, const char *text)
{
    const char *end = text + strlen(text);
    char *copy = lt_arena_alloc(arena, 3 * strlen(text) + LT_UTF8_MAX), *at = copy;

    while (copy && text < end)
        at += lt_utf8_put(at, lt_utf8_next(&text, end));
    return copy;
}

static lt_status compare(const char *path, const lt_named_array *list, size_t n)
{
    lt_arena *arena = lt_arena_new();
    lt_safetensors file;
    lt_status st = arena ? lt_safetensors_read(arena, path, &file) : lt_error(LT_ENOMEM, "no memory to compare");

    for (size_t i = 0; st == LT_OK && i < n; i++) {
        const lt_array *a = lt_safetensors_find(&file, list[i].name);
        size_t bytes;

        if (!a || !lt_array_bytes(&list[i].array, &bytes) || memcmp(a->data, list[i].array.data, bytes) != 0)
            st = lt_error(LT_EIO, "%s: \"%s\" is not what was written", path, list[i].name);
    }
    lt_arena_free(arena);
    return st;
}

lt_status export_weights(const export_options *o, const char *path, export_report *report)
{
    lt_arena *arena = lt_arena_new();
    size_t n = 0;
    lt_named_array *list = arena ? param_arrays(arena, o->m->params, 0, &n) : NULL;
    const lt_text_pair meta[] = {
        { "format", "palmar-weights" }, { "model", o->m->cls->name }, { "variant", o->m->variant },
        { "config", arena ? export_config(arena, o->m) : NULL },
        { "hand", arena ? export_text(arena, o->hand_name ? o->hand_name : "") : NULL },
    };
    struct stat s;
    lt_status st = list && meta[3].value && meta[4].value
        ? lt_safetensors_write(path, list, n, meta, LT_COUNT(meta)) : lt_error(LT_ENOMEM, "no memory to export");

    *report = (export_report){ .n_outputs = 0 };
    if (st == LT_OK)
        st = compare(path, list, n);
    if (st == LT_OK && stat(path, &s) == 0)
        report->bytes = (size_t)s.st_size;
    lt_arena_free(arena);
    return st;
}
