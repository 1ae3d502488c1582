/* SPDX-License-Identifier: Apache-2.0 */
/*
 * NumPy's .npz: reading.
 */
#include "libtensor/io/array/npz.h"

#include "libtensor/io/array/npy_entry.h"
#include "libtensor/io/array/zip_read.h"
#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"

#include <string.h>

/* "weights.npy" is the array "weights"; a name that ends otherwise is kept, as NumPy keeps it. */
static void strip_suffix(char *name)
{
    const size_t n = strlen(name);

    if (n > 4 && strcmp(name + n - 4, ".npy") == 0)
        name[n - 4] = '\0';
}

/* The pickle of an array of objects, out of memory that goes; others that are refused have none. */
static bool keep_pickle(lt_arena *arena, lt_refused_array *r)
{
    uint8_t *copy = r->pickle ? lt_arena_alloc(arena, r->n) : NULL;

    if (copy)
        memcpy(copy, r->pickle, r->n);
    if (r->pickle && !copy)
        return false;
    r->pickle = copy;
    return true;
}

/* Entry i, called so in error lines; its elements only where they are wanted. */
static lt_status read_entry(lt_arena *arena, lt_zip *z, size_t i, bool elements, const char *where, lt_npz *out)
{
    const size_t all = z->entry[i].bytes, n = elements || all < LT_NPY_READ_MAX ? all : LT_NPY_READ_MAX;
    lt_named_array *e = &out->entry[out->n];
    lt_refused_array *r = &out->refused[out->n_refused];
    uint8_t *bytes = lt_alloc(n);
    lt_status st = bytes ? lt_zip_look(z, i, bytes, n) : lt_error(LT_ENOMEM, "%s: no memory for %zu bytes", z->path, n);

    if (!st && !lt_ends_with(z->entry[i].name, ".npy") && lt_kind_of(bytes, n) != LT_KIND_NPY)
        r->reason = "no .npy array";                            /* a text that somebody put beside them */
    else if (!st && elements)
        st = lt_npy_parse_entry(arena, where, bytes, n, &e->array, r);
    else if (!st)
        st = lt_npy_describe(where, bytes, n, all, &e->array, &r->reason);
    if (!st && !keep_pickle(arena, r))
        st = lt_error(LT_ENOMEM, "%s: no memory for %zu bytes", z->path, r->n);
    lt_release(bytes);
    return st;
}

static lt_status add_entry(lt_arena *arena, lt_zip *z, size_t i, bool elements, lt_npz *out)
{
    char *where = lt_arena_printf(arena, "%s: \"%s\"", z->path, z->entry[i].name);
    char *name = lt_arena_strdup(arena, z->entry[i].name);
    lt_status st = where && name ? read_entry(arena, z, i, elements, where, out)
                                 : lt_error(LT_ENOMEM, "%s: no memory", z->path);

    if (st)
        return st;
    strip_suffix(name);
    if (out->refused[out->n_refused].reason)
        out->refused[out->n_refused++].name = name;
    else
        out->entry[out->n++].name = name;
    return LT_OK;
}

/* What is asked for: arrays of these names, NULL for all; with their elements or without. */
typedef struct {
    const char *const *name;
    size_t n;
    bool elements;
} selection;

static bool selected(const selection *only, const char *entry)
{
    for (size_t i = 0; i < only->n; i++) {
        const size_t n = strlen(only->name[i]);

        if (strncmp(entry, only->name[i], n) == 0 && (entry[n] == '\0' || strcmp(entry + n, ".npy") == 0))
            return true;
    }
    return !only->name;
}

static lt_status read_entries(lt_arena *arena, lt_zip *z, const selection *only, lt_npz *out)
{
    lt_npz npz = { .path = lt_arena_strdup(arena, z->path) };

    npz.entry = lt_arena_array(arena, z->n, sizeof(*npz.entry));
    npz.refused = lt_arena_array(arena, z->n, sizeof(*npz.refused));
    if (!npz.path || !npz.entry || !npz.refused)
        return lt_error(LT_ENOMEM, "%s: no memory for %zu entries", z->path, z->n);
    for (size_t i = 0; i < z->n; i++) {
        lt_status st = selected(only, z->entry[i].name) ? add_entry(arena, z, i, only->elements, &npz) : LT_OK;

        if (st)
            return st;
    }
    *out = npz;
    return LT_OK;
}

static lt_status parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, const selection *only,
                       lt_npz *out)
{
    lt_status st;
    lt_zip z;

    st = lt_zip_open(arena, name, bytes, n, &z);
    if (st)
        return st;
    st = read_entries(arena, &z, only, out);
    lt_zip_close(&z);
    return st;
}

lt_status lt_npz_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_npz *out)
{
    return parse(arena, name, bytes, n, &(selection){ .elements = true }, out);
}

lt_status lt_npz_parse_list(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_npz *out)
{
    return parse(arena, name, bytes, n, &(selection){ .elements = false }, out);
}

lt_status lt_npz_parse_one(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, const char *array,
                           lt_npz *out)
{
    return parse(arena, name, bytes, n, &(selection){ &array, 1, true }, out);
}

static lt_status read_file(lt_arena *arena, const char *path, const selection *only, lt_npz *out)
{
    lt_file file;
    lt_status st = lt_file_load(&file, path, LT_FILE_MAX);

    if (!st)
        st = parse(arena, path, file.bytes, file.n, only, out);
    lt_file_free(&file);
    return st;
}

lt_status lt_npz_read(lt_arena *arena, const char *path, lt_npz *out)
{
    return read_file(arena, path, &(selection){ .elements = true }, out);
}

lt_status lt_npz_read_only(lt_arena *arena, const char *path, const char *const *names, size_t n, lt_npz *out)
{
    return read_file(arena, path, &(selection){ names, n, true }, out);
}

const lt_array *lt_npz_find(const lt_npz *npz, const char *name)
{
    for (size_t i = 0; i < npz->n; i++)
        if (strcmp(npz->entry[i].name, name) == 0)
            return &npz->entry[i].array;
    return NULL;
}

lt_status lt_npz_get(const lt_npz *npz, const char *name, const lt_array **out)
{
    const lt_array *a = lt_npz_find(npz, name);
    const lt_refused_array *refused = a ? NULL : lt_refused_find(npz->refused, npz->n_refused, name);

    if (refused)
        return lt_error(LT_EFORMAT, "%s: \"%s\": %s", npz->path, name, refused->reason);
    if (!a)
        return lt_error(LT_EFORMAT, "%s: no array \"%s\"", npz->path, name);
    *out = a;
    return LT_OK;
}
