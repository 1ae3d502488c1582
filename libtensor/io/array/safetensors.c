/* SPDX-License-Identifier: Apache-2.0 */
/*
 * safetensors: a length, a JSON header, and the elements of all arrays without a gap.
 */
#include "libtensor/io/array/safetensors.h"

#include "libtensor/io/array/raw_array.h"
#include "libtensor/io/array/safetensors_dtype.h"
#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"
#include "libtensor/io/text/json.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HEADER_MAX = 100000000 };

const char *const lt_safetensors_dtype[LT_ELEM_COUNT] = {
    [LT_ELEM_F4] = "F32", [LT_ELEM_F8] = "F64", [LT_ELEM_F2] = "F16", [LT_ELEM_BF16] = "BF16",
    [LT_ELEM_I1] = "I8", [LT_ELEM_I2] = "I16", [LT_ELEM_I4] = "I32", [LT_ELEM_I8] = "I64",
    [LT_ELEM_U1] = "U8", [LT_ELEM_U2] = "U16", [LT_ELEM_U4] = "U32", [LT_ELEM_U8] = "U64",
    [LT_ELEM_BOOL] = "BOOL",
};

/* One entry of the header, before its bytes are looked at. */
typedef struct {
    const char *name;
    lt_raw_array raw;
    const char *unread;                 /* a dtype that is not read; NULL: it is */
    size_t begin, end;                  /* in the data */
} entry;

/* A JSON number that is a size below 2^53, where doubles are exact. */
static bool take_size(const cJSON *number, size_t *out)
{
    const double x = cJSON_IsNumber(number) ? number->valuedouble : -1;

    if (!(x >= 0 && x < 0x1p53) || x != (double)(size_t)x)
        return false;
    *out = (size_t)x;
    return true;
}

static bool take_dtype(const char *dtype, lt_raw_array *raw)
{
    for (int t = 0; t < LT_ELEM_COUNT; t++) {
        if (!lt_safetensors_dtype[t] || strcmp(lt_safetensors_dtype[t], dtype) != 0)
            continue;
        raw->type = (lt_elem)t;
        raw->width = lt_elem_size(raw->type);
        return true;
    }
    return false;
}

/* Which dtype it is that is not read, and which are; NULL without memory */
static const char *why_unread(lt_arena *arena, const char *dtype)
{
    char names[16 * LT_ELEM_COUNT];
    size_t n = 0;

    for (int t = 0; t < LT_ELEM_COUNT; t++)
        if (lt_safetensors_dtype[t])
            n += (size_t)snprintf(names + n, sizeof(names) - n, " %s", lt_safetensors_dtype[t]);
    return lt_arena_printf(arena, "dtype \"%.20s\" is not read, want one of%s", dtype, names);
}

static const char *take_shape(const cJSON *shape, lt_raw_array *raw)
{
    const cJSON *dim;

    if (!cJSON_IsArray(shape))
        return "shape is no array";
    cJSON_ArrayForEach(dim, shape) {
        size_t n;

        if (raw->rank == LT_ARRAY_MAX_RANK)
            return "shape has more than 8 dimensions";
        if (!take_size(dim, &n) || n > INT32_MAX)
            return "shape has a dimension that is no number below 2^31";
        raw->shape[raw->rank++] = (int64_t)n;
    }
    return NULL;
}

/* NULL, or what is wrong with this entry by itself, wherever the file ends. */
static const char *take_entry(const cJSON *item, entry *e)
{
    const cJSON *offsets = cJSON_GetObjectItemCaseSensitive(item, "data_offsets");
    const cJSON *dtype = cJSON_GetObjectItemCaseSensitive(item, "dtype");
    const char *wrong;
    size_t want;

    memset(e, 0, sizeof(*e));
    e->name = item->string;
    if (!cJSON_IsObject(item))
        return "no object";
    if (!cJSON_IsString(dtype))
        return "dtype is no text";
    if (!take_dtype(dtype->valuestring, &e->raw))
        e->unread = dtype->valuestring;
    wrong = take_shape(cJSON_GetObjectItemCaseSensitive(item, "shape"), &e->raw);
    if (wrong)
        return wrong;
    if (cJSON_GetArraySize(offsets) != 2 || !take_size(offsets->child, &e->begin) ||
        !take_size(offsets->child->next, &e->end))
        return "data_offsets are no two numbers";
    if (e->begin > e->end)
        return "data_offsets outside the data";
    if (!e->unread && (!lt_raw_bytes(&e->raw, &want) || want != e->end - e->begin))
        return "data_offsets that disagree with dtype and shape";
    return NULL;
}

