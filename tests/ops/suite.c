/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/ops/suite.h"

#define SUITE(name) extern const op_suite name##_suite;
#include "tests/ops/suites.h"
#undef SUITE

const op_suite *const op_suites[] = {
#define SUITE(name) &name##_suite,
#include "tests/ops/suites.h"
#undef SUITE
};
const int n_op_suites = (int)LT_COUNT(op_suites);

void fill_clear_of_zero(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    (void)c;
    (void)input;
    for (int64_t i = 0; i < n; i++)
        v[i] = (lt_real)(lt_rng_range(r, 0.1, 1) * (lt_rng_below(r, 2) ? 1 : -1));
}

void fill_positive(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    (void)c;
    (void)input;
    for (int64_t i = 0; i < n; i++)
        v[i] = (lt_real)lt_rng_range(r, 0.5, 1.5);
}

void fill_apart(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    (void)c;
    (void)input;
    for (int64_t i = 0; i < n; i++)
        v[i] = (lt_real)(0.01 * (double)(i - n / 2));
    for (int64_t i = n - 1; i > 0; i--) {
        const int64_t j = lt_rng_below(r, (uint32_t)(i + 1));
        const lt_real t = v[i];

        v[i] = v[j];
        v[j] = t;
    }
}

int64_t pick(lt_rng *r, int lo, int hi)
{
    return lo + lt_rng_below(r, (uint32_t)(hi - lo + 1));
}

void vary_first(op_case *c, lt_rng *r)
{
    lt_shape *s = &c->in[0].shape;

    s->rank = (int)pick(r, 1, 4);
    for (int i = 0; i < s->rank; i++)
        s->dim[i] = pick(r, 1, 9);
}

void vary_map(op_case *c, lt_rng *r)
{
    c->in[0].shape = LT_SHAPE(pick(r, 1, 3), pick(r, 1, 5), pick(r, 3, 9), pick(r, 3, 11));
}
