/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/world/props.h"

#include "libtensor/base/parallel.h"

#include <stdio.h>

typedef struct {
    synth_props *props;
    lt_status status[YCB_COUNT];
    char line[YCB_COUNT][256];
} job;

static void make(void *ctx, int64_t i)
{
    job *j = ctx;
    synth_prop_pair *p = &j->props->pair[i];
    lt_arena *arena = j->props->arena[i];
    lt_status st = synth_prop_new_bare(arena, (int)i + 1, &p->right);

    if (!st)
        st = synth_prop_mirror(arena, &p->right, &p->left);
    j->status[i] = st;
    if (st)
        snprintf(j->line[i], sizeof(j->line[i]), "%s", lt_last_error());
}

lt_status synth_props_init(synth_props *p)
{
    job j = { .props = p };

    *p = (synth_props){ .arena = { NULL } };
    for (int i = 0; i < YCB_COUNT; i++)
        if (!(p->arena[i] = lt_arena_new()))
            return lt_error(LT_ENOMEM, "synth: no memory for objects");
    lt_parallel_for(YCB_COUNT, make, &j);
    for (int i = 0; i < YCB_COUNT; i++)
        if (j.status[i])
            return lt_error(j.status[i], "%s", j.line[i]);
    return LT_OK;
}

void synth_props_fini(synth_props *p)
{
    for (int i = 0; i < YCB_COUNT; i++)
        lt_arena_free(p->arena[i]);
}
