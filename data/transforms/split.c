/* SPDX-License-Identifier: Apache-2.0 */
#include "data/transforms/internal.h"

#include <stdlib.h>
#include <string.h>

static bool lists(const cJSON *names, const char *name)
{
    const cJSON *x;

    cJSON_ArrayForEach(x, names) {
        if (cJSON_IsString(x) && strcmp(x->valuestring, name) == 0)
            return true;
    }
    return false;
}

static int by_name(const void *a, const void *b)
{
    const transforms_view *const *x = a, *const *y = b;

    return strcmp((*x)->name, (*y)->name);
}

static lt_status every(int holdout, transforms_set *s)
{
    transforms_view **sorted = lt_alloc((size_t)s->n * sizeof(*sorted));

    if (!sorted)
        return lt_error(LT_ENOMEM, "%s: no memory for %d views", s->path, s->n);
    for (int i = 0; i < s->n; i++)
        sorted[i] = &s->view[i];
    qsort(sorted, (size_t)s->n, sizeof(*sorted), by_name);
    for (int i = 0; i < s->n; i += holdout)
        sorted[i]->held_out = true;
    lt_release(sorted);
    return LT_OK;
}

lt_status transforms_hold_out(const cJSON *file, int holdout, transforms_set *s)
{
    const cJSON *val = cJSON_GetObjectItemCaseSensitive(file, "val_filenames");
    const cJSON *test = cJSON_GetObjectItemCaseSensitive(file, "test_filenames");

    if (!val && !test)
        return every(holdout, s);
    for (int i = 0; i < s->n; i++)
        s->view[i].held_out = lists(val, s->view[i].name) || lists(test, s->view[i].name);
    return LT_OK;
}
