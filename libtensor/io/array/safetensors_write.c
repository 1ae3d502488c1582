/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writing safetensors: the header is made in memory, the data goes straight from the arrays to the file.
 */
#include "libtensor/io/array/safetensors.h"

#include "libtensor/io/array/safetensors_dtype.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/text/json.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int by_name(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

static lt_status check_names(const char *path, const lt_named_array *entry, size_t n)
{
    const char **name = lt_alloc(n * sizeof(*name));
    lt_status st = LT_OK;

    if (!name)
        return lt_error(LT_ENOMEM, "%s: no memory for %zu names", path, n);
    for (size_t i = 0; i < n; i++)
        name[i] = entry[i].name;
    qsort(name, n, sizeof(*name), by_name);
    for (size_t i = 0; i < n && !st; i++) {
        if (strcmp(name[i], "__metadata__") == 0)
            st = lt_error(LT_EINVAL, "%s: an array may not be named __metadata__", path);
        else if (i && strcmp(name[i - 1], name[i]) == 0)
            st = lt_error(LT_EINVAL, "%s: two entries named \"%s\"", path, name[i]);
    }
    lt_release(name);
    return st;
}

static lt_status check_arrays(const char *path, const lt_named_array *entry, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        size_t bytes;

        if (!lt_safetensors_dtype[entry[i].array.type])
            return lt_error(LT_EINVAL, "%s: \"%s\": elements of %s have no dtype", path, entry[i].name,
                            lt_elem_name(entry[i].array.type));
        if (!lt_array_bytes(&entry[i].array, &bytes))
            return lt_error(LT_EINVAL, "%s: \"%s\": impossible shape", path, entry[i].name);
    }
    return LT_OK;
}

static void put_meta(FILE *f, const lt_text_pair *meta, size_t n_meta)
{
    fputs("\"__metadata__\":{", f);
    for (size_t i = 0; i < n_meta; i++) {
        fputs(i ? "," : "", f);
        lt_json_print_string(f, meta[i].key);
        fputc(':', f);
        lt_json_print_string(f, meta[i].value);
    }
    fputc('}', f);
}

static void put_entry(FILE *f, const lt_named_array *e, size_t begin, size_t end)
{
    lt_json_print_string(f, e->name);
    fprintf(f, ":{\"dtype\":\"%s\",\"shape\":[", lt_safetensors_dtype[e->array.type]);
    for (int i = 0; i < e->array.rank; i++)
        fprintf(f, "%s%" PRId64, i ? "," : "", e->array.shape[i]);
    fprintf(f, "],\"data_offsets\":[%zu,%zu]}", begin, end);
}

/* Header and its length, so that the data starts at a multiple of 64 bytes. */
static void put_header(FILE *f, const lt_named_array *entry, size_t n, const lt_text_pair *meta,
                       size_t n_meta)
{
    size_t at = 0;

    fputc('{', f);
    if (n_meta)
        put_meta(f, meta, n_meta);
    for (size_t i = 0; i < n; i++) {
        size_t bytes = 0;

        lt_array_bytes(&entry[i].array, &bytes);
        fputs(i || n_meta ? "," : "", f);
        put_entry(f, &entry[i], at, at + bytes);
        at += bytes;
    }
    fputc('}', f);
    while ((8 + ftell(f)) % 64)
        fputc(' ', f);
}

static void put_data(FILE *f, const lt_array *a)
{
    const size_t width = lt_elem_size(a->type), count = lt_array_count(a);
    const uint8_t *p = a->data;

    if (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__) {
        if (count)
            fwrite(p, width, count, f);
        return;
    }
    for (size_t i = 0; i < count; i++, p += width)
        for (size_t k = width; k-- > 0;)
            fputc(p[k], f);
}

static lt_status write_file(const char *path, const char *header, size_t length,
                            const lt_named_array *entry, size_t n)
{
    lt_atomic_file f;
    lt_status st = lt_atomic_open(&f, path);

    if (st)
        return st;
    for (int i = 0; i < 8; i++)
        fputc((int)((uint64_t)length >> (8 * i) & 0xff), f.stream);
    fwrite(header, 1, length, f.stream);
    for (size_t i = 0; i < n; i++)
        put_data(f.stream, &entry[i].array);
    return lt_atomic_commit(&f);
}

lt_status lt_safetensors_write(const char *path, const lt_named_array *entry, size_t n,
                               const lt_text_pair *meta, size_t n_meta)
{
    char *header = NULL;
    size_t length = 0;
    FILE *memory;
    lt_status st = check_names(path, entry, n);

    if (!st)
        st = check_arrays(path, entry, n);
    if (st)
        return st;
    memory = open_memstream(&header, &length);
    if (!memory)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    put_header(memory, entry, n, meta, n_meta);
    st = ferror(memory) ? LT_ENOMEM : LT_OK;
    if (fclose(memory) != 0 || st)
        st = lt_error(LT_ENOMEM, "%s: no memory for its header", path);
    else
        st = write_file(path, header, length, entry, n);
    free(header);
    return st;
}
