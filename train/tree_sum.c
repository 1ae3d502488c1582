/* SPDX-License-Identifier: Apache-2.0 */
#include "train/tree_sum.h"

#include "libtensor/base/parallel.h"

#include <string.h>

enum { MAX_LEVELS = 16 };

typedef struct {
    lt_real *grad;                  /* where a shard leaves it, and the sum belongs */
    int64_t at, numel;              /* its place in a level */
} piece;

/* level[k] holds the sum of 2^k shards while bit k of the number of shards seen is set: a binary counter
 * whose carries are additions. */
struct tree_sum {
    lt_arena *arena;
    piece *piece;
    int n_pieces, n_shards;
    int64_t numel;
    lt_real *level[MAX_LEVELS];
};

static int levels_of(int n_shards)
{
    int n = 0;

    while ((1 << n) < n_shards)
        n++;
    return n;
}

static bool fill(tree_sum *t, lt_params *set)
{
    int n = 0;

    for (lt_param *p = lt_params_first(set); p; p = p->next)
        n += p->grad != NULL;
    t->piece = lt_arena_array(t->arena, (size_t)n, sizeof(*t->piece));
    if (!t->piece)
        return false;
    for (lt_param *p = lt_params_first(set); p; p = p->next) {
        if (!p->grad)
            continue;
        t->piece[t->n_pieces++] = (piece){ .grad = p->grad, .at = t->numel, .numel = lt_param_numel(p) };
        t->numel += lt_param_numel(p);
    }
    for (int k = 0; k < levels_of(t->n_shards); k++) {
        t->level[k] = lt_arena_array(t->arena, (size_t)t->numel, sizeof(lt_real));
        if (!t->level[k])
            return false;
    }
    return true;
}

tree_sum *tree_sum_new(lt_params *set, int n_shards)
{
    lt_arena *arena = lt_arena_new();
    tree_sum *t = arena ? lt_arena_alloc(arena, sizeof(*t)) : NULL;

    if (t) {
        t->arena = arena;
        t->n_shards = n_shards;
        if (fill(t, set))
            return t;
    }
    lt_arena_free(arena);
    lt_error(LT_ENOMEM, "no memory for the gradients of %d shards", n_shards);
    return NULL;
}

void tree_sum_free(tree_sum *t)
{
    if (t)
        lt_arena_free(t->arena);
}

typedef struct {
    const tree_sum *t;
    int level;
} level_job;

/* grad = level + grad */
static void add_piece(void *ctx, int64_t i)
{
    const level_job *j = ctx;
    const piece *c = &j->t->piece[i];
    const lt_real *from = j->t->level[j->level] + c->at;

    for (int64_t k = 0; k < c->numel; k++)
        c->grad[k] = from[k] + c->grad[k];
}

/* level = grad */
static void store_piece(void *ctx, int64_t i)
{
    const level_job *j = ctx;
    const piece *c = &j->t->piece[i];

    memcpy(j->t->level[j->level] + c->at, c->grad, (size_t)c->numel * sizeof(lt_real));
}

static void each_piece(const tree_sum *t, int level, lt_task_fn fn)
{
    lt_parallel_for(t->n_pieces, fn, &(level_job){ t, level });
}

void tree_sum_add(tree_sum *t, int shard)
{
    int k = 0;

    for (; shard >> k & 1; k++)
        each_piece(t, k, add_piece);
    if (shard + 1 < t->n_shards) {
        each_piece(t, k, store_piece);
        return;
    }
    for (k++; k < MAX_LEVELS; k++)              /* not a power of two: what is left, small to large */
        if (shard >> k & 1)
            each_piece(t, k, add_piece);
}

size_t tree_sum_bytes(const tree_sum *t)
{
    return lt_arena_bytes(t->arena);
}
