/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Adds the gradients of a step's virtual shards over a fixed binary tree of shard numbers: first 0 + 1 and
 * 2 + 3, then those sums, and so on. The order of additions is the number of shards' alone, so it does not
 * matter who computed which shard.
 */
#ifndef TRAIN_TREE_SUM_H
#define TRAIN_TREE_SUM_H

#include "libtensor/graph/param.h"

/* A whole subtree: shards first to first + 2^level - 1 */
typedef struct { int first, level; } tree_node;

enum { TREE_NODES_MAX = 32 };

/* tree_nodes - the fewest subtrees that have shards first to end - 1, in order; returns their number */
int tree_nodes(int first, int end, tree_node out[TREE_NODES_MAX]);

typedef struct tree_sum tree_sum;

/**
 * tree_sum_new - for n_shards shards of the parameters that have a gradient, and of n more numbers
 *
 * Make it after the training plan is compiled, and anew when a parameter has got other rows. Of parameters that are
 * stepped by rows the touched ones are summed. Holds as many copies of the gradients as the tree has
 * levels below its root: none for one shard. NULL without memory.
 */
tree_sum *tree_sum_new(lt_params *set, lt_real *more, int64_t n, int n_shards);
void tree_sum_free(tree_sum *t);

/* tree_sum_begin - what follows is the sum of shards first to end - 1: all of them, or a subtree */
void tree_sum_begin(tree_sum *t, int first, int end);

/* tree_sum_add - the parameters hold the gradients of a shard (level 0) or the sum of a subtree, the next in order;
 * after the last one they hold the sum of all. A shard without samples is added too, as zeros. */
void tree_sum_add(tree_sum *t, tree_node n);

/* tree_sum_numel - numbers that are summed in this step, of at most tree_sum_room; tree_sum_pack - copy them out of the
 * parameters, in the same order on every rank; tree_sum_unpack - and in again */
int64_t tree_sum_numel(const tree_sum *t);
int64_t tree_sum_room(const tree_sum *t);
void tree_sum_pack(const tree_sum *t, lt_real *out);
void tree_sum_unpack(const tree_sum *t, const lt_real *in);

size_t tree_sum_bytes(const tree_sum *t);

#endif
