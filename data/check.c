/* SPDX-License-Identifier: Apache-2.0 */
/* Files that are there, samples that can be read. */
#include "data/check.h"

#include "libtensor/base/parallel.h"

#include <stdlib.h>
#include <string.h>

enum { BLOCK = 1024 };

/* ---- files ---- */

typedef struct {
    const dataset *d;
    int64_t *first, *missing;       /* of each block of samples: number of the first that lacks a file; how many */
} file_job;

static void look_for_block(void *ctx, int64_t block)
{
    const file_job *j = ctx;
    const int64_t end = lt_min_i64(j->d->count, (block + 1) * BLOCK);
    lt_arena *arena = lt_arena_new();

    j->first[block] = -1;
    for (int64_t i = block * BLOCK; arena && i < end; i++) {
        if (!j->d->ops->missing(j->d, i, arena))
            continue;
        if (j->first[block] < 0)
            j->first[block] = i;
        j->missing[block]++;
    }
    lt_arena_free(arena);
}

lt_status check_files(const dataset *d, lt_arena *arena, check_missing *out)
{
    const int64_t n = lt_ceil_div(d->count, BLOCK);
    file_job j = { d, lt_arena_array(arena, (size_t)n, sizeof(*j.first)),
                   lt_arena_array(arena, (size_t)n, sizeof(*j.missing)) };

    if (!j.first || !j.missing)
        return lt_error(LT_ENOMEM, "%s: no memory", d->root);
    lt_parallel_for(n, look_for_block, &j);
    *out = (check_missing){ 0 };
    for (int64_t i = 0; i < n; i++) {
        if (j.first[i] >= 0 && !out->first)
            out->first = d->ops->missing(d, j.first[i], arena);
        out->samples += j.missing[i];
    }
    return LT_OK;
}

/* ---- samples ---- */

typedef struct {
    const dataset *d;
    int64_t n;
    char **line;                    /* (n) NULL where all is well */
} read_job;

static void read_one(void *ctx, int64_t i)
{
    const read_job *j = ctx;
    lt_arena *arena = lt_arena_new();
    dataset_sample s;

    if (!arena || dataset_read(j->d, i * j->d->count / j->n, SAMPLE_OBJECT | SAMPLE_DEPTH, arena, &s))
        j->line[i] = strdup(lt_last_error());
    lt_arena_free(arena);
}

static lt_status collect(const read_job *j, lt_arena *arena, check_samples *out)
{
    lt_status st = LT_OK;

    *out = (check_samples){ .read = j->n };
    for (int64_t i = 0; i < j->n; i++) {
        if (!j->line[i])
            continue;
        out->bad++;
        if (out->n_lines < CHECK_LINES && !(out->line[out->n_lines++] = lt_arena_strdup(arena, j->line[i])))
            st = lt_error(LT_ENOMEM, "%s: no memory", j->d->root);
        free(j->line[i]);
    }
    return st;
}

lt_status check_read(const dataset *d, int64_t n, lt_arena *arena, check_samples *out)
{
    read_job j = { .d = d, .n = n && n < d->count ? n : d->count };
    lt_status st;

    j.line = calloc((size_t)j.n, sizeof(*j.line));
    if (!j.line)
        return lt_error(LT_ENOMEM, "%s: no memory", d->root);
    lt_parallel_for(j.n, read_one, &j);
    st = collect(&j, arena, out);
    free(j.line);
    return st;
}
