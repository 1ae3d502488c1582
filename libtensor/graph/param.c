/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/graph/param.h"

#include "libtensor/graph/internal.h"

#include <stdio.h>
#include <string.h>

struct lt_params {
    lt_arena *arena;
    lt_param *first, **tail;
    lt_param **bucket;              /* open hash of names, a power of two */
    size_t n, n_buckets;
    bool deferred;                  /* values come later */
    uint64_t version;               /* how often values have changed */
    uint64_t moves;                 /* how often a parameter has got another place in memory */
    int batches;                    /* that statistics have collected since they were forgotten */
    bool collected;                 /* some were, and no update has used them */
    lt_status status;
    char error[512];
    lt_param stand_in;
};

static lt_real stand_in_value;

static uint64_t hash(const char *s)
{
    uint64_t h = 14695981039346656037u;         /* FNV-1a */

    for (; *s; s++)
        h = (h ^ (unsigned char)*s) * 1099511628211u;
    return h;
}

lt_params *lt_params_new(void)
{
    lt_arena *arena = lt_arena_new();
    lt_params *set = arena ? lt_arena_alloc(arena, sizeof(*set)) : NULL;

    if (!set) {
        lt_arena_free(arena);
        return NULL;
    }
    set->arena = arena;
    set->tail = &set->first;
    set->stand_in = (lt_param){ .name = "", .data = &stand_in_value, .set = set, .frozen = true };
    return set;
}

void lt_params_free(lt_params *set)
{
    if (!set)
        return;
    for (lt_param *p = set->first; p; p = p->next)
        if (p->rows)
            lt_rows_fini(p);
    lt_arena_free(set->arena);
}

static lt_param **slot_of(const lt_params *set, const char *name)
{
    size_t i = hash(name) & (set->n_buckets - 1);

    while (set->bucket[i] && strcmp(set->bucket[i]->name, name) != 0)
        i = (i + 1) & (set->n_buckets - 1);
    return &set->bucket[i];
}

/* Keep at least half of the buckets empty. */
static bool grow(lt_params *set)
{
    const size_t n = set->n_buckets ? 2 * set->n_buckets : 256;
    lt_param **bucket;

    if (2 * (set->n + 1) <= set->n_buckets)
        return true;
    bucket = lt_arena_array(set->arena, n, sizeof(*bucket));
    if (!bucket)
        return false;
    set->bucket = bucket;
    set->n_buckets = n;
    for (lt_param *p = set->first; p; p = p->next)
        *slot_of(set, p->name) = p;
    return true;
}

static lt_param *refuse(lt_params *set, lt_status status)
{
    if (set->status == LT_OK) {
        set->status = status;
        snprintf(set->error, sizeof(set->error), "%s", lt_last_error());
    }
    return &set->stand_in;
}

static bool allocate(lt_params *set, lt_param *p)
{
    if (p->rows)
        return lt_rows_allocate(p) == LT_OK;
    p->data = lt_arena_array(set->arena, (size_t)lt_param_numel(p), sizeof(lt_real));
    if (!p->data)
        lt_error(LT_ENOMEM, "parameter \"%s\": no memory for %lld values", p->name, (long long)lt_param_numel(p));
    return p->data != NULL;
}

void lt_params_defer(lt_params *set)
{
    set->deferred = true;
}

lt_status lt_params_allocate(lt_params *set)
{
    set->deferred = false;
    for (lt_param *p = set->first; p; p = p->next)
        if (!p->data && !allocate(set, p))
            return LT_ENOMEM;
    return LT_OK;
}

