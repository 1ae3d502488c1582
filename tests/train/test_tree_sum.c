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
            tree_sum_add(t, s);
        }
        for (int i = 0; i < N; i++)
            ck_assert_float_eq(w->grad[i], expected(0, n_shards, i));
    }
    tree_sum_free(t);
    lt_params_free(set);
}
END_TEST

/* Every rank has neighbouring shards, as many as the others where that is possible. */
START_TEST(owners)
{
    for (int ranks = 1; ranks <= 12; ranks++) {
        int count[12] = { 0 };

        for (int s = 0; s < 12; s++) {
            const int owner = tree_owner(s, 12, ranks);

            ck_assert(owner >= 0 && owner < ranks);
            ck_assert(s == 0 || owner >= tree_owner(s - 1, 12, ranks));
            count[owner]++;
        }
        for (int r = 0; r < ranks; r++)
            ck_assert_int_le(count[r], (12 + ranks - 1) / ranks);
    }
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_loop_test(c, order, 1, 18);
    tcase_add_test(c, owners);
}

int main(void)
{
    return run_suite("tree_sum", add_tests);
}
