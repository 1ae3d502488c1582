/* SPDX-License-Identifier: Apache-2.0 */
/* The tree of shard numbers: its order of additions, for any number of shards. */
#include "tests/suite.h"
#include "train/tree_sum.h"

enum { N = 33 };

static float shard_value(int shard, int i)
{
    return 1.0f / (float)(3 + 7 * shard + i) + (shard % 2 ? 1e4f : 1e-4f);
}

/* The sum of shards [lo, hi), hi - lo a power of two or whatever is left at the end. */
static float expected(int lo, int hi, int i)
{
    int half = 1;

    if (hi - lo == 1)
        return shard_value(lo, i);
    while (2 * half < hi - lo)
        half *= 2;
    return expected(lo, lo + half, i) + expected(lo + half, hi, i);
}

START_TEST(order)
{
    const int n_shards = _i;
    lt_params *set = lt_params_new();
    lt_param *w = lt_params_add(set, "", "w", LT_WEIGHT, LT_SHAPE(N));
    tree_sum *t;

    ck_assert(lt_param_need_grad(w));
    t = tree_sum_new(set, NULL, 0, n_shards);
    ck_assert_ptr_nonnull(t);
    for (int again = 0; again < 2; again++) {
        for (int s = 0; s < n_shards; s++) {
            for (int i = 0; i < N; i++)
                w->grad[i] = shard_value(s, i);
            tree_sum_add(t, (tree_node){ s, 0 });
        }
        for (int i = 0; i < N; i++)
            ck_assert_float_eq(w->grad[i], expected(0, n_shards, i));
    }
    tree_sum_free(t);
    lt_params_free(set);
}
END_TEST

/* Shards cut at two places, the parts summed apart by whole subtrees, in any order, and these added: the same bits. */
START_TEST(parts)
{
    const int n_shards = _i;
    lt_params *set = lt_params_new();
    lt_param *w = lt_params_add(set, "", "w", LT_WEIGHT, LT_SHAPE(N));
    tree_node node[3 * TREE_NODES_MAX];
    float sum[3 * TREE_NODES_MAX][N];
    tree_sum *t;

    ck_assert(lt_param_need_grad(w));
    t = tree_sum_new(set, NULL, 0, n_shards);
    ck_assert_ptr_nonnull(t);
    ck_assert_int_eq(tree_sum_numel(t), N);
    for (int a = 0; a <= n_shards; a++) {
        const int b = (a + n_shards) / 2;
        int n = tree_nodes(0, a, node);

        n += tree_nodes(a, b, node + n);
        n += tree_nodes(b, n_shards, node + n);
        for (int k = n - 1; k >= 0; k--) {
            const int end = node[k].first + (1 << node[k].level);

            tree_sum_begin(t, node[k].first, end);
            for (int s = node[k].first; s < end; s++) {
                for (int i = 0; i < N; i++)
                    w->grad[i] = shard_value(s, i);
                tree_sum_add(t, (tree_node){ s, 0 });
            }
            tree_sum_pack(t, sum[k]);
        }
        tree_sum_begin(t, 0, n_shards);
        for (int k = 0; k < n; k++) {
            tree_sum_unpack(t, sum[k]);
            tree_sum_add(t, node[k]);
        }
        for (int i = 0; i < N; i++)
            ck_assert_float_eq(w->grad[i], expected(0, n_shards, i));
    }
    tree_sum_free(t);
    lt_params_free(set);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_loop_test(c, order, 1, 18);
    tcase_add_loop_test(c, parts, 1, 18);
}

int main(void)
{
    return run_suite("tree_sum", add_tests);
}
