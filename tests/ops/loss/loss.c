/* SPDX-License-Identifier: Apache-2.0 */
/* l1_loss, mse_loss and smooth_l1_loss against torch, with and without weights of the samples. */
#include "tests/ops/suite.h"

static lt_tensor *l1_loss(lt_tensor **in) { return lt_l1_loss(in[0], in[1], in[2]); }
static lt_tensor *smooth_l1_loss(lt_tensor **in) { return lt_smooth_l1_loss(in[0], in[1], in[2]); }
static lt_tensor *mse_loss(lt_tensor **in) { return lt_mse_loss(in[0], in[1], in[2]); }

/* Differences of at least 0.1; weights of 0.5 and more, the second 0. */
static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    (input == 2 ? fill_positive : fill_clear_of_zero)(c, input, v, n, r);
    for (int64_t i = 0; input == 1 && i < n; i++)
        v[i] += v[i] > 0 ? 2 : -2;
    if (input == 2 && n > 1)
        v[1] = 0;
}

/* Differences below 0.8 and above 1.7 in turn */
static void fill_around_one(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    fill(c, input, v, n, r);
    for (int64_t i = 0; input < 2 && i < n; i++)
        v[i] = input == 1 && i % 2 ? v[i] : (lt_real)0.4 * v[i] / (input == 1 ? 3 : 1);
}

#define OP_CASES(op, how) {                                                                         \
    { "weighed", op, .in = { S(3, 4, 5), S(3, 4, 5), C(3) }, .fill = how },                         \
    { "plain", op, .in = { S(3, 67), S(3, 67) }, .fill = how },                                     \
    { "target", op, .in = { S(2, 5), C(2, 5), C(2) }, .fill = how },                                \
    { "number", op, .in = { NUMBER, NUMBER }, .fill = how },                                        \
    { "empty", op, .in = { S(0, 4), S(0, 4) }, .fill = how, .no_vectors = true },                   \
    { "long", op, .in = { S(37, 999), S(37, 999), C(37) }, .fill = how, .no_vectors = true },       \
}

static const op_case l1_cases[] = OP_CASES(l1_loss, fill), mse_cases[] = OP_CASES(mse_loss, fill);
static const op_case smooth_l1_cases[] = OP_CASES(smooth_l1_loss, fill_around_one);

#define OP_BAD(op) {                                                                                \
    { op, { S(2, 3), S(3, 2) }, #op ": second operand is (3, 2), want (2, 3)" },                    \
    { op, { S(2, 3), S(2, 3), C(3) }, #op ": weight is (3), want (2)" },                            \
    { op, { S(2, 3) }, #op ": input 1 is missing" },                                                \
}

static const op_bad_case l1_bad[] = OP_BAD(l1_loss), mse_bad[] = OP_BAD(mse_loss);
static const op_bad_case smooth_l1_bad[] = OP_BAD(smooth_l1_loss);

static void vary(op_case *c, lt_rng *r)
{
    vary_first(c, r);
    c->in[1].shape = c->in[0].shape;
    c->in[2].shape = LT_SHAPE(c->in[0].shape.dim[0]);
}

const op_suite l1_loss_suite = { "l1_loss", CASES(l1_cases), BAD(l1_bad), .vary = vary };
const op_suite mse_loss_suite = { "mse_loss", CASES(mse_cases), BAD(mse_bad), .vary = vary };
const op_suite smooth_l1_loss_suite = { "smooth_l1_loss", CASES(smooth_l1_cases), BAD(smooth_l1_bad), .vary = vary };
