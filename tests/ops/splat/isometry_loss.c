/* SPDX-License-Identifier: Apache-2.0 */
/* isometry_loss against PyTorch. */
#include "libtensor/ops/splat/gaussians.h"
#include "tests/ops/suite.h"

#include <stdlib.h>

/* As in scripts/vectors/ops.py: neighbour k of row i is i + 2 k + 1, in a circle; every `hole`-th row has none. */
static lt_tensor *neighbours(lt_tensor *x, int64_t K, int64_t hole)
{
    const int64_t N = lt_dim(x, 0);
    int32_t *list = calloc((size_t)(N * K + 1), sizeof(*list));
    lt_tensor *t;

    for (int64_t i = 0; i < N * K; i++)
        list[i] = i / K % hole ? (int32_t)((i / K + 2 * (i % K) + 1) % N) : -1;
    t = lt_constant(x->graph, LT_I32, LT_SHAPE(N, K), list);
    free(list);
    return t;
}

static lt_tensor *build(lt_tensor **in) { return lt_isometry_loss(in[0], in[1], neighbours(in[0], 4, 1 << 20)); }
static lt_tensor *holes(lt_tensor **in) { return lt_isometry_loss(in[0], in[1], neighbours(in[0], 3, 3)); }
static lt_tensor *none(lt_tensor **in) { return lt_isometry_loss(in[0], in[1], neighbours(in[0], 2, 1)); }
static lt_tensor *itself(lt_tensor **in) { return lt_isometry_loss(in[0], in[0], neighbours(in[0], 2, 99)); }
static lt_tensor *real_list(lt_tensor **in) { return lt_isometry_loss(in[0], in[1], in[2]); }
static lt_tensor *short_list(lt_tensor **in) { return lt_isometry_loss(in[0], in[1], neighbours(in[2], 2, 9)); }

/* So many that some distances would hardly change: b's are all larger. */
static void fill_stretched(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    fill_clear_of_zero(c, input, v, n, r);
    for (int64_t i = 0; input == 1 && i < n; i++)
        v[i] *= 50;
}

static const op_case cases[] = {
    { "centres", build, .in = { S(11, 3), S(11, 3) } },
    { "covariances", build, .in = { S(11, 6), S(11, 6) } },
    { "before", build, .in = { C(11, 3), S(11, 3) } },
    { "holes", holes, .in = { S(10, 3), S(10, 3) } },
    { "none", none, .in = { S(5, 3), S(5, 3) } },
    { "itself", itself, .in = { S(7, 3) } },
    { "empty", build, .in = { S(0, 3), S(0, 3) } },
    { "long", build, .in = { S(600, 6), S(600, 6) }, .fill = fill_stretched, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(11, 3), S(11, 2) }, "isometry_loss: b is (11, 2), want (11, 3)" },
    { real_list, { S(5, 3), S(5, 3), C(5, 2) },
      "isometry_loss: neighbours is (5, 2) and no LT_I32, want integers (5, K)" },
    { short_list, { S(5, 3), S(5, 3), C(4, 3) }, "isometry_loss: neighbours is (4, 2), want integers (5, K)" },
};

const op_suite isometry_loss_suite = { "isometry_loss", CASES(cases), BAD(bad) };
