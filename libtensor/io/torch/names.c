/* SPDX-License-Identifier: Apache-2.0 */
/*
 * All tensors in what was saved, and what each is called: the keys on the way to it with dots between, and of a pickled
 * module as state_dict() would call it. Which of them are the weights that somebody wants, he knows.
 */
#include "libtensor/io/torch/internal.h"

#include <stdio.h>
#include <string.h>

/* Values may be shared, so a small file can ask for a walk without end: steps bounds it. An item that is looked at is
 * one, a named value is 16. */
enum { NESTING_MAX = LT_PICKLE_DEPTH, NAMES_MAX = 1 << 20, NAME_STEPS = 16 };

typedef struct {
    lt_torch *t;
    lt_named_array *entry;
    size_t *within;
    lt_refused_array *refused;
    size_t n, room, n_refused, refused_room, steps;
    lt_status status;
} listing;

/* Where in the saved value we are: the name so far, and how much of it leads to the dict or the whole module that we
 * are in. */
typedef struct {
    const char *name;
    size_t within;
    bool in_module;
    int depth;
} place;

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

/* TorchScript's modules have parameters, buffers and parts side by side. */
static bool is_script(const lt_pvalue *v)
{
    return v->kind == LT_POBJECT && strncmp(v->u.object.class_name, "__torch__.", 10) == 0;
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

/* ---- the lists ------------------------------------------------------------------------------------ */

/* list with room for one more than n, perhaps elsewhere; NULL, and the status, without memory */
static void *grow(listing *l, void *list, size_t n, size_t room, size_t size)
{
    uint8_t *grown = list;

    if (n == room)
        l->status = lt_torch_alloc(l->t, (room ? 2 * room : 64) * size, &grown);
    if (l->status)
        return NULL;
    if (grown != list && n)
        memcpy(grown, list, n * size);
    return grown;
}

static void add(listing *l, const place *at, const lt_array *array)
{
    l->entry = grow(l, l->entry, l->n, l->room, sizeof(*l->entry));
    if (!l->status)
        l->within = grow(l, l->within, l->n, l->room, sizeof(*l->within));
    if (l->status)
        return;
    if (l->n == l->room)
        l->room = l->room ? 2 * l->room : 64;
    l->within[l->n] = at->within;
    l->entry[l->n++] = (lt_named_array){ at->name, *array };
}

static void add_refused(listing *l, const char *name, const char *reason)
{
    l->refused = grow(l, l->refused, l->n_refused, l->refused_room, sizeof(*l->refused));
    if (l->status)
        return;
    if (l->n_refused == l->refused_room)
        l->refused_room = l->refused_room ? 2 * l->refused_room : 64;
    l->refused[l->n_refused++] = (lt_refused_array){ .name = name, .reason = reason };
}

/* maker: what would make a tensor of it, "sparse_tensor", "qtensor" */
static void add_closed(listing *l, const char *name, const char *maker)
{
    static const char text[] = "a tensor of a kind that is not read: ";
    uint8_t *reason;

    l->status = lt_torch_alloc(l->t, sizeof(text) + strlen(maker), &reason);
    if (l->status)
        return;
    sprintf((char *)reason, "%s%s", text, maker);
    add_refused(l, name, (const char *)reason);
}

/* ---- the walk --------------------------------------------------------------------------------------- */

/* The name at a place and key with a dot between; NULL where the key is none, or without memory */
static const char *join(listing *l, const place *at, const lt_pvalue *key)
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
    l->status = lt_torch_alloc(l->t, strlen(at->name) + strlen(text) + 2, &out);
    if (l->status)
        return NULL;
    sprintf((char *)out, "%s%s%s", at->name, *at->name ? "." : "", text);
    return (const char *)out;
}

static void walk(listing *l, const lt_pvalue *v, const place *at);

static bool is_leaf(const lt_pvalue *v)
{
    return v->kind != LT_PARRAY && v->kind != LT_PDICT && v->kind != LT_POBJECT && v->kind != LT_PLIST &&
           v->kind != LT_PTUPLE && v->kind != LT_POWN;
}

