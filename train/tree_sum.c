/* SPDX-License-Identifier: Apache-2.0 */
#include "train/tree_sum.h"

#include "libtensor/base/parallel.h"
#include "libtensor/graph/rows.h"

#include <string.h>

enum { MAX_LEVELS = 16 };

typedef struct {
    lt_real *grad;                  /* where a shard leaves it, and the sum belongs */
    const lt_param *rows;           /* of which only touched rows count; else NULL */
    int64_t at, numel;              /* its place in a level */
} piece;

/* level[k] holds the sum of 2^k shards while bit k of the number of shards seen is set: a binary counter
 * whose carries are additions. */
struct tree_sum {
    lt_arena *arena;
    piece *piece;
    int n_pieces, n_shards;
    int first, end;                 /* of the shards that are being summed */
    int64_t numel;                  /* of all rows */
    lt_real *level[MAX_LEVELS];
};

static int levels_of(int n_shards)
{
    int n = 0;

    while ((1 << n) < n_shards)
        n++;
    return n;
}

static void add(tree_sum *t, lt_real *grad, int64_t numel, const lt_param *rows)
{
    t->piece[t->n_pieces++] = (piece){ .grad = grad, .rows = rows, .at = t->numel, .numel = numel };
    t->numel += numel;
}

static bool fill(tree_sum *t, lt_params *set, lt_real *more, int64_t n_more)
{
    int n = n_more > 0;

    for (lt_param *p = lt_params_first(set); p; p = p->next)
        n += p->grad != NULL;
    t->piece = lt_arena_array(t->arena, (size_t)n, sizeof(*t->piece));
    if (!t->piece)
        return false;
    for (lt_param *p = lt_params_first(set); p; p = p->next) {
        if (p->grad)
            add(t, p->grad, lt_param_numel(p), p->rows ? p : NULL);
    }
    if (n_more)
        add(t, more, n_more, NULL);
    for (int k = 0; k < levels_of(t->n_shards); k++) {
        t->level[k] = lt_arena_array(t->arena, (size_t)t->numel, sizeof(lt_real));
        if (!t->level[k])
            return false;
    }
    return true;
}

tree_sum *tree_sum_new(lt_params *set, lt_real *more, int64_t n, int n_shards)
{
    lt_arena *arena = lt_arena_new();
    tree_sum *t = arena ? lt_arena_alloc(arena, sizeof(*t)) : NULL;

    if (t) {
        t->arena = arena;
        t->n_shards = t->end = n_shards;
        if (fill(t, set, more, n))
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

/* Which numbers of a piece count: the i-th range from *from on, *n of them; false behind the last one */
static bool range_of(const piece *c, int i, int64_t *from, int64_t *n)
{
    const lt_row_range *touched;
    int ranges;

    if (!c->rows) {
        *from = 0;
        *n = c->numel;
        return i == 0;
    }
    touched = lt_param_touched(c->rows, &ranges);
    if (i >= ranges)
        return false;
    *from = touched[i].first * lt_param_width(c->rows);
    *n = touched[i].n * lt_param_width(c->rows);
    return true;
}

/* grad = level + grad */
static void add_piece(void *ctx, int64_t i)
{
    const level_job *j = ctx;
    const piece *c = &j->t->piece[i];
    const lt_real *level = j->t->level[j->level] + c->at;
    int64_t from, n;

    for (int r = 0; range_of(c, r, &from, &n); r++)
        for (int64_t k = from; k < from + n; k++)
            c->grad[k] = level[k] + c->grad[k];
}

/* level = grad */
static void store_piece(void *ctx, int64_t i)
{
    const level_job *j = ctx;
    const piece *c = &j->t->piece[i];
    lt_real *level = j->t->level[j->level] + c->at;
    int64_t from, n;

    for (int r = 0; range_of(c, r, &from, &n); r++)
        memcpy(level + from, c->grad + from, (size_t)n * sizeof(lt_real));
}

static void each_piece(const tree_sum *t, int level, lt_task_fn fn)
{
    lt_parallel_for(t->n_pieces, fn, &(level_job){ t, level });
}

int tree_nodes(int first, int end, tree_node out[TREE_NODES_MAX])
{
    int n = 0;

    while (first < end) {
        int level = 0;

        while (!(first >> level & 1) && first + (2 << level) <= end)
            level++;
        out[n++] = (tree_node){ first, level };
        first += 1 << level;
    }
    return n;
}

void tree_sum_begin(tree_sum *t, int first, int end)
{
    t->first = first;
    t->end = end;
}

void tree_sum_add(tree_sum *t, tree_node n)
{
    const int before = n.first - t->first;
    int k = n.level;

    for (; before >> k & 1; k++)
        each_piece(t, k, add_piece);
    if (n.first + (1 << n.level) < t->end) {
        each_piece(t, k, store_piece);
        return;
    }
    for (k++; k < MAX_LEVELS; k++)              /* not a power of two: what is left, small to large */
        if (before >> k & 1)
            each_piece(t, k, add_piece);
}

/* ---- as a message ------------------------------------------------------------------------------------------ */

/* Copy the numbers that count out of the parameters, or with in, into them; returns how many there are. */
static int64_t copy(const tree_sum *t, lt_real *out, const lt_real *in)
{
    int64_t done = 0, from, n;

    for (int i = 0; i < t->n_pieces; i++) {
        for (int r = 0; range_of(&t->piece[i], r, &from, &n); r++, done += n) {
            if (out)
                memcpy(out + done, t->piece[i].grad + from, (size_t)n * sizeof(lt_real));
            if (in)
                memcpy(t->piece[i].grad + from, in + done, (size_t)n * sizeof(lt_real));
        }
    }
    return done;
}

int64_t tree_sum_numel(const tree_sum *t)
{
    return copy(t, NULL, NULL);
}

int64_t tree_sum_room(const tree_sum *t)
{
    return t->numel;
}

void tree_sum_pack(const tree_sum *t, lt_real *out)
{
    copy(t, out, NULL);
}

void tree_sum_unpack(const tree_sum *t, const lt_real *in)
{
    copy(t, NULL, in);
}

size_t tree_sum_bytes(const tree_sum *t)
{
    return lt_arena_bytes(t->arena);
}
