/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: ops that go over Gaussians, and transforms that each has of its own or all share.
 */
#ifndef LT_OPS_SPLAT_ROWS_H
#define LT_OPS_SPLAT_ROWS_H

#include "libtensor/ops/common.h"
#include "libtensor/ops/splat/gaussians.h"

enum { SPLAT_ROWS = 128 };              /* Gaussians of a task: part of a shared transform's gradient, no tuning knob */

/* splat_by_block - call fn for pieces of [0, n) on all threads; piece i begins at i * SPLAT_ROWS */
typedef void (*splat_block_fn)(const lt_call *c, int64_t from, int64_t to);
void splat_by_block(const lt_call *c, int64_t n, splat_block_fn fn);

/* splat_want_transforms - shape rule: in[i] is (n, 3, 4) or (1, 3, 4) */
lt_status splat_want_transforms(lt_call *c, int i, int64_t n);

/* splat_step - elements from a Gaussian's transform to the next one's: 12, or 0 where they share one */
int64_t splat_step(const lt_tensor *transforms, int64_t n);

/* splat_shared_bytes - of work: 12 sums for each block, where all share a transform. splat_shared: those of the block
 * that begins at `from`, cleared, for its rows to add to. splat_add_shared: add all of them to din[i], in order. */
size_t splat_shared_bytes(const lt_call *c, int i, int64_t n);
double *splat_shared(const lt_call *c, int64_t from);
void splat_add_shared(const lt_call *c, int i, int64_t n);

#endif
