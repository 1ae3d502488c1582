/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The elements of a storage, and of the tensors that are windows into one: what the three containers share.
 */
#include "libtensor/io/array/raw_array.h"
#include "libtensor/io/torch/internal.h"

#include <stdlib.h>
#include <string.h>

/* ---- storages ------------------------------------------------------------------------------------ */

static int by_key(const void *a, const void *b)
{
    const lt_torch_storage *const *x = a, *const *y = b;

    return strcmp((*x)->key, (*y)->key);
}

lt_torch_storage **lt_torch_sorted(lt_torch *t)
{
    lt_torch_storage **sorted = lt_arena_array(t->arena, t->n_storages, sizeof(*sorted));
    size_t n = 0;

    for (lt_torch_storage *s = t->storages; sorted && s; s = s->next)
        sorted[n++] = s;
    if (n)
        qsort(sorted, n, sizeof(*sorted), by_key);
    else if (!sorted)
        lt_error(LT_ENOMEM, "%s: no memory", t->path);
    return sorted;
}

lt_status lt_torch_alloc(lt_torch *t, size_t bytes, uint8_t **out)
{
    void *p;
    lt_status st;

    if (bytes > lt_pm_budget(t->n) - t->spent)
        return lt_error(LT_EFORMAT, "%s: its tensors ask for more memory than a file of %zu bytes should; save "
                        "expanded ones contiguous", t->path, t->n);
    t->spent += bytes;
    st = lt_arena_try(t->arena, bytes, &p);
    if (st)
        return lt_error_prefix(st, "%s", t->path);
    *out = p;
    return LT_OK;
}

void lt_torch_native(const lt_torch *t, uint8_t *p, size_t n, lt_elem type)
{
    static const bool host_is_big = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;

    if (t->big_endian != host_is_big)
        lt_swap_bytes(p, n, lt_elem_size(type));
    for (size_t i = 0; type == LT_ELEM_BOOL && i < n; i++)
        p[i] = p[i] != 0;
}

/* ---- tensors ------------------------------------------------------------------------------------- */

const char *lt_torch_view(lt_torch_storage *s, uint64_t begin, int rank, const int64_t *shape,
                          const int64_t *stride, lt_array *array, lt_torch_tensor *out)
{
    uint64_t last = begin, step;
    bool empty = false;
    size_t bytes;

    *out = (lt_torch_tensor){ .array = array, .storage = s, .begin = begin };
    for (int d = 0; d < rank; d++) {
        if (shape[d] < 0 || stride[d] < 0)
            return "negative size or stride";
        empty |= shape[d] == 0;
        out->stride[d] = (uint64_t)stride[d];
        if (shape[d] > 0 && (__builtin_mul_overflow((uint64_t)shape[d] - 1, out->stride[d], &step) ||
                             __builtin_add_overflow(last, step, &last)))
            return "strides that overflow";
    }
    *array = lt_array_make(array->type, rank, shape, NULL);
    if (!lt_array_bytes(array, &bytes))
        return "sizes that overflow";
    return empty || last < s->view_count ? NULL : "an element beyond its storage";
}

void lt_torch_add(lt_torch *t, lt_torch_tensor *x)
{
    x->storage->used = true;
    x->next = t->tensors;
    t->tensors = x;
}

static bool is_contiguous(const lt_torch_tensor *x)
{
    uint64_t step = 1;

    for (int d = x->array->rank - 1; d >= 0; d--) {
        if (x->array->shape[d] != 1 && x->stride[d] != step)
            return false;
        step *= (uint64_t)x->array->shape[d];
    }
    return true;
}

/* Storages lie at the start of arena blocks, so elements are aligned. */
static lt_status fill(lt_torch *t, const lt_torch_tensor *x)
{
    const size_t size = lt_elem_size(x->array->type);
    const uint8_t *from = x->storage->bytes;
    uint8_t *to;
    size_t bytes;
    lt_status st;

    if (!from)
        return lt_error(LT_EFORMAT, "%s: offset %zu: storage \"%s\" is not in the file", t->path, x->storage->at,
                        x->storage->key);
    lt_array_bytes(x->array, &bytes);
    if (bytes > 0)
        from += (x->storage->view_begin + x->begin) * size;
    x->array->data = (void *)(uintptr_t)from;
    if (bytes == 0 || is_contiguous(x))
        return LT_OK;
    st = lt_torch_alloc(t, bytes, &to);
    if (st)
        return st;
    lt_copy_strided(to, from, size, x->array->rank, x->array->shape, x->stride);
    x->array->data = to;
    return LT_OK;
}

lt_status lt_torch_fill(lt_torch *t)
{
    lt_status st = LT_OK;

    for (const lt_torch_tensor *x = t->tensors; !st && x; x = x->next)
        st = fill(t, x);
    return st;
}
