/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/results/hold.h"

#include "data/kind.h"

#include <string.h>

bool hogs_same_sequence(const char *a, const char *b)
{
    const char *x = strrchr(a, '/'), *y = strrchr(b, '/');

    return x && y && x - a == y - b && strncmp(a, b, (size_t)(x - a)) == 0;
}

/* The number of each frame's sequence, those in order of their first frames */
static lt_status number_sequences(hogs_evaluation *e)
{
    const hogs_source *s = &e->run.check_source;
    const char **first = lt_arena_array(e->arena, (size_t)s->count, sizeof(*first));

    e->sequence = lt_arena_array(e->arena, (size_t)s->count, sizeof(*e->sequence));
    if (!first || !e->sequence)
        return lt_error(LT_ENOMEM, "no memory for %lld frames", (long long)s->count);
    for (int64_t i = 0; i < s->count; i++) {
        const char *name = dataset_name(s->data, s->index[i]);
        int k = 0;

        while (k < e->sequences && !hogs_same_sequence(name, first[k]))
            k++;
        if (k == e->sequences)
            first[e->sequences++] = name;
        e->sequence[i] = k;
    }
    e->by_sequence = lt_arena_array(e->arena, (size_t)e->sequences, sizeof(*e->by_sequence));
    e->begun = lt_arena_array(e->arena, (size_t)e->sequences, sizeof(*e->begun));
    if (!e->by_sequence || !e->begun)
        return lt_error(LT_ENOMEM, "no memory for %d sequences", e->sequences);
    return LT_OK;
}

/* HOLD's protocol is HO3D's: of each sequence the first frame, and so many in all, spread over it. */
lt_status hogs_hold_choose(hogs_evaluation *e)
{
    const hogs_source *s = &e->run.check_source;
    const int wanted = e->o->meshes;
    int64_t *all, *before;
    lt_status st = LT_OK;

    if (!wanted || strcmp(s->data->kind->title, "HO3D") != 0)
        return LT_OK;
    st = number_sequences(e);
    e->held = lt_arena_array(e->arena, (size_t)s->count, sizeof(*e->held));
    all = lt_arena_array(e->arena, 2 * (size_t)e->sequences, sizeof(*all));
    if (st || !e->held || !all)
        return st ? st : lt_error(LT_ENOMEM, "no memory for %lld frames", (long long)s->count);
    before = all + e->sequences;
    for (int64_t i = 0; i < s->count; i++)
        all[e->sequence[i]]++;
    for (int64_t i = 0; i < s->count; i++) {
        const int64_t n = all[e->sequence[i]], k = before[e->sequence[i]]++;

        e->held[i] = n <= wanted || k == 0 || k * wanted / n != (k - 1) * wanted / n;
    }
    return LT_OK;
}

void hogs_hold_average(hogs_evaluation *e)
{
    static const hogs_score of[] = { HOGS_CD_O_VERTICES, HOGS_F_O_10_PERCENT, HOGS_CD_POSE };
    hogs_means *all = &e->means[HOGS_ROW_MODEL];

    for (size_t k = 0; k < LT_COUNT(of) && e->held; k++) {
        all->sum[of[k]] = 0;
        all->n[of[k]] = 0;
        for (int i = 0; i < e->sequences; i++)
            if (e->by_sequence[i].n[of[k]]) {
                all->sum[of[k]] += hogs_means_of(&e->by_sequence[i], of[k]);
                all->n[of[k]]++;
            }
    }
}
