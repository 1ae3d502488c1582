/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A last look over a pickle's value, so that its readers may trust it: no value inside itself, none
 * deeper than LT_PICKLE_DEPTH, no array without elements. Every value is visited once, however often
 * it is shared.
 */
#include "libtensor/io/pickle/machine.h"

enum { UNSEEN, ON_PATH, HEIGHT_0 };     /* lt_pvalue.mark; from HEIGHT_0 on, mark - HEIGHT_0 is the height */

typedef struct {
    lt_pvalue *value;
    size_t next;                        /* the child to look at */
    uint32_t height;                    /* of the children seen so far, plus one */
} frame;

static size_t n_children(const lt_pvalue *v)
{
    switch (v->kind) {
    case LT_PLIST: case LT_PTUPLE: case LT_PSET: return v->n;
    case LT_PDICT:   return 2 * v->n;
    case LT_POBJECT: return v->u.object.state != NULL;
    default:         return 0;
    }
}

static lt_pvalue *child(const lt_pvalue *v, size_t i)
{
    return v->kind == LT_POBJECT ? v->u.object.state : v->u.item[i];
}

/* Enter a child: a leaf is done at once, a seen one has a height, a new one gets a frame. */
static void enter(lt_pmachine *m, frame *path, size_t *depth, lt_pvalue *v)
{
    uint32_t height = 0;

    if (v->kind == LT_PARRAY && !v->u.array)
        lt_pm_fail(m, "an array was never given its elements");
    if (n_children(v) > 0) {
        if (v->mark == ON_PATH)
            lt_pm_fail(m, "a value contains itself");
        height = v->mark >= HEIGHT_0 ? v->mark - HEIGHT_0 : 0;
    }
    if (*depth + height >= LT_PICKLE_DEPTH)
        lt_pm_fail(m, "values nested deeper than %d", LT_PICKLE_DEPTH);
    if (m->status)
        return;
    if (n_children(v) > 0 && v->mark == UNSEEN) {
        v->mark = ON_PATH;
        path[(*depth)++] = (frame){ v, 0, 1 };
    } else if (*depth && path[*depth - 1].height < height + 1) {
        path[*depth - 1].height = height + 1;
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

    enter(m, path, &depth, m->result);
    while (depth && !m->status) {
        frame *top = &path[depth - 1];

        if (top->next < n_children(top->value))
            enter(m, path, &depth, child(top->value, top->next++));
        else
            leave(path, &depth);
    }
}
