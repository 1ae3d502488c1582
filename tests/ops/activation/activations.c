/* SPDX-License-Identifier: Apache-2.0 */
/* Smooth activations against torch's, whose gelu is the one with erf; quick_gelu against its formula there. The name
 * tanh is C's. */
#include "tests/ops/suite.h"

static lt_tensor *sigmoid(lt_tensor **in) { return lt_sigmoid(in[0]); }
static lt_tensor *hyperbolic(lt_tensor **in) { return lt_tanh(in[0]); }
static lt_tensor *silu(lt_tensor **in) { return lt_silu(in[0]); }
static lt_tensor *gelu(lt_tensor **in) { return lt_gelu(in[0]); }
static lt_tensor *quick_gelu(lt_tensor **in) { return lt_quick_gelu(in[0]); }

/* Far enough out for both tails. */
static void wide(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    (void)c;
    (void)input;
    for (int64_t i = 0; i < n; i++)
        v[i] = (lt_real)lt_rng_range(r, -12, 12);
}

#define OP_CASES(op) {                                                                              \
    { "one", op, .in = { S(1) } },                                                                  \
    { "rows", op, .in = { S(3, 67) } },                                                             \
    { "map", op, .in = { S(2, 3, 5, 7) } },                                                         \
    { "empty", op, .in = { S(0, 7) } },                                                             \
    { "long", op, .in = { S(40001) }, .no_vectors = true },                                         \
    { "wide", op, .in = { S(241) }, .fill = wide },                                                 \
}

static const op_case sigmoid_cases[] = OP_CASES(sigmoid), tanh_cases[] = OP_CASES(hyperbolic);
static const op_case silu_cases[] = OP_CASES(silu), gelu_cases[] = OP_CASES(gelu);
static const op_case quick_gelu_cases[] = OP_CASES(quick_gelu);

const op_suite sigmoid_suite = { "sigmoid", CASES(sigmoid_cases), .vary = vary_first };
const op_suite tanh_suite = { "tanh", CASES(tanh_cases), .vary = vary_first };
const op_suite silu_suite = { "silu", CASES(silu_cases), .vary = vary_first };
const op_suite gelu_suite = { "gelu", CASES(gelu_cases), .vary = vary_first };
const op_suite quick_gelu_suite = { "quick_gelu", CASES(quick_gelu_cases), .vary = vary_first };
