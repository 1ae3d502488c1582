/* SPDX-License-Identifier: Apache-2.0 */
/* batch_norm in training and with running statistics, against torch.nn.functional.batch_norm. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_batch_norm(in[0], in[1], in[2], in[3], in[4], 1e-5); }
static lt_tensor *no_eps(lt_tensor **in) { return lt_batch_norm(in[0], in[1], in[2], in[3], in[4], 0); }

/* What plans with gradients do together */
static lt_tensor *leaky(lt_tensor **in) { return lt_leaky_relu(build(in), 0.1); }
static lt_tensor *sum(lt_tensor **in) { return lt_add(in[5], build(in)); }
static lt_tensor *residual(lt_tensor **in) { return lt_leaky_relu(sum(in), 0.1); }

static lt_tensor *depthwise(lt_tensor *x, lt_tensor *w, int stride)
{
    return lt_conv2d(x, w, NULL, &(lt_conv_opts){ .stride = stride, .pad = (int)lt_dim(w, 2) / 2,
                                                  .groups = (int)lt_dim(w, 0) });
}

static lt_tensor *before_3x3(lt_tensor **in) { return depthwise(lt_silu(build(in)), in[5], 1); }
static lt_tensor *before_5x5_by_2(lt_tensor **in) { return depthwise(build(in), in[5], 2); }

static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    (input == 4 ? fill_positive : fill_clear_of_zero)(c, input, v, n, r);
}

/* Small weights: bias and residual say on which side of the kink a result is. */
static void fill_off_kink(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    const lt_real by = input == 1 ? (lt_real)0.03 : input == 5 ? 3 : 1;

    fill(c, input, v, n, r);
    for (int64_t i = 0; i < n; i++)
        v[i] *= by * (input == 2 && c->in[5].role ? (lt_real)0.1 : 1);
}

#define STATS(n) S(n), S(n), C(n), C(n)

static const op_case cases[] = {
    { "map", build, .in = { S(2, 3, 5, 7), STATS(3) }, .fill = fill },
    { "rows", build, .in = { S(9, 5), STATS(5) }, .fill = fill },
    { "one_channel", build, .in = { S(3, 1, 4), STATS(1) }, .fill = fill },
    { "leaky", leaky, .in = { S(2, 3, 5, 7), STATS(3) }, .fill = fill_off_kink },
    { "residual", residual, .in = { S(2, 3, 5, 7), STATS(3), S(2, 3, 5, 7) }, .fill = fill_off_kink },
    { "sum", sum, .in = { S(3, 2, 4), STATS(2), S(3, 2, 4) }, .fill = fill },
    { "before_3x3", before_3x3, .in = { S(2, 2, 21, 20), STATS(2), S(2, 1, 3, 3) }, .fill = fill, .no_vectors = true,
      .together = true },
    { "before_5x5_by_2", before_5x5_by_2, .in = { S(1, 3, 41, 42), STATS(3), S(3, 1, 5, 5) }, .fill = fill,
      .no_vectors = true, .together = true },
    { "long_residual", residual, .in = { S(4, 5, 31, 43), STATS(5), S(4, 5, 31, 43) }, .fill = fill_off_kink,
      .no_vectors = true },
    { "long", build, .in = { S(4, 9, 31, 33), STATS(9) }, .fill = fill, .no_vectors = true },
    { "no_images", build, .in = { S(0, 3, 5, 7), STATS(3) }, .fill = fill, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(7), STATS(7) }, "batch_norm: its input has no dimension 1 for channels" },
    { build, { S(2, 3, 4), S(4), S(3), C(3), C(3) }, "batch_norm: weight is (4), want (3)" },
    { build, { S(2, 3, 4), S(3), S(3), C(3), C(2) }, "batch_norm: running var is (2), want (3)" },
    { no_eps, { S(2, 3, 4), STATS(3) }, "batch_norm: eps is 0, want a number above 0" },
};

static void vary(op_case *c, lt_rng *r)
{
    const int64_t channels = pick(r, 1, 6);

    c->in[0].shape = LT_SHAPE(pick(r, 2, 4), channels, pick(r, 2, 9), pick(r, 2, 5));
    for (int i = 1; i < 5; i++)
        c->in[i].shape = LT_SHAPE(channels);
}

const op_suite batch_norm_suite = { "batch_norm", CASES(cases), BAD(bad), .vary = vary };
