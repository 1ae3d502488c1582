/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checkpoints since PyTorch 1.6: a zip archive with the pickle NAME/data.pkl and each storage's bytes in
 * NAME/data/KEY. TorchScript's programs have the same two, of modules, beside code that nobody looks at.
 *
 * Source: pytorch torch/serialization.py (_load), caffe2/serialize/inline_container.h.
 */
#include "libtensor/io/array/zip_read.h"
#include "libtensor/io/file.h"
#include "libtensor/io/torch/internal.h"

#include <stdlib.h>
#include <string.h>

/* Where a storage lies in the archive. */
typedef struct {
    const char *key;
    size_t entry;
} record;

typedef struct {
    lt_torch *t;
    lt_zip zip;
    const char *root;               /* "NAME/" */
    record *record;                 /* by key */
    size_t n;
} archive;

static const char *behind(const char *name, const char *prefix)
{
    const size_t n = strlen(prefix);

    return strncmp(name, prefix, n) == 0 ? name + n : NULL;
}

static lt_status find_root(archive *a)
{
    const char *found = NULL;

    for (size_t i = 0; i < a->zip.n && !found; i++)
        if (lt_ends_with(a->zip.entry[i].name, "/data.pkl"))
            found = a->zip.entry[i].name;
    if (!found)
        return lt_error(LT_EFORMAT, "%s: a zip archive without data.pkl: no checkpoint of PyTorch", a->t->path);
    a->root = lt_arena_printf(a->t->arena, "%.*s", (int)(strlen(found) - strlen("data.pkl")), found);
    return a->root ? LT_OK : lt_error(LT_ENOMEM, "%s: no memory", a->t->path);
}

/* The bytes of entry i, into *out. */
static lt_status unpack(archive *a, size_t i, uint8_t **out)
{
    const lt_status st = lt_torch_alloc(a->t, a->zip.entry[i].bytes, out);

    return st ? st : lt_zip_unpack(&a->zip, i, *out);
}

/* Entry NAME/wanted, or zip.n. */
static size_t find_entry(const archive *a, const char *wanted)
{
    size_t i = 0;

    for (; i < a->zip.n; i++) {
        const char *name = behind(a->zip.entry[i].name, a->root);

        if (name && strcmp(name, wanted) == 0)
            break;
    }
    return i;
}

/* "byteorder" is there since 2.1; before that it was always little. */
static lt_status read_byte_order(archive *a)
{
    const size_t i = find_entry(a, "byteorder");
    uint8_t *text;
    lt_status st;

    if (i == a->zip.n)
        return LT_OK;
    st = unpack(a, i, &text);
    if (!st)
        a->t->big_endian = a->zip.entry[i].bytes == 3 && memcmp(text, "big", 3) == 0;
    return st;
}

static lt_status read_pickle(archive *a, const lt_pvalue **out)
{
    const size_t i = find_entry(a, "data.pkl");
    const char *name = lt_arena_printf(a->t->arena, "%s: data.pkl", a->t->path);
    uint8_t *bytes;
    size_t pos = 0;
    lt_status st = name ? unpack(a, i, &bytes) : lt_error(LT_ENOMEM, "%s: no memory", a->t->path);

    return st ? st : lt_torch_pickle(a->t, name, bytes, a->zip.entry[i].bytes, &pos, out);
}

/* ---- storages ------------------------------------------------------------------------------------ */

static int by_key(const void *a, const void *b)
{
    return strcmp(((const record *)a)->key, ((const record *)b)->key);
}

static lt_status list_records(archive *a)
{
    a->record = lt_arena_array(a->t->arena, a->zip.n, sizeof(*a->record));
    if (!a->record)
        return lt_error(LT_ENOMEM, "%s: no memory", a->t->path);
    for (size_t i = 0; i < a->zip.n; i++) {
        const char *name = behind(a->zip.entry[i].name, a->root), *key = name ? behind(name, "data/") : NULL;

        if (key)
            a->record[a->n++] = (record){ key, i };
    }
    if (a->n)
        qsort(a->record, a->n, sizeof(*a->record), by_key);
    return LT_OK;
}

static lt_status load(archive *a, lt_torch_storage *s)
{
    const record wanted = { .key = s->key };
    const record *r = a->n ? bsearch(&wanted, a->record, a->n, sizeof(wanted), by_key) : NULL;
    const size_t found = r ? a->zip.entry[r->entry].bytes : 0;
    uint8_t *bytes;
    size_t want;
    lt_status st;

    if (!r)
        return lt_error(LT_EFORMAT, "%s: data.pkl: offset %zu: storage \"%s\" is not in the archive", a->t->path,
                        s->at, s->key);
    if (!lt_size_mul((size_t)s->count, lt_elem_size(s->type), &want) || want != found)
        return lt_error(LT_EFORMAT, "%s: data.pkl: offset %zu: storage \"%s\" has %zu bytes, want %ju of %s",
                        a->t->path, s->at, s->key, found, (uintmax_t)s->count, lt_elem_name(s->type));
    st = unpack(a, r->entry, &bytes);
    if (st)
        return st;
    lt_torch_native(a->t, bytes, found, s->type);
    s->bytes = bytes;
    return LT_OK;
}

static bool same(const lt_torch_storage *a, const lt_torch_storage *b)
{
    return a->type == b->type && a->count == b->count && strcmp(a->key, b->key) == 0;
}

static lt_status load_storages(archive *a)
{
    lt_torch_storage **sorted = lt_torch_sorted(a->t);
    const lt_torch_storage *last = NULL;
    lt_status st = sorted ? list_records(a) : LT_ENOMEM;

    for (size_t i = 0; !st && i < a->t->n_storages; i++) {
        lt_torch_storage *s = sorted[i];

        if (!s->used)
            continue;
        if (last && same(last, s))
            s->bytes = last->bytes;
        else
            st = load(a, s);
        last = s;
    }
    return st;
}

lt_status lt_torch_zip(lt_torch *t, const lt_pvalue **out)
{
    archive a = { .t = t };
    lt_status st = lt_zip_open(t->arena, t->path, t->bytes, t->n, &a.zip);

    if (st)
        return st;
    st = find_root(&a);
    if (!st)
        st = read_byte_order(&a);
    if (!st)
        st = read_pickle(&a, out);
    if (!st)
        st = load_storages(&a);
    lt_zip_close(&a.zip);
    return st;
}
