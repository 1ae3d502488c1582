/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Adds the gradients of a step's virtual shards over a fixed binary tree of shard numbers: first 0 + 1 and
 * 2 + 3, then those sums, and so on. The order of additions is the number of shards' alone, so it does not
 * matter who computed which shard.
 */
#ifndef TRAIN_TREE_SUM_H
#define TRAIN_TREE_SUM_H

#include "libtensor/graph/param.h"

/* tree_owner - which of n_ranks processes computes a shard; whole subtrees stay together */
static inline int tree_owner(int shard, int n_shards, int n_ranks)
{
    return (int)((int64_t)shard * n_ranks / n_shards);
}

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

/* tree_sum_add - shard number `shard`, the next in order, has left its gradients in the parameters; after the last one
 * these hold the sum. A shard without samples is added too, as zeros. */
void tree_sum_add(tree_sum *t, int shard);

size_t tree_sum_bytes(const tree_sum *t);

#endif
