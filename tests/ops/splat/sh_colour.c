/* SPDX-License-Identifier: Apache-2.0 */
/* sh_colour against PyTorch, with a basis that SciPy's spherical harmonics confirm. */
#include "libtensor/ops/splat/gaussians.h"
#include "tests/ops/suite.h"

static lt_tensor *of_degree(lt_tensor **in, int32_t degree)
{
    return lt_sh_colour(in[0], in[1], lt_constant(in[0]->graph, LT_I32, (lt_shape){ 0 }, &degree));
}

static lt_tensor *negative(lt_tensor **in) { return of_degree(in, -1); }
static lt_tensor *zero(lt_tensor **in) { return of_degree(in, 0); }
static lt_tensor *one(lt_tensor **in) { return of_degree(in, 1); }
static lt_tensor *two(lt_tensor **in) { return of_degree(in, 2); }
static lt_tensor *three(lt_tensor **in) { return of_degree(in, 3); }
static lt_tensor *nine(lt_tensor **in) { return of_degree(in, 9); }
static lt_tensor *real_degree(lt_tensor **in) { return lt_sh_colour(in[0], in[1], in[2]); }

/* So many that some would be close to where they are cut off: these are all clear of it. */
static void fill_pale(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    fill_clear_of_zero(c, input, v, n, r);
    for (int64_t i = 0; input == 0 && i < n; i++)
        v[i] *= (lt_real)0.05;
}

static const op_case cases[] = {
    { "three", three, .in = { S(9, 16, 3), S(9, 3) } },
    { "two", two, .in = { S(5, 16, 3), S(5, 3) } },
    { "one", one, .in = { S(5, 16, 3), S(5, 3) } },
    { "zero", zero, .in = { S(5, 16, 3), S(5, 3) } },
    { "negative", negative, .in = { S(2, 16, 3), S(2, 3) } },
    { "nine", nine, .in = { S(2, 16, 3), S(2, 3) } },
    { "given", three, .in = { S(4, 16, 3), C(4, 3) } },
    { "empty", three, .in = { S(0, 16, 3), S(0, 3) } },
    { "long", three, .in = { S(600, 16, 3), S(600, 3) }, .fill = fill_pale, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { three, { S(9, 48), S(9, 3) }, "sh_colour: sh is (9, 48), want 3 dimensions" },
    { three, { S(9, 9, 3), S(9, 3) }, "sh_colour: sh is (9, 9, 3), want (9, 16, 3)" },
    { three, { S(9, 16, 3), S(8, 3) }, "sh_colour: direction is (8, 3), want (9, 3)" },
    { real_degree, { S(9, 16, 3), S(9, 3), C(1) }, "sh_colour: degree is (1) and no LT_I32, want one integer" },
};

const op_suite sh_colour_suite = { "sh_colour", CASES(cases), BAD(bad) };