static int by_place(const void *a, const void *b)
{
    const entry *x = a, *y = b;

    if (x->begin != y->begin)
        return x->begin < y->begin ? -1 : 1;
    return x->end != y->end ? (x->end < y->end ? -1 : 1) : 0;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

static lt_status check_unique(const char *path, const cJSON *items, lt_arena *scratch)
{
    const size_t n = (size_t)cJSON_GetArraySize(items);
    const char **name = lt_arena_array(scratch, n, sizeof(*name));
    const cJSON *item;
    size_t i = 0;

    if (!name)
        return lt_error(LT_ENOMEM, "%s: no memory for %zu names", path, n);
    cJSON_ArrayForEach(item, items)
        name[i++] = item->string;
    qsort(name, n, sizeof(*name), by_name);
    for (i = 1; i < n; i++)
        if (strcmp(name[i - 1], name[i]) == 0)
            return lt_error(LT_EFORMAT, "%s: two entries named \"%s\"", path, name[i]);
    return LT_OK;
}

/* Sorted, the entries must tile the data: each begins where the last one ended. */
static lt_status check_places(const char *path, entry *list, size_t n, size_t data_bytes)
{
    size_t at = 0;

    qsort(list, n, sizeof(*list), by_place);
    for (size_t i = 0; i < n; i++) {
        if (list[i].begin != at)
            return lt_error(LT_EFORMAT, "%s: \"%s\": data begins at %zu, want %zu: no gaps, no overlap",
                            path, list[i].name, list[i].begin, at);
        at = list[i].end;
    }
    if (at > data_bytes)
        return lt_refuse_cut(path, LT_KIND_SAFETENSORS, "data_offsets outside the data, up to %zu of %zu bytes",
                             at, data_bytes);
    if (at != data_bytes)
        return lt_error(LT_EFORMAT, "%s: %zu bytes of data, entries cover %zu", path, data_bytes, at);
    return LT_OK;
}

static lt_status take_meta(lt_arena *arena, const cJSON *meta, lt_safetensors *out)
{
    const cJSON *item;

    if (!meta)
        return LT_OK;
    out->meta = lt_arena_array(arena, (size_t)cJSON_GetArraySize(meta), sizeof(*out->meta));
    if (!out->meta)
        return lt_error(LT_ENOMEM, "%s: no memory", out->path);
    cJSON_ArrayForEach(item, meta) {
        lt_text_pair *pair = &out->meta[out->n_meta++];

        if (!cJSON_IsObject(meta) || !cJSON_IsString(item))
            return lt_error(LT_EFORMAT, "%s: __metadata__ is no map of strings", out->path);
        pair->key = lt_arena_strdup(arena, item->string);
        pair->value = lt_arena_strdup(arena, item->valuestring);
        if (!pair->key || !pair->value)
            return lt_error(LT_ENOMEM, "%s: no memory", out->path);
    }
    return LT_OK;
}

static lt_status load_entry(lt_arena *arena, const entry *e, const uint8_t *data, lt_safetensors *out)
{
    const char *name = lt_arena_strdup(arena, e->name);
    const char *why = e->unread && name ? why_unread(arena, e->unread) : name;
    lt_raw_array raw = e->raw;
    lt_status st;

    if (!name || !why)
        return lt_error(LT_ENOMEM, "%s: no memory", out->path);
    if (e->unread) {
        out->refused[out->n_refused++] = (lt_refused_array){ .name = name, .reason = why };
        return LT_OK;
    }
    lt_raw_order(&raw, '<');
    st = lt_raw_load(arena, &raw, data + e->begin, &out->entry[out->n].array);
    if (st)
        return lt_error_prefix(st, "%s: \"%s\"", out->path, name);
    out->entry[out->n++].name = name;
    return LT_OK;
}

static lt_status load_entries(lt_arena *arena, const entry *list, size_t n, const uint8_t *data,
                              lt_safetensors *out)
{
    lt_status st = LT_OK;

    out->entry = lt_arena_array(arena, n, sizeof(*out->entry));
    out->refused = lt_arena_array(arena, n, sizeof(*out->refused));
    if (!out->entry || !out->refused)
        return lt_error(LT_ENOMEM, "%s: no memory for %zu entries", out->path, n);
    for (size_t i = 0; !st && i < n; i++)
        st = load_entry(arena, &list[i], data, out);
    return st;
}

/* Everything but the memory of the header, which the caller frees. */
static lt_status load(lt_arena *arena, lt_arena *scratch, const cJSON *header, const uint8_t *data,
                      size_t data_bytes, lt_safetensors *out)
{
    entry *list = lt_arena_array(scratch, (size_t)cJSON_GetArraySize(header), sizeof(*list));
    const cJSON *item, *meta = NULL;
    size_t n = 0;
    lt_status st;

    if (!list)
        return lt_error(LT_ENOMEM, "%s: no memory", out->path);
    st = check_unique(out->path, header, scratch);
    if (st)
        return st;
    cJSON_ArrayForEach(item, header) {
        const char *wrong;

        if (strcmp(item->string, "__metadata__") == 0) {
            meta = item;
            continue;
        }
        wrong = take_entry(item, &list[n++]);
        if (wrong)
            return lt_error(LT_EFORMAT, "%s: \"%s\": %s", out->path, item->string, wrong);
    }
    st = check_places(out->path, list, n, data_bytes);
    if (!st)
        st = take_meta(arena, meta, out);
    return st ? st : load_entries(arena, list, n, data, out);
}

lt_status lt_safetensors_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n,
                               lt_safetensors *out)
{
    const lt_kind kind = lt_kind_of(bytes, n);
    lt_safetensors s = { .path = lt_arena_strdup(arena, name) };
    lt_arena *scratch;
    uint64_t length = 0;
    cJSON *header;
    lt_status st;

    if (kind && kind != LT_KIND_SAFETENSORS)
        return lt_refuse(name, bytes, n, "a safetensors file");
    for (int i = 0; n >= 8 && i < 8; i++)
        length |= (uint64_t)bytes[i] << (8 * i);
    if (kind && length >= 2 && length <= HEADER_MAX && length > n - 8)
        return lt_refuse_cut(name, kind, "header of %ju bytes in a file of %zu", (uintmax_t)length, n);
    if (n < 10 || length < 2 || length > n - 8 || length > HEADER_MAX || bytes[8] != '{')
        return lt_error(LT_EFORMAT, "%s: not a safetensors file: header of %ju bytes in a file of %zu",
                        name, (uintmax_t)length, n);
    st = lt_json_parse(name, (const char *)bytes + 8, (size_t)length, &header);
    if (st)
        return lt_error_prefix(st, "header");
    scratch = lt_arena_new();
    if (!scratch || !s.path)
        st = lt_error(LT_ENOMEM, "%s: no memory", name);
    else
        st = load(arena, scratch, header, bytes + 8 + length, n - 8 - (size_t)length, &s);
    lt_arena_free(scratch);
    cJSON_Delete(header);
    if (!st)
        *out = s;
    return st;
}

lt_status lt_safetensors_read(lt_arena *arena, const char *path, lt_safetensors *out)
{
    lt_file file;
    lt_status st = lt_file_load(&file, path, LT_FILE_MAX);

    if (!st)
        st = lt_safetensors_parse(arena, path, file.bytes, file.n, out);
    lt_file_free(&file);
    return st;
}

const lt_array *lt_safetensors_find(const lt_safetensors *s, const char *name)
{
    for (size_t i = 0; i < s->n; i++)
        if (strcmp(s->entry[i].name, name) == 0)
            return &s->entry[i].array;
    return NULL;
}

const char *lt_safetensors_meta(const lt_safetensors *s, const char *key)
{
    for (size_t i = 0; i < s->n_meta; i++)
        if (strcmp(s->meta[i].key, key) == 0)
            return s->meta[i].value;
    return NULL;
}
