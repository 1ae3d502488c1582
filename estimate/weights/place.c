/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/weights/place.h"

#include "estimate/param_arrays.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A parameter's name has fewer parts than this, and so has what follows a prefix. */
enum { PARTS = 12, BLOCKS = 32 };

/* One array that has a parameter's name behind some prefix. */
typedef struct {
    const char *name;               /* the array's; the prefix are its first prefix_length characters */
    size_t prefix_length, entry;    /* which array of the file it is */
    int family, block;              /* -1: the name is whole */
    bool fits;
} hit;

typedef struct {
    lt_arena *arena;
    const lt_weights_file *file;
    const model *m;
    hit *list;
    size_t n, room;
} hits;

bool weight_passed_over(const char *name)
{
    const char *last = strrchr(name, '.');

    return (last && strcmp(last, ".num_batches_tracked") == 0) || strncmp(name, "optim.", 6) == 0;
}

lt_param *weight_param_in(const model *m, const char *block, const char *name)
{
    char full[WEIGHT_NAME + 64];
    const int n = snprintf(full, sizeof(full), "%s.%s", block, name);

    return n > 0 && (size_t)n < sizeof(full) ? lt_params_find(m->params, full) : NULL;
}

lt_param *weight_param(const weight_place *place, const model *m, const char *name)
{
    char ours[WEIGHT_NAME];
    lt_param *p;

    if (strncmp(name, place->prefix, place->prefix_length) != 0 ||
        !place->family->ours(name + place->prefix_length, ours))
        return NULL;
    p = lt_params_find(m->params, ours);
    return p || !place->block ? p : weight_param_in(m, place->block, ours);
}

/* ---- every name behind every prefix -------------------------------------------------------------------- */

/* Entries behind the file's arrays are those that are not read, which fit nothing. */
static bool add_hit(hits *h, size_t entry, size_t prefix_length, int family, int block, const lt_param *p)
{
    const bool read = entry < h->file->n;
    const lt_named_array *e = read ? &h->file->entry[entry] : NULL;

    h->list = lt_arena_grow(h->arena, h->list, h->n, &h->room, sizeof(*h->list));
    if (!h->list)
        return false;
    h->list[h->n++] = (hit){
        .name = e ? e->name : h->file->refused[entry - h->file->n].name, .prefix_length = prefix_length, .entry = entry,
        .family = family, .block = block, .fits = e && array_fits(&e->array, &p->shape),
    };
    return true;
}

/* The name behind one prefix, in every family's words, as the whole name of a parameter and as one in each block. */
static bool try_prefix(hits *h, size_t entry, const char *name, size_t prefix_length)
{
    bool good = true;

    for (int f = 0; weight_families[f].name; f++) {
        char ours[WEIGHT_NAME];
        const lt_param *p;

        if (!weight_families[f].ours(name + prefix_length, ours))
            continue;
        p = lt_params_find(h->m->params, ours);
        if (p) {
            good = good && add_hit(h, entry, prefix_length, f, -1, p);
            continue;
        }
        for (int b = 0; b < BLOCKS && h->m->cls->blocks[b]; b++) {
            p = weight_param_in(h->m, h->m->cls->blocks[b], ours);
            good = good && (!p || add_hit(h, entry, prefix_length, f, b, p));
        }
    }
    return good;
}

/* A prefix ends at a dot, or is none. */
static bool try_name(hits *h, size_t entry, const char *name)
{
    size_t at = strlen(name);

    if (weight_passed_over(name))
        return true;
    for (int parts = 0; parts < PARTS && at > 0; parts++) {
        for (at--; at > 0 && name[at - 1] != '.';)
            at--;
        if (!try_prefix(h, entry, name, at))
            return false;
    }
    return true;
}

static bool collect(hits *h)
{
    for (size_t i = 0; i < h->file->n; i++)
        if (!try_name(h, i, h->file->entry[i].name))
            return false;
    for (size_t i = 0; i < h->file->n_refused; i++)
        if (!try_name(h, h->file->n + i, h->file->refused[i].name))
            return false;
    return true;
}

/* ---- which is the best ---------------------------------------------------------------------------------- */

static int compare_prefix(const hit *x, const hit *y)
{
    const size_t n = x->prefix_length < y->prefix_length ? x->prefix_length : y->prefix_length;
    const int order = strncmp(x->name, y->name, n);

    return order ? order : (x->prefix_length > y->prefix_length) - (x->prefix_length < y->prefix_length);
}

