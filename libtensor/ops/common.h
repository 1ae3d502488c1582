/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the ops share: shape rules and ways to cut work.
 */
#ifndef LT_OPS_COMMON_H
#define LT_OPS_COMMON_H

#include "libtensor/base/parallel.h"
#include "libtensor/graph/onnx/onnx.h"
#include "libtensor/graph/op.h"
#include "libtensor/ops/ops.h"

#include <math.h>
#include <string.h>

/* op_same_shape - shape rule: the result is like in[0] */
lt_status op_same_shape(lt_call *c);

/* op_by_chunk - call fn for consecutive pieces of [0, n) on all threads; pieces depend on n alone */
typedef void (*op_chunk_fn)(const lt_call *c, int64_t at, size_t n);
void op_by_chunk(const lt_call *c, int64_t n, op_chunk_fn fn);

/* op_map - out = fn(in[0]), element by element;  op_map_grad - din[0] += fn(dout, z), where z tells the slope: in[0]
 * or the result */
typedef void (*op_map_fn)(lt_real *y, const lt_real *x, size_t n);
typedef void (*op_map_grad_fn)(lt_real *dx, const lt_real *dy, const lt_real *z, size_t n);
void op_map(const lt_call *c, op_map_fn fn);
void op_map_grad(const lt_call *c, op_map_grad_fn fn, const lt_tensor *z);

/* op_by_row - call fn(c, i) for i in [0, n) on all threads, several rows a task when rows are short */
typedef void (*op_row_fn)(const lt_call *c, int64_t row);
void op_by_row(const lt_call *c, int64_t n, int64_t row_cost, op_row_fn fn);

/* op_start - before an op with LT_OP_ASSIGNS adds to n elements of din[i] from `at`: clear them if it is the
 * first to. Done where they are added to, so that they pass through the cache once. */
void op_start(const lt_call *c, int i, int64_t at, int64_t n);

/* op_aligned - as many elements as n and what it takes for the next to be aligned to LT_ALIGN */
static inline int64_t op_aligned(int64_t n)
{
    return lt_ceil_div(n, LT_ALIGN) * LT_ALIGN;
}

/* op_larger - of two sizes */
static inline size_t op_larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

/* op_check_window - of a convolution's weight: its last two dimensions are a window that kernels can do */
lt_status op_check_window(lt_call *c, const lt_tensor *w);

/* op_fills_blocks - maps (B, C, H, W) whose channels fill blocks of LT_BLOCK */
bool op_fills_blocks(const lt_tensor *t);

/* op_outer, op_inner - the product of the dimensions before and behind axis */
int64_t op_outer(const lt_tensor *t, int axis);
int64_t op_inner(const lt_tensor *t, int axis);

#endif
