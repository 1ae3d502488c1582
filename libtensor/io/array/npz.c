/* SPDX-License-Identifier: Apache-2.0 */
/*
 * NumPy's .npz: reading.
 */
#include "libtensor/io/array/npz.h"

#include "libtensor/io/array/npy_entry.h"
#include "libtensor/io/array/zip_read.h"
#include "libtensor/io/file.h"

#include <string.h>

/* "weights.npy" is the array "weights"; a name that ends otherwise is kept, as NumPy keeps it. */
static void strip_suffix(char *name)
{
    const size_t n = strlen(name);

    if (n > 4 && strcmp(name + n - 4, ".npy") == 0)
        name[n - 4] = '\0';
}

static lt_status read_entry(lt_arena *arena, lt_zip *z, size_t i, lt_npz *out)
{
    const size_t n = z->entry[i].bytes;
    char *where = lt_arena_printf(arena, "%s: \"%s\"", z->path, z->entry[i].name);
    char *name = lt_arena_strdup(arena, z->entry[i].name);
    uint8_t *bytes = lt_alloc(n);
    const char *refused;
    lt_status st;

    if (!where || !name || !bytes) {
        lt_release(bytes);
        return lt_error(LT_ENOMEM, "%s: no memory for %zu bytes", z->path, n);
    }
    strip_suffix(name);
    st = lt_zip_unpack(z, i, bytes);
    if (!st)
        st = lt_npy_parse_entry(arena, where, bytes, n, &out->entry[out->n].array, &refused);
    if (!st && refused)
        out->refused[out->n_refused++] = (lt_npz_refused){ name, refused };
    else if (!st)
        out->entry[out->n++].name = name;
    lt_release(bytes);
    return st;
}

/* The arrays that are asked for; names NULL: all. */
typedef struct {
    const char *const *name;
    size_t n;
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
        lt_status st = selected(only, z->entry[i].name) ? read_entry(arena, z, i, &npz) : LT_OK;

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
    return parse(arena, name, bytes, n, &(selection){ NULL, 0 }, out);
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
    return read_file(arena, path, &(selection){ NULL, 0 }, out);
}

lt_status lt_npz_read_only(lt_arena *arena, const char *path, const char *const *names, size_t n, lt_npz *out)
{
    return read_file(arena, path, &(selection){ names, n }, out);
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

    for (size_t i = 0; !a && i < npz->n_refused; i++)
        if (strcmp(npz->refused[i].name, name) == 0)
            return lt_error(LT_EFORMAT, "%s: \"%s\": %s", npz->path, name, npz->refused[i].reason);
    if (!a)
        return lt_error(LT_EFORMAT, "%s: no array \"%s\"", npz->path, name);
    *out = a;
    return LT_OK;
}
