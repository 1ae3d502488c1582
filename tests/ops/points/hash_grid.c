/* SPDX-License-Identifier: Apache-2.0 */
/* hash_grid against NumPy: grids that have all corners, one with fewer entries, and hashed ones; places outside. */
#include "tests/ops/suite.h"

static lt_tensor *grids(lt_tensor **in)
{
    return lt_hash_grid(in[0], in[1], &(lt_hash_grid_opts){ .levels = 3, .base = 4, .finest = 16, .log2_size = 8 });
}

static lt_tensor *dense(lt_tensor **in)
{
    return lt_hash_grid(in[0], in[1], &(lt_hash_grid_opts){ .levels = 2, .base = 2, .finest = 3, .log2_size = 6 });
}

/* 8 corners, then 64 on 32 entries */
static lt_tensor *halves(lt_tensor **in)
{
    return lt_hash_grid(in[0], in[1], &(lt_hash_grid_opts){ .levels = 2, .base = 2, .finest = 4, .log2_size = 5 });
}

static lt_tensor *full(lt_tensor **in)
{
    const lt_hash_grid_opts paper = { .levels = 16, .base = 16, .finest = 2048, .log2_size = 16 };

    return lt_hash_grid(in[0], in[1], &paper);
}

static lt_tensor *falling(lt_tensor **in)
{
    return lt_hash_grid(in[0], in[1], &(lt_hash_grid_opts){ .levels = 2, .base = 16, .finest = 8, .log2_size = 16 });
}

static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    if (input == 1)
        fill_clear_of_zero(c, input, v, n, r);
    for (int64_t i = 0; input == 0 && i < n; i++)
        v[i] = (lt_real)lt_rng_range(r, -0.1, 1.1);
}

static const op_case cases[] = {
    { "grids", grids, .in = { C(2, 9, 3), S(576, 2) }, .fill = fill },
    { "dense", dense, .in = { C(5, 3), S(40, 1) }, .fill = fill },
    { "one", dense, .in = { C(3), S(40, 3) }, .fill = fill },
    { "halves", halves, .in = { C(7, 3), S(40, 2) }, .fill = fill },
    { "none", dense, .in = { C(0, 3), S(40, 2) }, .fill = fill, .no_vectors = true },
    { "long", grids, .in = { C(2500, 3), S(576, 2) }, .fill = fill, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { full, { C(4, 3), S(3, 2) }, "hash_grid: the table has 3 entries, the grids have 898024" },
    { grids, { C(4, 2), S(576, 2) }, "hash_grid: places are (4, 2), want (..., 3)" },
    { falling, { C(4, 3), S(576, 2) }, "hash_grid: 2 levels from 16 to 8, tables of 2^16: want at least one level, "
      "2 <= base <= finest <= 2^20, 4 <= log2_size <= 24" },
};

const op_suite hash_grid_suite = { "hash_grid", CASES(cases), BAD(bad) };
