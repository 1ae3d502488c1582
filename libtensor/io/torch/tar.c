/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checkpoints before PyTorch 0.1.10: a tar archive of three files. "storages": a count, and for each a
 * pickled (key, device, class) and its elements behind an 8-byte count; then a list of views. "tensors": a
 * count, and for each a pickled (key, storage, class), rank, sizes, strides, offset. "pickle": the saved
 * value, in which keys stand for tensors.
 *
 * Source: pytorch torch/serialization.py (legacy_load within _legacy_load).
 */
#include "libtensor/io/kind.h"
#include "libtensor/io/torch/internal.h"

#include <stdlib.h>
#include <string.h>

enum { BLOCK = 512 };

typedef struct {
    const char *name;                   /* for error lines */
    const uint8_t *bytes;
    size_t n, pos;
} member;

/* What a key stands for. */
typedef struct {
    int64_t key;
    lt_torch_storage *storage;
    lt_pvalue *tensor;
} thing;

typedef struct {
    lt_torch *t;
    member storages, tensors, pickle;
    thing *storage, *tensor;            /* by key, once all are there */
    size_t n_storages, n_tensors;
} tar;

static lt_status bad(const member *f, const char *reason)
{
    return lt_error(LT_EFORMAT, "%s: offset %zu: %s", f->name, f->pos, reason);
}

/* ---- the archive --------------------------------------------------------------------------------- */

/* An octal number of 12 characters, blank or NUL behind it. */
static bool octal(const uint8_t *p, size_t *out)
{
    size_t i = 0;

    for (*out = 0; i < 12 && p[i] >= '0' && p[i] <= '7'; i++)
        *out = *out * 8 + (size_t)(p[i] - '0');
    return i > 0 && (i == 12 || p[i] == '\0' || p[i] == ' ');
}

static lt_status find_members(tar *a)
{
    const struct {
        const char *name;
        member *file;
    } wanted[] = { { "storages", &a->storages }, { "tensors", &a->tensors }, { "pickle", &a->pickle } };
    const lt_torch *t = a->t;
    size_t pos = 0, size;

    while (t->n - pos >= BLOCK && t->bytes[pos] != '\0') {
        const uint8_t *head = t->bytes + pos;

        if (!octal(head + 124, &size) || size > t->n - pos - BLOCK)
            return lt_refuse_cut(t->path, LT_KIND_TAR, "the member at %zu has a size beyond the file", pos);
        for (size_t i = 0; i < LT_COUNT(wanted); i++)
            if (strncmp((const char *)head, wanted[i].name, 100) == 0)
                *wanted[i].file = (member){ .bytes = head + BLOCK, .n = size };
        pos += BLOCK + size;
        pos += lt_min_i64((int64_t)(t->n - pos), (int64_t)((BLOCK - size % BLOCK) % BLOCK));
    }
    for (size_t i = 0; i < LT_COUNT(wanted); i++) {
        if (!wanted[i].file->bytes && t->n - pos < BLOCK)
            return lt_refuse_cut(t->path, LT_KIND_TAR, "without \"%s\", and without its end", wanted[i].name);
        if (!wanted[i].file->bytes)
            return lt_error(LT_EFORMAT, "%s: a tar archive without \"%s\": no checkpoint of PyTorch", t->path,
                            wanted[i].name);
        wanted[i].file->name = lt_arena_printf(t->arena, "%s: %s", t->path, wanted[i].name);
        if (!wanted[i].file->name)
            return lt_error(LT_ENOMEM, "%s: no memory", t->path);
    }
    return LT_OK;
}

static lt_status next(tar *a, member *f, const lt_pvalue **out)
{
    return lt_torch_pickle(a->t, f->name, f->bytes, f->n, &f->pos, out);
}

static lt_status take_i64(member *f, int64_t *out)
{
    uint64_t x = 0;

    if (f->n - f->pos < 8)
        return bad(f, "ends early");
    for (int i = 7; i >= 0; i--)
        x = x << 8 | f->bytes[f->pos + (size_t)i];
    f->pos += 8;
    *out = (int64_t)x;
    return LT_OK;
}

