/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where the weights are in what was saved, and what they are called: as state_dict() would call them.
 */
#include "libtensor/io/torch/internal.h"

#include <stdio.h>
#include <string.h>

/* Values may be shared, so a small file can ask for a walk without end: steps bounds it. An item of a dict that is
 * looked at is one, a named value is 16. */
enum { NESTING_MAX = LT_PICKLE_DEPTH, NAMES_MAX = 1 << 20, NAME_STEPS = 16 };

typedef struct {
    lt_torch *t;
    lt_named_array *entry;
    size_t n, room, steps;
    lt_status status;
} listing;

/* Training programs wrap the weights under one of these, some twice; the first that holds any is taken. */
static const char *const wrappers[] = {
    "state_dict", "model_state_dict", "model", "network", "net", "ema", "teacher", "student", "params",
};

static bool spend(listing *l, size_t steps)
{
    l->steps += steps;
    if (!l->status && l->steps > (size_t)NAMES_MAX * NAME_STEPS)
        l->status = lt_error(LT_EFORMAT, "%s: more than %d named values, or than %d values to look through for them",
                             l->t->path, NAMES_MAX, NAMES_MAX * NAME_STEPS);
    return !l->status;
}

static const lt_pvalue *state_of(const lt_pvalue *v, const char *key)
{
    return v->kind == LT_POBJECT && v->u.object.state ? lt_pdict_get(v->u.object.state, key) : NULL;
}

static bool is_module(listing *l, const lt_pvalue *v)
{
    if (v->kind != LT_POBJECT || !v->u.object.state || !spend(l, v->u.object.state->n))
        return false;
    return state_of(v, "_parameters") || state_of(v, "_modules");
}

static bool is_named(listing *l, const lt_pvalue *set, const char *name)
{
    const size_t n = strlen(name);

    if (!set || set->kind != LT_PSET || !spend(l, set->n * (1 + n / 64)))
        return false;
    for (size_t i = 0; i < set->n; i++) {
        const lt_pvalue *text = set->u.item[i];

        if (text->kind == LT_PSTR && text->n == n && memcmp(text->u.text, name, n) == 0)
            return true;
    }
    return false;
}

/* prefix and key with a dot between; NULL, and the status, when there is no memory for it */
static const char *join(listing *l, const char *prefix, const lt_pvalue *key)
{
    const char *text = lt_pstr(key);
    char number[32];
    uint8_t *out;
    int64_t x;

    if (!text && lt_pint(key, &x)) {
        snprintf(number, sizeof(number), "%jd", (intmax_t)x);
        text = number;
    }
    if (!text)
        return NULL;
    l->status = lt_torch_alloc(l->t, strlen(prefix) + strlen(text) + 2, &out);
    if (l->status)
        return NULL;
    sprintf((char *)out, "%s%s%s", prefix, *prefix ? "." : "", text);
    return (const char *)out;
}

static void add(listing *l, const char *name, const lt_array *array)
{
    if (l->n == l->room) {
        const size_t room = l->room ? 2 * l->room : 64;
        uint8_t *grown;

        l->status = lt_torch_alloc(l->t, room * sizeof(*l->entry), &grown);
        if (l->status)
            return;
        if (l->n)
            memcpy(grown, l->entry, l->n * sizeof(*l->entry));
        l->entry = (lt_named_array *)(void *)grown;
        l->room = room;
    }
    l->entry[l->n++] = (lt_named_array){ name, *array };
}

static void walk(listing *l, const lt_pvalue *v, const char *prefix, int depth);

static void walk_dict(listing *l, const lt_pvalue *d, const lt_pvalue *skip, const char *prefix, int depth)
{
    for (size_t i = 0; d && d->kind == LT_PDICT && i < d->n && spend(l, 1); i++) {
        const lt_pvalue *key = d->u.item[2 * i], *v = d->u.item[2 * i + 1];
        const char *name;

        if (v->kind != LT_PARRAY && v->kind != LT_PDICT && v->kind != LT_POBJECT)
            continue;
        name = join(l, prefix, key);
        if (name && !(v->kind == LT_PARRAY && lt_pstr(key) && is_named(l, skip, lt_pstr(key))))
            walk(l, v, name, depth + 1);
    }
}

/* The depth is bounded by the pickle's own: every level here is one of its. */
static void walk(listing *l, const lt_pvalue *v, const char *prefix, int depth)
{
    if (!spend(l, NAME_STEPS))
        return;
    if (depth > NESTING_MAX) {
        l->status = lt_error(LT_EFORMAT, "%s: nested more than %d deep", l->t->path, NESTING_MAX);
    } else if (v->kind == LT_PARRAY) {
        if (v->u.array->type != LT_ELEM_TEXT)
            add(l, prefix, v->u.array);
    } else if (is_module(l, v)) {
        walk_dict(l, state_of(v, "_parameters"), NULL, prefix, depth);
        walk_dict(l, state_of(v, "_buffers"), state_of(v, "_non_persistent_buffers_set"), prefix, depth);
        walk_dict(l, state_of(v, "_modules"), NULL, prefix, depth);
    } else {
        walk_dict(l, v, NULL, prefix, depth);
    }
}

static bool holds_arrays(listing *l, const lt_pvalue *v)
{
    if (!v || is_module(l, v))
        return v != NULL;
    for (size_t i = 0; v->kind == LT_PDICT && i < v->n && spend(l, 1); i++) {
        const lt_pvalue *item = v->u.item[2 * i + 1];

        if (item->kind == LT_PARRAY || item->kind == LT_PDICT || is_module(l, item))
            return true;
    }
    return false;
}

static const lt_pvalue *unwrap(listing *l, const lt_pvalue *v)
{
    for (int depth = 0; depth < 4 && v->kind == LT_PDICT; depth++) {
        const lt_pvalue *inner = NULL;

        for (size_t i = 0; i < LT_COUNT(wrappers) && !holds_arrays(l, inner); i++)
            inner = lt_pdict_get(v, wrappers[i]);
        if (!holds_arrays(l, inner))
            break;
        v = inner;
    }
    return v;
}

lt_status lt_torch_names(lt_torch *t, const lt_pvalue *value, lt_torch_file *out)
{
    listing l = { .t = t };

    walk(&l, unwrap(&l, value), "", 0);
    out->entry = l.entry;
    out->n = l.n;
    return l.status;
}
