/* SPDX-License-Identifier: Apache-2.0 */
#include "models/detect/counts.h"

#include <math.h>

/* saved[0] holds what this part counted, and behind it the whole batch's. */
enum { OWN, ALL, KEPT };

void counts_plan(lt_call *c, int64_t images, int doubles)
{
    if (c->train)
        c->saved_bytes[0] = KEPT * sizeof(counts);
    c->work_bytes = (size_t)lt_max_i64(1, images * doubles) * sizeof(double);
}

static counts count(const lt_call *c, int objects, int assigned_input)
{
    const lt_tensor *assigned = c->in[assigned_input];
    counts n = { 0, 0 };

    for (int64_t b = 0; b < lt_dim(assigned, 0); b++)
        for (int64_t i = 0; i < lt_dim(assigned, 1); i++) {
            const lt_real *t = assigned_at(assigned, b, i);

            if (t[ASSIGNED_OBJECT] < 0)
                continue;
            n.scores += (double)t[ASSIGNED_SCORE];
            n.masks += object_at(c->in[objects], b, (int64_t)t[ASSIGNED_OBJECT])[OBJECT_HAS_MASK] > 0;
        }
    return n;
}

void counts_share(const lt_call *c, int objects, int assigned)
{
    ((counts *)c->saved[0])[OWN] = count(c, objects, assigned);
}

counts counts_of(const lt_call *c, int objects, int assigned)
{
    counts all = { 0, 0 };

    if (!c->part)
        all = count(c, objects, assigned);
    for (int k = 0; c->part && k < c->n_parts; k++) {
        const counts *own = c->part[k]->saved[0];

        all.scores += own[OWN].scores;
        all.masks += own[OWN].masks;
    }
    all = (counts){ fmax(1, all.scores), fmax(1, all.masks) };
    if (c->train)
        ((counts *)c->saved[0])[ALL] = all;
    return all;
}

counts counts_saved(const lt_call *c)
{
    return ((const counts *)c->saved[0])[ALL];
}

double counts_parts(const lt_call *c)
{
    return c->part ? c->n_parts : 1;
}
