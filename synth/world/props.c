/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/world/props.h"

#include "libtensor/base/parallel.h"

#include <stdio.h>

typedef struct {
    synth_props *props;
    const int *number;
    lt_outcome outcome[YCB_COUNT];
} job;

static void make(void *ctx, int64_t i)
{
    job *j = ctx;
    const int number = j->number[i];
    synth_prop_pair *p = &j->props->pair[number - 1];
    lt_arena *arena = j->props->arena[number - 1];
    lt_status st = synth_prop_new_bare(arena, number, &p->right);

    if (!st)
        st = synth_prop_mirror(arena, &p->right, &p->left);
    lt_outcome_keep(&j->outcome[i], st);
}

lt_status synth_props_init_some(synth_props *p, const int *number, int n)
{
    job j = { .props = p, .number = number };
    lt_status st = LT_OK;

    *p = (synth_props){ .arena = { NULL } };
    for (int i = 0; i < n; i++)
        if (!(p->arena[number[i] - 1] = lt_arena_new()))
            return lt_error(LT_ENOMEM, "synth: no memory for objects");
    lt_parallel_for(n, make, &j);
    for (int i = 0; i < n && !st; i++)
        st = lt_outcome_tell(&j.outcome[i]);
    return st;
}

lt_status synth_props_init(synth_props *p)
{
    int all[YCB_COUNT];

    for (int i = 0; i < YCB_COUNT; i++)
        all[i] = i + 1;
    return synth_props_init_some(p, all, YCB_COUNT);
}

void synth_props_fini(synth_props *p)
{
    for (int i = 0; i < YCB_COUNT; i++)
        lt_arena_free(p->arena[i]);
}
