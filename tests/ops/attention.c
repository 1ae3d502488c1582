/* SPDX-License-Identifier: Apache-2.0 */
/* attention against torch.softmax(q k^T / sqrt(d)) v. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_attention(in[0], in[1], in[2], 2); }
static lt_tensor *one_head(lt_tensor **in) { return lt_attention(in[0], in[1], in[2], 1); }
static lt_tensor *self(lt_tensor **in) { return lt_attention(in[0], in[0], in[0], 3); }
static lt_tensor *no_heads(lt_tensor **in) { return lt_attention(in[0], in[1], in[2], 0); }

static const op_case cases[] = {
    { "cross", build, .in = { S(2, 5, 6), S(2, 7, 6), S(2, 7, 6) } },
    { "one", one_head, .in = { S(1, 1, 1), S(1, 1, 1), S(1, 1, 1) } },
    { "self", self, .in = { S(2, 9, 12) } },
    { "blocks", build, .in = { S(1, 67, 4), S(1, 70, 4), S(1, 70, 4) } },
    { "no_queries", build, .in = { S(2, 0, 6), S(2, 7, 6), S(2, 7, 6) } },
    { "empty_batch", build, .in = { S(0, 5, 6), S(0, 7, 6), S(0, 7, 6) } },
    { "long", build, .in = { S(2, 300, 16), S(2, 131, 16), S(2, 131, 16) }, .no_vectors = true },
    { "strips", build, .in = { S(1, 13, 8), S(1, 300, 8), S(1, 300, 8) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(2, 5, 6), S(2, 7, 4), S(2, 7, 4) }, "attention: key is (2, 7, 4), want (2, 7, 6)" },
    { build, { S(2, 5, 6), S(2, 7, 6), S(2, 6, 6) }, "attention: value is (2, 6, 6), want (2, 7, 6)" },
    { build, { S(2, 5, 7), S(2, 7, 7), S(2, 7, 7) }, "attention: 2 heads do not divide 7 channels" },
    { no_heads, { S(2, 5, 6), S(2, 7, 6), S(2, 7, 6) }, "attention: 0 heads do not divide 6 channels" },
    { build, { S(2, 5, 6), S(2, 0, 6), S(2, 0, 6) }, "attention: there are no keys" },
    { build, { S(5, 6), S(2, 7, 6), S(2, 7, 6) }, "attention: query is (5, 6), want 3 dimensions" },
};

static void vary(op_case *c, lt_rng *r)
{
    const int64_t B = pick(r, 1, 2), channels = 2 * pick(r, 1, 5);

    c->in[0].shape = LT_SHAPE(B, pick(r, 0, 9), channels);
    c->in[1].shape = c->in[2].shape = LT_SHAPE(B, pick(r, 1, 9), channels);
}

const op_suite attention_suite = { "attention", CASES(cases), BAD(bad), .vary = vary };
