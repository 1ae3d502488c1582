/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A last look over a pickle's value, so that its readers may trust it: no value inside itself, none
 * deeper than LT_PICKLE_DEPTH, no array without elements. Within an object, which stays closed and may be anything,
 * whatever is so is cut off. Every value is visited once, however often it is shared.
 */
#include "libtensor/io/pickle/machine.h"

_Static_assert(LT_PICKLE_DEPTH == 64, "what an error line says");

enum { UNSEEN, ON_PATH, HEIGHT_0 };     /* lt_pvalue.mark; from HEIGHT_0 on, mark - HEIGHT_0 is the height */

typedef struct {
    lt_pvalue *value;
    size_t next;                        /* the child to look at */
    uint32_t height;                    /* of the children seen so far, plus one */
    bool closed;                        /* an object, or within one */
} frame;

static size_t n_children(const lt_pvalue *v)
{
    switch (v->kind) {
    case LT_PLIST: case LT_PTUPLE: case LT_PSET: return v->n;
    case LT_PDICT:   return 2 * v->n;
    case LT_POBJECT: return v->u.object.state || v->items ? 2 : 0;
    default:         return 0;
    }
}

/* Where a value refers to its child; of an object either may be NULL. */
static lt_pvalue **child(lt_pvalue *v, size_t i)
{
    if (v->kind != LT_POBJECT)
        return &v->u.item[i];
    return i == 0 ? &v->u.object.state : &v->items;
}

/* NULL, or why a value cannot be looked at from here, where depth values are above it. */
static const char *refuse(const lt_pvalue *v, size_t depth)
{
    const bool seen = n_children(v) > 0 && v->mark >= HEIGHT_0;

    if (v->kind == LT_PARRAY && !v->u.array)
        return "an array was never given its elements";
    if (n_children(v) > 0 && v->mark == ON_PATH)
        return "a value contains itself";
    if (depth + (seen ? v->mark - HEIGHT_0 : 0) >= LT_PICKLE_DEPTH)
        return "values nested deeper than 64";
    return NULL;
}

/* Enter the value at *from: a leaf is done at once, a seen one has a height, a new one gets a frame. */
static void enter(lt_pmachine *m, frame *path, size_t *depth, lt_pvalue **from)
{
    lt_pvalue *v = *from;
    const char *wrong = refuse(v, *depth);
    frame *top = *depth ? &path[*depth - 1] : NULL;
    uint32_t height;

    if (wrong && top && top->closed) {
        *from = top->value->kind == LT_POBJECT ? NULL : m->none;
        return;
    }
    if (wrong) {
        lt_pm_fail(m, "%s", wrong);
        return;
    }
    height = n_children(v) > 0 && v->mark >= HEIGHT_0 ? v->mark - HEIGHT_0 : 0;
    if (n_children(v) > 0 && v->mark == UNSEEN) {
        v->mark = ON_PATH;
        path[(*depth)++] = (frame){ v, 0, 1, v->kind == LT_POBJECT || (top && top->closed) };
    } else if (top && top->height < height + 1) {
        top->height = height + 1;
    }
}

/* Leave a value whose children are all done: its parent is at least one higher. */
static void leave(frame *path, size_t *depth)
{
    const frame done = path[--*depth];

    done.value->mark = HEIGHT_0 + done.height;
    if (*depth && path[*depth - 1].height < done.height + 1)
        path[*depth - 1].height = done.height + 1;
}

void lt_pm_check(lt_pmachine *m)
{
    frame path[LT_PICKLE_DEPTH];
    size_t depth = 0;

    enter(m, path, &depth, &m->result);
    while (depth && !m->status) {
        frame *top = &path[depth - 1];
        lt_pvalue **next = top->next < n_children(top->value) ? child(top->value, top->next++) : NULL;

        if (!next)
            leave(path, &depth);
        else if (*next)
            enter(m, path, &depth, next);
    }
}