static int by_prefix(const void *a, const void *b)
{
    const hit *x = a, *y = b;
    const int order = compare_prefix(x, y);

    if (order)
        return order;
    if (x->family != y->family)
        return x->family - y->family;
    return (x->entry > y->entry) - (x->entry < y->entry);
}

/* Hits of one prefix and family, counted: those of whole names, and of the block that has most. */
typedef struct {
    const hit *first;
    int block, fit, named;
} group;

static group count_group(const hit *list, size_t n)
{
    int fit[BLOCKS + 1] = { 0 }, named[BLOCKS + 1] = { 0 }, best = 0;

    for (size_t i = 0; i < n; i++) {
        fit[list[i].block + 1] += list[i].fits;
        named[list[i].block + 1]++;
    }
    for (int b = 1; b <= BLOCKS; b++)
        if (named[b] && (!best || fit[b] > fit[best] || (fit[b] == fit[best] && named[b] > named[best])))
            best = b;
    return (group){ list, best - 1, fit[0] + (best ? fit[best] : 0), named[0] + (best ? named[best] : 0) };
}

/* How much better a is; of two alike the one whose arrays come first in the file. */
static int compare_groups(const group *a, const group *b)
{
    if (a->fit != b->fit)
        return a->fit - b->fit;
    return a->named - b->named;
}

/* Whether a is of the same arrays as one of n others: it may begin further right, or be in another family's words. */
static bool is_among(const group *a, const group *const *list, int n)
{
    for (int i = 0; i < n; i++)
        if (list[i]->first->entry == a->first->entry)
            return true;
    return false;
}

static const char *prefix_text(lt_arena *arena, const hit *h)
{
    return lt_arena_printf(arena, "%.*s", (int)h->prefix_length, h->name);
}

/* Those that are as good as the best, each set of arrays once. */
static lt_status list_also(hits *h, const group *list, size_t n, const group *best, weight_place *out)
{
    const group *alike[1 + WEIGHT_ALSO] = { best };

    for (size_t i = 0; best->fit && i < n && out->n_also < WEIGHT_ALSO; i++) {
        if (compare_groups(&list[i], best) != 0 || is_among(&list[i], alike, 1 + out->n_also))
            continue;
        out->also[out->n_also] = prefix_text(h->arena, list[i].first);
        if (!out->also[out->n_also])
            return lt_error(LT_ENOMEM, "%s: no memory", h->file->path);
        alike[1 + out->n_also++] = &list[i];
    }
    return LT_OK;
}

static lt_status choose(hits *h, const group *list, size_t n, weight_place *out)
{
    const group *best = &list[0];

    for (size_t i = 1; i < n; i++) {
        const int better = compare_groups(&list[i], best);

        if (better > 0 || (better == 0 && list[i].first->entry < best->first->entry))
            best = &list[i];
    }
    out->family = &weight_families[best->first->family];
    out->prefix = prefix_text(h->arena, best->first);
    out->prefix_length = best->first->prefix_length;
    out->block = best->block < 0 ? NULL : h->m->cls->blocks[best->block];
    out->fit = best->fit;
    out->named = best->named;
    return out->prefix ? list_also(h, list, n, best, out) : lt_error(LT_ENOMEM, "%s: no memory", h->file->path);
}

lt_status weight_place_find(lt_arena *arena, const lt_weights_file *file, const model *m, weight_place *out)
{
    hits h = { .arena = arena, .file = file, .m = m };
    size_t n = 0;
    group *list;

    *out = (weight_place){ .family = weight_families, .prefix = "" };
    if (!collect(&h))
        return lt_error(LT_ENOMEM, "%s: no memory to match %zu names", file->path, file->n);
    if (h.n == 0)
        return LT_OK;
    qsort(h.list, h.n, sizeof(*h.list), by_prefix);
    list = lt_arena_array(arena, h.n, sizeof(*list));
    if (!list)
        return lt_error(LT_ENOMEM, "%s: no memory to match %zu names", file->path, file->n);
    for (size_t i = 0, end; i < h.n; i = end) {
        for (end = i + 1; end < h.n && h.list[end].family == h.list[i].family &&
                          compare_prefix(&h.list[end], &h.list[i]) == 0;)
            end++;
        list[n++] = count_group(h.list + i, end - i);
    }
    return choose(&h, list, n, out);
}
