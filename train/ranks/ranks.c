/* SPDX-License-Identifier: Apache-2.0 */
#include "train/ranks/ranks.h"

#include <string.h>

void ranks_own(const train_ranks *r, int n, int *first, int *end)
{
    const int rank = r ? r->rank : 0, size = r ? r->size : 1;

    *first = (int)((int64_t)rank * n / size);
    *end = (int)(((int64_t)rank + 1) * n / size);
}

lt_status ranks_tell(const train_ranks *r, void *data, size_t bytes)
{
    lt_status st = LT_OK;

    if (r && r->rank)
        return r->receive(r->ctx, 0, data, bytes);
    for (int to = 1; r && to < r->size && st == LT_OK; to++)
        st = r->send(r->ctx, to, data, bytes);
    return st;
}

lt_status ranks_share(const train_ranks *r, const void *mine, size_t bytes, void *all)
{
    lt_status st = LT_OK;

    if (ranks_lead(r))
        memcpy(all, mine, bytes);
    else
        st = r->send(r->ctx, 0, mine, bytes);
    for (int from = 1; r && !r->rank && from < r->size && st == LT_OK; from++)
        st = r->receive(r->ctx, from, (char *)all + (size_t)from * bytes, bytes);
    return st || !r ? st : ranks_tell(r, all, bytes * (size_t)r->size);
}

lt_status ranks_most(const train_ranks *r, int *x)
{
    int all[TRAIN_RANKS_MAX];
    const lt_status st = ranks_share(r, x, sizeof(*x), all);

    for (int i = 0; r && st == LT_OK && i < r->size; i++)
        *x = all[i] > *x ? all[i] : *x;
    return st;
}

lt_status ranks_add(const train_ranks *r, double *x)
{
    double all[TRAIN_RANKS_MAX];
    const lt_status st = ranks_share(r, x, sizeof(*x), all);

    *x = 0;
    for (int i = 0; st == LT_OK && i < (r ? r->size : 1); i++)
        *x += all[i];
    return st;
}