/* A pickled count of things, each of which takes at least 8 bytes, and room for them. */
static lt_status take_count(tar *a, member *f, thing **room, size_t *n)
{
    const lt_pvalue *v;
    uint8_t *p;
    int64_t x;
    lt_status st = next(a, f, &v);

    if (st)
        return st;
    if (!lt_pint(v, &x) || x < 0 || (uint64_t)x > f->n / 8)
        return bad(f, "a count that the file cannot hold");
    st = lt_torch_alloc(a->t, (size_t)x * sizeof(thing), &p);
    if (!st) {
        *room = (thing *)(void *)p;
        *n = (size_t)x;
    }
    return st;
}

static int by_key(const void *a, const void *b)
{
    const thing *x = a, *y = b;

    return x->key < y->key ? -1 : x->key > y->key;
}

static thing *find(thing *list, size_t n, int64_t key)
{
    const thing wanted = { .key = key };

    return n ? bsearch(&wanted, list, n, sizeof(*list), by_key) : NULL;
}

/* Pickled (key, ..., ...): three parts, of which the first is a number. */
static lt_status take_triple(tar *a, member *f, const lt_pvalue **out, int64_t *key)
{
    const lt_status st = next(a, f, out);

    if (st)
        return st;
    if ((*out)->kind != LT_PTUPLE || (*out)->n != 3 || !lt_pint((*out)->u.item[0], key))
        return bad(f, "not a key with two things about it");
    return LT_OK;
}

/* ---- storages ------------------------------------------------------------------------------------ */

static lt_status new_storage(tar *a, thing *out)
{
    uint8_t *p;
    const lt_status st = lt_torch_alloc(a->t, sizeof(lt_torch_storage), &p);

    if (!st)
        out->storage = (lt_torch_storage *)(void *)p;
    return st;
}

static lt_status read_storage(tar *a, member *f, thing *out)
{
    const lt_pvalue *v;
    lt_torch_storage *s;
    int64_t count = 0;
    size_t bytes;
    uint8_t *p;
    lt_status st = take_triple(a, f, &v, &out->key);

    if (!st)
        st = new_storage(a, out);
    if (!st)
        st = take_i64(f, &count);
    if (st)
        return st;
    s = out->storage;
    s->count = s->view_count = (uint64_t)count;
    if (v->u.item[2]->kind != LT_PCLASS || !lt_torch_type(v->u.item[2]->u.text, &s->type))
        return bad(f, "a storage of a class that is not read");
    if (count < 0 || !lt_size_mul((size_t)count, lt_elem_size(s->type), &bytes) || bytes > f->n - f->pos)
        return bad(f, "a storage with more elements than the file has");
    st = lt_torch_alloc(a->t, bytes, &p);
    if (st)
        return st;
    if (bytes)
        memcpy(p, f->bytes + f->pos, bytes);
    lt_torch_native(a->t, p, bytes, s->type);
    f->pos += bytes;
    s->bytes = p;
    return LT_OK;
}

/* (key, of, begin, count): a part of a storage that has a key of its own */
static lt_status read_view(tar *a, const lt_pvalue *v, thing *out)
{
    const thing *of;
    int64_t part[4];
    lt_torch_storage *s;
    lt_status st;

    if (v->kind != LT_PTUPLE || v->n != 4)
        return bad(&a->storages, "a view that is not of four numbers");
    for (int i = 0; i < 4; i++)
        if (!lt_pint(v->u.item[i], &part[i]))
            return bad(&a->storages, "a view that is not of four numbers");
    of = find(a->storage, a->n_storages, part[1]);
    if (!of || part[2] < 0 || part[3] < 0 || (uint64_t)part[2] > of->storage->count ||
        (uint64_t)part[3] > of->storage->count - (uint64_t)part[2])
        return bad(&a->storages, "a view beyond its storage");
    st = new_storage(a, out);
    if (st)
        return st;
    s = out->storage;
    out->key = part[0];
    *s = *of->storage;
    s->view_begin = (uint64_t)part[2];
    s->view_count = (uint64_t)part[3];
    return LT_OK;
}

static lt_status read_views(tar *a)
{
    const lt_pvalue *list;
    size_t n = a->n_storages;
    thing *all;
    uint8_t *p;
    lt_status st = next(a, &a->storages, &list);

    if (st)
        return st;
    if (list->kind != LT_PLIST && list->kind != LT_PTUPLE)
        return bad(&a->storages, "no list of views");
    st = lt_torch_alloc(a->t, (n + list->n) * sizeof(thing), &p);
    if (st)
        return st;
    all = (thing *)(void *)p;
    if (n)
        memcpy(all, a->storage, n * sizeof(thing));
    for (size_t i = 0; !st && i < list->n; i++)
        st = read_view(a, list->u.item[i], &all[n + i]);
    a->storage = all;
    a->n_storages = n + list->n;
    if (!st && a->n_storages)
        qsort(all, a->n_storages, sizeof(thing), by_key);
    return st;
}