static lt_param *add(lt_params *set, const char *prefix, const char *name, lt_param_kind kind, lt_shape shape,
                     bool by_rows)
{
    char text[LT_SHAPE_TEXT];
    lt_param *p, **slot;
    const char *full;

    if (set->status)
        return &set->stand_in;
    full = lt_arena_printf(set->arena, "%s%s%s", prefix, *prefix ? "." : "", name);
    p = lt_arena_alloc(set->arena, sizeof(*p));
    if (!full || !p || !grow(set))
        return refuse(set, lt_error(LT_ENOMEM, "%s.%s: no memory for the parameter", prefix, name));
    slot = slot_of(set, full);
    if (*slot)
        return refuse(set, lt_error(LT_EINVAL, "parameter \"%s\" is registered twice", full));
    if (!lt_shape_fits_memory(&shape))
        return refuse(set, lt_error(LT_ESHAPE, "parameter \"%s\" is %s, which no memory holds", full,
                                    lt_shape_text(&shape, text)));
    if (lt_shape_numel(&shape) == 0)
        return refuse(set, lt_error(LT_ESHAPE, "parameter \"%s\" is %s, want at least one value", full,
                                    lt_shape_text(&shape, text)));
    if (by_rows && shape.rank == 0)
        return refuse(set, lt_error(LT_ESHAPE, "parameter \"%s\" is a number, want rows", full));
    *p = (lt_param){ .name = full, .shape = shape, .kind = kind, .rate = 1, .momentum = 0.1, .set = set };
    if ((by_rows && lt_rows_init(p)) || (!set->deferred && !allocate(set, p)))
        return refuse(set, LT_ENOMEM);
    *slot = p;
    *set->tail = p;
    set->tail = &p->next;
    set->n++;
    return p;
}

lt_param *lt_params_add(lt_params *set, const char *prefix, const char *name, lt_param_kind kind,
                        lt_shape shape)
{
    return add(set, prefix, name, kind, shape, false);
}

lt_param *lt_params_add_rows(lt_params *set, const char *prefix, const char *name, lt_shape shape)
{
    return add(set, prefix, name, LT_WEIGHT, shape, true);
}

const char *lt_name(lt_params *set, const char *fmt, ...)
{
    const char *name;
    va_list args;

    va_start(args, fmt);
    name = lt_arena_vprintf(set->arena, fmt, args);
    va_end(args);
    if (!name)
        refuse(set, lt_error(LT_ENOMEM, "no memory for the name of a parameter"));
    return name ? name : "";
}

lt_status lt_params_status(const lt_params *set)
{
    return set->status ? lt_error(set->status, "%s", set->error) : LT_OK;
}

lt_arena *lt_params_arena(lt_params *set)
{
    return set->arena;
}

lt_param *lt_params_first(const lt_params *set)
{
    return set->first;
}

lt_param *lt_params_find(const lt_params *set, const char *name)
{
    return set->n_buckets ? *slot_of(set, name) : NULL;
}

int64_t lt_params_count(const lt_params *set, lt_param_kind kind, const char *prefix)
{
    int64_t n = 0;

    for (const lt_param *p = set->first; p; p = p->next)
        if (p->kind == kind && strncmp(p->name, prefix, strlen(prefix)) == 0)
            n += lt_param_numel(p);
    return n;
}

void lt_params_changed(lt_params *set)
{
    set->version++;
}

uint64_t lt_params_version(const lt_params *set)
{
    return set->version;
}

void lt_params_moved(lt_params *set)
{
    set->moves++;
}

uint64_t lt_params_moves(const lt_params *set)
{
    return set->moves;
}

void lt_params_collect(lt_params *set, bool replaced)
{
    set->batches = replaced ? 1 : set->batches + 1;
    set->collected = true;
}

bool lt_params_take_batches(lt_params *set, int *n)
{
    const bool collected = set->collected;

    *n = set->batches;
    set->batches = 0;
    set->collected = false;
    return collected;
}

void lt_params_zero_grad(lt_params *set)
{
    set->batches = 0;
    for (lt_param *p = set->first; p; p = p->next)
        if (p->rows)
            lt_rows_clear(p, p->grad);
        else if (p->grad)
            memset(p->grad, 0, (size_t)lt_param_numel(p) * sizeof(lt_real));
}

bool lt_param_need_grad(lt_param *p)
{
    if (p->rows)
        return lt_rows_need_grad(p);
    if (!p->grad)
        p->grad = lt_arena_array(p->set->arena, (size_t)lt_param_numel(p), sizeof(lt_real));
    return p->grad != NULL;
}
