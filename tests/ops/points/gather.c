/* SPDX-License-Identifier: Apache-2.0 */
/* gather and group against indexing in torch; rows that are not there, and rows that are read often. */
#include "tests/ops/suite.h"

enum { N = 7 };                     /* rows of the small cases */

/* 0, 3, 6, 2, 5 ...: all rows in turn, and -1 and N now and then */
static lt_tensor *index_of(lt_tensor *x, lt_shape shape, int rows)
{
    int32_t index[4096];

    for (int64_t i = 0; i < lt_shape_numel(&shape); i++)
        index[i] = i % 11 == 9 ? -1 : i % 11 == 10 ? rows : (int32_t)(3 * i % rows);
    return lt_constant(x->graph, LT_I32, shape, index);
}

static lt_tensor *flat(lt_tensor **in) { return lt_gather(in[0], index_of(in[0], LT_SHAPE(2, 23), N)); }
static lt_tensor *grouped(lt_tensor **in) { return lt_gather(in[0], index_of(in[0], LT_SHAPE(2, 4, 5), N)); }
static lt_tensor *numbers(lt_tensor **in) { return lt_gather(in[0], index_of(in[0], LT_SHAPE(3, 9), N)); }
static lt_tensor *none(lt_tensor **in) { return lt_gather(in[0], index_of(in[0], LT_SHAPE(2, 0), N)); }
static lt_tensor *many(lt_tensor **in) { return lt_gather(in[0], index_of(in[0], LT_SHAPE(2, 2048), 100)); }
static lt_tensor *real_index(lt_tensor **in) { return lt_gather(in[0], in[1]); }

static const op_case gather_cases[] = {
    { "flat", flat, .in = { S(2, N, 5) } },
    { "grouped", grouped, .in = { S(2, N, 3) } },
    { "numbers", numbers, .in = { S(3, N) } },
    { "none", none, .in = { S(2, N, 3) }, .no_vectors = true },
    { "many", many, .in = { S(2, 100, 37) }, .no_vectors = true },
};

static const op_bad_case gather_bad[] = {
    { real_index, { S(2, N, 3), C(2, 4) }, "gather: the index is (2, 4) and no LT_I32, want integers for 2 sets" },
    { flat, { S(3, N, 3) }, "gather: the index is (2, 23), want integers for 3 sets" },
    { flat, { S(N) }, "gather: its input is (7), want (batch, rows, ...)" },
    { grouped, { S(2, N, 1, 1, 1, 1) }, "gather: a result of 7 dimensions, at most 6 can be" },
};

const op_suite gather_suite = { "gather", CASES(gather_cases), BAD(gather_bad) };

static lt_tensor *around(lt_tensor **in) { return lt_group(in[0], in[1], index_of(in[0], LT_SHAPE(2, 4, 5), N)); }
static lt_tensor *large(lt_tensor **in) { return lt_group(in[0], in[1], index_of(in[0], LT_SHAPE(2, 64, 32), 100)); }
static lt_tensor *two(lt_tensor **in) { return lt_group(in[0], in[1], index_of(in[0], LT_SHAPE(2, 4), N)); }

static const op_case group_cases[] = {
    { "around", around, .in = { S(2, 3, N), S(2, 3, 4) } },
    { "no_centre", around, .in = { S(2, 6, N) } },
    { "large", large, .in = { S(2, 35, 100), S(2, 35, 64) }, .no_vectors = true },
};

static const op_bad_case group_bad[] = {
    { around, { S(2, 3, N), S(2, 3, 5) }, "group: centre is (2, 3, 5), want (2, 3, 4)" },
    { two, { S(2, 3, N), S(2, 3, 4) }, "group: the index is (2, 4), want (2, centres, points) of integers" },
    { around, { S(2, N) }, "group: its input is (2, 7), want 3 dimensions" },
};

const op_suite group_suite = { "group", CASES(group_cases), BAD(group_bad) };
