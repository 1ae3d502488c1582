/* SPDX-License-Identifier: Apache-2.0 */
/* The object head's losses, whose confidence target comes from its own op and passes no gradient. */
#include "models/heads/object_head.h"
#include "tests/ops/suite.h"

static object_losses losses(lt_tensor **in)
{
    const object_out o = { .conf = in[0], .x = in[1], .y = in[2] };

    return object_head_losses(&o, in[3], in[4], in[5]);
}

static lt_tensor *confidence(lt_tensor **in) { return losses(in).conf; }
static lt_tensor *places(lt_tensor **in) { return losses(in).p2d; }

enum { N = OBJECT_POINTS };

/* Predictions away from the kinks of |a - b|: the targets lie further out. */
static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    if (input == 4)                                     /* mask: 0 or 1 */
        for (int64_t i = 0; i < n; i++)
            v[i] = (lt_real)lt_rng_below(r, 2);
    else
        fill_positive(c, input, v, n, r);
    for (int64_t i = 0; i < n && (input == 0 || input == 3); i++)
        v[i] += 2;
}

static const op_case cases[] = {
    { "confidence", confidence, .in = { S(2, N, 2, 2), C(2, N, 2, 2), C(2, N, 2, 2), C(2, N, 2), C(2, 2, 2), C(2) },
      .fill = fill },
    { "places", places, .in = { C(2, N, 2, 2), S(2, N, 2, 2), S(2, N, 2, 2), C(2, N, 2), C(2, 2, 2), C(2) },
      .fill = fill },
};

const op_suite confidence_target_suite = { "confidence_target", CASES(cases) };