static lt_status read_storages(tar *a)
{
    lt_status st = take_count(a, &a->storages, &a->storage, &a->n_storages);

    for (size_t i = 0; !st && i < a->n_storages; i++)
        st = read_storage(a, &a->storages, &a->storage[i]);
    if (!st && a->n_storages)
        qsort(a->storage, a->n_storages, sizeof(thing), by_key);
    return st ? st : read_views(a);
}

/* ---- tensors ------------------------------------------------------------------------------------- */

static lt_status take_sizes(member *f, int rank, int64_t *out)
{
    lt_status st = LT_OK;

    for (int i = 0; !st && i < rank; i++)
        st = take_i64(f, &out[i]);
    return st;
}

static lt_status add_tensor(tar *a, member *f, lt_torch_storage *s, int rank, thing *out)
{
    struct {
        lt_torch_tensor tensor;
        lt_array array;
        lt_pvalue value;
    } *made;
    int64_t shape[LT_ARRAY_MAX_RANK], stride[LT_ARRAY_MAX_RANK], begin;
    const char *wrong;
    uint8_t *p;
    lt_status st = take_sizes(f, rank, shape);

    if (!st)
        st = take_sizes(f, rank, stride);
    if (!st)
        st = take_i64(f, &begin);
    if (!st)
        st = lt_torch_alloc(a->t, sizeof(*made), &p);
    if (st)
        return st;
    made = (void *)p;
    made->array.type = s->type;
    wrong = begin < 0 ? "a negative offset"
                      : lt_torch_view(s, (uint64_t)begin, rank, shape, stride, &made->array, &made->tensor);
    if (wrong)
        return bad(f, wrong);
    lt_torch_add(a->t, &made->tensor);
    made->value = (lt_pvalue){ .kind = LT_PARRAY, .u.array = &made->array };
    out->tensor = &made->value;
    return LT_OK;
}

static lt_status read_tensor(tar *a, member *f, thing *out)
{
    const lt_pvalue *v;
    const thing *s = NULL;
    int64_t key, rank = 0;
    lt_status st = take_triple(a, f, &v, &out->key);

    if (!st && lt_pint(v->u.item[1], &key))
        s = find(a->storage, a->n_storages, key);
    if (!st)
        st = take_i64(f, &rank);
    if (st)
        return st;
    rank &= UINT32_MAX;                         /* the upper half was never written with care */
    if (!s || rank > LT_ARRAY_MAX_RANK)
        return bad(f, "a tensor without storage, or of more than 8 dimensions");
    return add_tensor(a, f, s->storage, (int)rank, out);
}

static lt_status read_tensors(tar *a)
{
    lt_status st = take_count(a, &a->tensors, &a->tensor, &a->n_tensors);

    for (size_t i = 0; !st && i < a->n_tensors; i++)
        st = read_tensor(a, &a->tensors, &a->tensor[i]);
    if (!st && a->n_tensors)
        qsort(a->tensor, a->n_tensors, sizeof(thing), by_key);
    return st;
}

/* A key, as text or a number, or a class with its source. */
static lt_pvalue *tensor_of(lt_pmachine *m, const lt_pvalue *id)
{
    const lt_torch *t = m->context;
    const tar *a = t->container;
    const thing *found = NULL;
    const char *text = lt_pstr(id);
    int64_t key;
    char *end = NULL;

    if (id->kind == LT_PTUPLE && id->n > 0)
        return id->u.item[0];
    key = text ? strtoll(text, &end, 10) : 0;
    if (text ? end != text && *end == '\0' : lt_pint(id, &key))
        found = find(a->tensor, a->n_tensors, key);
    if (found)
        return found->tensor;
    lt_pm_fail(m, "a tensor that is not among the file's");
    return m->none;
}

lt_status lt_torch_tar(lt_torch *t, const lt_pvalue **out)
{
    tar a = { .t = t };
    lt_status st = find_members(&a);

    if (!st)
        st = read_storages(&a);
    if (!st)
        st = read_tensors(&a);
    if (st)
        return st;
    t->by_key = tensor_of;
    t->container = &a;
    st = next(&a, &a.pickle, out);
    t->by_key = NULL;
    return st;
}
