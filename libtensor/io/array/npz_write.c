/* SPDX-License-Identifier: Apache-2.0 */
/*
 * NumPy's .npz: writing. The archive is built in memory by libzip and written in one piece, so that it
 * appears whole or not at all.
 */
#include "libtensor/io/array/npz.h"

#include "libtensor/io/array/npy_entry.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/text/utf8.h"

#include <string.h>
#include <zip.h>

enum { DOS_DATE_1980 = 1 << 5 | 1 };            /* year 0, month 1, day 1 */

static size_t text_width(const lt_array *a, size_t count)
{
    size_t widest = 1;

    for (size_t i = 0; i < count; i++) {
        const char *p = lt_array_text(a, i), *end = p + strlen(p);
        size_t n = 0;

        for (; p < end; n++)
            lt_utf8_next(&p, end);
        widest = n > widest ? n : widest;
    }
    return widest;
}

/* Text as NumPy's U: 4 bytes a character, padded with zeros to the widest. */
static lt_status widen_text(lt_arena *arena, const lt_array *a, size_t width, const void **data,
                            size_t *bytes)
{
    const size_t count = lt_array_count(a);
    uint32_t *codes;

    if (!lt_size_mul(count, width, bytes))
        return lt_error(LT_ENOMEM, "no memory for %zu texts", count);
    codes = lt_arena_array(arena, *bytes, sizeof(*codes));
    if (!codes || !lt_size_mul(*bytes, sizeof(*codes), bytes))
        return lt_error(LT_ENOMEM, "no memory for %zu texts", count);
    for (size_t i = 0; i < count; i++) {
        const char *p = lt_array_text(a, i), *end = p + strlen(p);

        for (uint32_t *out = codes + i * width; p < end; out++)
            *out = lt_utf8_next(&p, end);
    }
    *data = codes;
    return LT_OK;
}

/* Header and data stay where they are; libzip reads them when the archive is closed. */
static zip_source_t *entry_source(zip_t *archive, lt_arena *arena, const lt_array *a)
{
    zip_buffer_fragment_t *part = lt_arena_array(arena, 2, sizeof(*part));
    uint8_t *header = lt_arena_alloc(arena, LT_NPY_HEADER_MAX);
    const void *data = a->data;
    size_t bytes, width = 0;

    if (!part || !header || !lt_array_bytes(a, &bytes))
        return NULL;
    if (a->type == LT_ELEM_TEXT) {
        width = text_width(a, lt_array_count(a));
        if (widen_text(arena, a, width, &data, &bytes))
            return NULL;
    }
    part[0] = (zip_buffer_fragment_t){ header, lt_npy_header(a, width, header) };
    part[1] = (zip_buffer_fragment_t){ (uint8_t *)(uintptr_t)data, bytes };
    return zip_source_buffer_fragment(archive, part, bytes ? 2 : 1, 0);
}

static lt_status check_entry(const char *path, const lt_named_array *entry, size_t i)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.-/";
    const char *name = entry[i].name;

    if (name[0] == '\0' || name[strspn(name, plain)] != '\0')
        return lt_error(LT_EINVAL, "%s: array name \"%s\", want letters, digits and \"_.-/\"", path, name);
    if (entry[i].array.type == LT_ELEM_BF16)
        return lt_error(LT_EINVAL, "%s: \"%s\" is bf16, which NumPy has no name for", path, name);
    for (size_t k = 0; k < i; k++)
        if (strcmp(entry[k].name, name) == 0)
            return lt_error(LT_EINVAL, "%s: two arrays named \"%s\"", path, name);
    return LT_OK;
}

static lt_status add_entry(zip_t *archive, lt_arena *arena, const char *path, const lt_named_array *e,
                           bool deflate)
{
    const char *name = lt_arena_printf(arena, "%s.npy", e->name);
    zip_source_t *source = name ? entry_source(archive, arena, &e->array) : NULL;
    zip_int64_t i = source ? zip_file_add(archive, name, source, ZIP_FL_ENC_UTF_8) : -1;

    if (source && i < 0)
        zip_source_free(source);
    if (i < 0 ||
        zip_set_file_compression(archive, (zip_uint64_t)i, deflate ? ZIP_CM_DEFLATE : ZIP_CM_STORE, 0) ||
        zip_file_set_dostime(archive, (zip_uint64_t)i, 0, DOS_DATE_1980, 0))
        return lt_error(LT_ENOMEM, "%s: cannot add \"%s\": %s", path, e->name, zip_strerror(archive));
    return LT_OK;
}

static lt_status copy_out(const char *path, zip_source_t *memory)
{
    uint8_t buffer[1 << 15];
    zip_int64_t got;
    lt_atomic_file f;
    lt_status st;

    if (zip_source_open(memory) != 0)
        return lt_error(LT_ENOMEM, "%s: cannot read back the archive", path);
    st = lt_atomic_open(&f, path);
    if (!st) {
        while ((got = zip_source_read(memory, buffer, sizeof(buffer))) > 0)
            fwrite(buffer, 1, (size_t)got, f.stream);
        st = lt_atomic_commit(&f);
    }
    zip_source_close(memory);
    return st;
}

/* Fills the archive and closes it, which packs everything into the memory behind it. */
static lt_status build(zip_t *archive, lt_arena *arena, const char *path, const lt_named_array *entry,
                       size_t n, bool deflate)
{
    lt_status st = LT_OK;

    for (size_t i = 0; i < n && !st; i++) {
        st = check_entry(path, entry, i);
        if (!st)
            st = add_entry(archive, arena, path, &entry[i], deflate);
    }
    if (!st && zip_close(archive) != 0)
        st = lt_error(LT_ENOMEM, "%s: cannot pack: %s", path, zip_strerror(archive));
    if (st)
        zip_discard(archive);
    return st;
}

lt_status lt_npz_write(const char *path, const lt_named_array *entry, size_t n, bool deflate)
{
    lt_arena *arena;
    zip_source_t *memory;
    zip_t *archive;
    lt_status st;

    if (n == 0)
        return lt_error(LT_EINVAL, "%s: no arrays to write", path);
    arena = lt_arena_new();
    memory = zip_source_buffer_create(NULL, 0, 0, NULL);
    archive = memory ? zip_open_from_source(memory, ZIP_CREATE | ZIP_TRUNCATE, NULL) : NULL;
    if (!arena || !archive) {
        st = lt_error(LT_ENOMEM, "%s: no memory", path);
        if (archive)
            zip_discard(archive);       /* and memory with it */
        else if (memory)
            zip_source_free(memory);
        goto done;
    }
    zip_source_keep(memory);            /* past the archive's end: the bytes are in it */
    st = build(archive, arena, path, entry, n, deflate);
    if (!st)
        st = copy_out(path, memory);
    zip_source_free(memory);
done:
    lt_arena_free(arena);
    return st;
}