/* at: the dict's place; skip: names of arrays that are left out, or NULL */
static void walk_dict(listing *l, const lt_pvalue *d, const lt_pvalue *skip, const place *at)
{
    for (size_t i = 0; d && d->kind == LT_PDICT && i < d->n && spend(l, 1); i++) {
        const lt_pvalue *key = d->u.item[2 * i], *v = d->u.item[2 * i + 1];
        place inner = *at;

        if (is_leaf(v))
            continue;
        inner.name = join(l, at, key);
        inner.depth++;
        if (inner.name && !(v->kind == LT_PARRAY && lt_pstr(key) && is_named(l, skip, lt_pstr(key))))
            walk(l, v, &inner);
    }
}

static void walk_list(listing *l, const lt_pvalue *list, const place *at)
{
    for (size_t i = 0; i < list->n && spend(l, 1); i++) {
        const lt_pvalue index = { .kind = LT_PINT, .u.integer = (int64_t)i };
        place inner = *at;

        if (is_leaf(list->u.item[i]))
            continue;
        inner.name = join(l, at, &index);
        inner.depth++;
        if (inner.name)
            walk(l, list->u.item[i], &inner);
    }
}

static void walk_module(listing *l, const lt_pvalue *v, const place *at)
{
    walk_dict(l, state_of(v, "_parameters"), NULL, at);
    walk_dict(l, state_of(v, "_buffers"), state_of(v, "_non_persistent_buffers_set"), at);
    walk_dict(l, state_of(v, "_modules"), NULL, at);
}

/* An object that is no module may hold some: what was put into it as into a dict, and its attributes. */
static void walk_object(listing *l, const lt_pvalue *v, const place *at)
{
    const char *name = v->u.object.class_name;

    if (strncmp(name, lt_torch_makers, strlen(lt_torch_makers)) == 0) {
        add_closed(l, at->name, name + strlen(lt_torch_makers));
        return;
    }
    if (v->items && v->items->kind == LT_PDICT)
        walk_dict(l, v->items, NULL, at);
    else if (v->items && v->items->kind == LT_PLIST)
        walk_list(l, v->items, at);
    walk_dict(l, v->u.object.state, NULL, at);
}

static void walk_container(listing *l, const lt_pvalue *v, const place *at)
{
    const bool script = is_script(v), module = script || is_module(l, v);
    place inner = *at;

    if (!module || !at->in_module)
        inner.within = *at->name ? strlen(at->name) + 1 : 0;
    inner.in_module = module;
    if (script)
        walk_dict(l, v->u.object.state, NULL, &inner);
    else if (module)
        walk_module(l, v, &inner);
    else if (v->kind == LT_POBJECT)
        walk_object(l, v, &inner);
    else if (v->kind == LT_PDICT)
        walk_dict(l, v, NULL, &inner);
    else
        walk_list(l, v, &inner);
}

/* The depth is bounded by the pickle's own: every level here is one of its. */
static void walk(listing *l, const lt_pvalue *v, const place *at)
{
    if (!spend(l, NAME_STEPS))
        return;
    if (at->depth > NESTING_MAX) {
        l->status = lt_error(LT_EFORMAT, "%s: nested more than %d deep", l->t->path, NESTING_MAX);
    } else if (v->kind == LT_PARRAY) {
        if (v->u.array->type != LT_ELEM_TEXT)
            add(l, at, v->u.array);
    } else if (v->kind == LT_POWN) {
        if (v->u.text == lt_torch_unread)
            add_refused(l, at->name, v->own);
    } else if (!is_leaf(v)) {
        walk_container(l, v, at);
    }
}

lt_status lt_torch_names(lt_torch *t, const lt_pvalue *value, lt_torch_file *out)
{
    listing l = { .t = t };

    walk(&l, value, &(place){ .name = "" });
    out->entry = l.entry;
    out->within = l.within;
    out->n = l.n;
    out->refused = l.refused;
    out->n_refused = l.n_refused;
    return l.status;
}
