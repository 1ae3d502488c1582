/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checkpoints before PyTorch 1.6: five pickles one behind the other (a magic number, the version, the
 * writer's machine, the saved value, the keys of its storages), then for each key its storage: an 8-byte
 * count and the elements.
 *
 * Source: pytorch torch/serialization.py (_legacy_load).
 */
#include "libtensor/io/torch/internal.h"

#include <string.h>

enum { MAGIC_BYTES = 15, PROTOCOL_VERSION = 1001 };

/* The pickle and its offset grow together: names of what is read last. */
typedef struct {
    lt_torch *t;
    size_t pos;
    lt_torch_storage **sorted;          /* by key */
} stream;

static lt_status next(stream *s, const lt_pvalue **out)
{
    return lt_torch_pickle(s->t, s->t->path, s->t->bytes, s->t->n, &s->pos, out);
}

static lt_status read_head(stream *s)
{
    const lt_pvalue *version, *machine, *little;
    int64_t x = 0;
    lt_status st;

    s->pos = MAGIC_BYTES;
    st = next(s, &version);
    if (!st && (!lt_pint(version, &x) || x != PROTOCOL_VERSION))
        st = lt_error(LT_EFORMAT, "%s: a checkpoint of version %jd, want %d", s->t->path, (intmax_t)x,
                      PROTOCOL_VERSION);
    if (!st)
        st = next(s, &machine);
    if (st)
        return st;
    little = lt_pdict_get(machine, "little_endian");
    s->t->big_endian = little && little->kind == LT_PBOOL && !little->u.integer;
    return LT_OK;
}

/* The first mention of key among the sorted ones, or n_storages. */
static size_t first_of(const stream *s, const char *key)
{
    size_t lo = 0, hi = s->t->n_storages;

    while (lo < hi) {
        const size_t mid = (lo + hi) / 2;

        if (strcmp(s->sorted[mid]->key, key) < 0)
            lo = mid + 1;
        else
            hi = mid;
    }
    return lo;
}

/* How long the elements behind pos are; their count must be what the mention promised. */
static lt_status check_storage(const stream *s, const lt_torch_storage *m, size_t *bytes)
{
    const size_t left = s->t->n - s->pos;
    uint64_t count = 0;

    for (int i = 7; left >= 8 && i >= 0; i--)
        count = count << 8 | s->t->bytes[s->pos + (size_t)i];
    if (left < 8 || !lt_size_mul((size_t)m->count, lt_elem_size(m->type), bytes) || *bytes > left - 8)
        return lt_error(LT_EFORMAT, "%s: offset %zu: storage \"%s\" of %ju %s does not fit into the %zu bytes left; "
                        "where the file is cut short, copy or download it again", s->t->path, s->pos, m->key,
                        (uintmax_t)m->count, lt_elem_name(m->type), left);
    if (count != m->stored)
        return lt_error(LT_EFORMAT, "%s: offset %zu: storage \"%s\" has %ju elements, its mention at %zu says %ju",
                        s->t->path, s->pos, m->key, (uintmax_t)count, m->at, (uintmax_t)m->stored);
    return LT_OK;
}

/* The mention that a tensor is in, of those of one key from first on; all such must agree. NULL when they do not. */
static const lt_torch_storage *agreed(const stream *s, size_t first)
{
    const lt_torch_storage *m = s->sorted[first];

    for (size_t i = first; i < s->t->n_storages && strcmp(s->sorted[i]->key, m->key) == 0; i++) {
        const lt_torch_storage *other = s->sorted[i];

        if (!m->used)
            m = other;
        if (other->used && (other->type != m->type || other->count != m->count))
            return NULL;
    }
    return m;
}

static lt_status read_storage(stream *s, const char *key)
{
    const size_t first = first_of(s, key), n = s->t->n_storages;
    const lt_torch_storage *m;
    size_t bytes = 0;
    uint8_t *p;
    lt_status st;

    if (first == n || strcmp(s->sorted[first]->key, key) != 0)
        return lt_error(LT_EFORMAT, "%s: offset %zu: storage \"%s\", which nothing mentions", s->t->path, s->pos, key);
    if (s->sorted[first]->bytes)
        return lt_error(LT_EFORMAT, "%s: offset %zu: storage \"%s\" is listed twice", s->t->path, s->pos, key);
    m = agreed(s, first);
    if (!m)
        return lt_error(LT_EFORMAT, "%s: storage \"%s\" is mentioned with two types or sizes", s->t->path, key);
    st = check_storage(s, m, &bytes);
    if (!st)
        st = lt_torch_alloc(s->t, bytes, &p);
    if (st)
        return st;
    if (bytes)
        memcpy(p, s->t->bytes + s->pos + 8, bytes);
    lt_torch_native(s->t, p, bytes, m->type);
    s->pos += 8 + bytes;
    for (size_t i = first; i < n && strcmp(s->sorted[i]->key, key) == 0; i++)
        s->sorted[i]->bytes = p;
    return LT_OK;
}

static lt_status read_storages(stream *s)
{
    const lt_pvalue *keys;
    lt_status st = next(s, &keys);

    if (!st && keys->kind != LT_PLIST)
        st = lt_error(LT_EFORMAT, "%s: no list of storages behind the saved value", s->t->path);
    if (st)
        return st;
    s->sorted = lt_torch_sorted(s->t);
    if (!s->sorted)
        return LT_ENOMEM;
    for (size_t i = 0; !st && i < keys->n; i++) {
        const char *key = lt_pstr(keys->u.item[i]);

        st = key ? read_storage(s, key) : lt_error(LT_EFORMAT, "%s: a storage's key is no text", s->t->path);
    }
    return st;
}

lt_status lt_torch_stream(lt_torch *t, const lt_pvalue **out)
{
    stream s = { .t = t };
    lt_status st;

    t->in_stream = true;
    st = read_head(&s);
    if (!st)
        st = next(&s, out);
    return st ? st : read_storages(&s);
}
