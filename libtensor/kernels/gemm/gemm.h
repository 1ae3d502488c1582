/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Matrix products on all threads. The tiles are cut by the sizes alone and every element is one chain
 * of fused multiply-adds in the order of k: the same bits on any number of threads and any
 * instruction set.
 */
#ifndef LT_KERNELS_GEMM_GEMM_H
#define LT_KERNELS_GEMM_GEMM_H

#include "libtensor/kernels/kernels.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum { LT_NO_TRANS, LT_TRANS } lt_trans;

/**
 * lt_gemm - C = op(A) op(B), or C += op(A) op(B), all stored by rows
 *
 *   op(A)  (m, k)   A is (m, k), or (k, m) when ta is LT_TRANS; lda elements between its rows
 *   op(B)  (k, n)   B is (k, n), or (n, k) when tb is LT_TRANS; ldb elements between its rows
 *   C      (m, n)   ldc elements between rows; must not overlap A or B
 *   add             false: C is written, whatever it held; true: the chain starts from C
 *   e               what follows once the sum is complete (bias, residual, activation), or NULL
 *
 * m, n, k may be 0 (k = 0 leaves zeros, or C). Needs lt_kernels_init only for speed. Never fails:
 * its packing scratch (per thread, 640 KiB, kept) is on the stack where there is no memory.
 */
LT_API void lt_gemm(lt_trans ta, lt_trans tb, int64_t m, int64_t n, int64_t k,
                    const lt_real *a, int64_t lda, const lt_real *b, int64_t ldb,
                    bool add, lt_real *c, int64_t ldc, const lt_epilogue *e);

/**
 * lt_gemm_pack - op(B) in the order in which the product reads it: once for many products, as of weights
 * lt_gemm_packed - lt_gemm with such a B; the same bits
 *
 * packed has lt_gemm_packed_count(n, k) elements, and serves the instruction set in use when it was made.
 */
LT_API int64_t lt_gemm_packed_count(int64_t n, int64_t k);
LT_API void lt_gemm_pack(lt_trans tb, int64_t n, int64_t k, const lt_real *b, int64_t ldb, lt_real *packed);
LT_API void lt_gemm_packed(lt_trans ta, int64_t m, int64_t n, int64_t k, const lt_real *a, int64_t lda,
                           const lt_real *packed, bool add, lt_real *c, int64_t ldc, const lt_epilogue *e);

/**
 * lt_gemm_pair - C = op2(op1(A)), op(X) = epilogue(X B): the same bits as two products of dense rows
 *
 *   A (m, k)   packed1 of (hidden, k)   packed2 of (n, hidden)   C (m, n), may not overlap A
 *
 * What lies between is only there some rows at a time, in the cache of the thread that makes and reads it. e1 has no
 * residual. lt_gemm_pair_suits: with enough rows for all threads, and a middle that fits into a thread's scratch.
 */
LT_API bool lt_gemm_pair_suits(int64_t m, int64_t hidden, int64_t k);
LT_API void lt_gemm_pair(int64_t m, int64_t k, const lt_real *a, int64_t hidden, const lt_real *packed1,
                         const lt_epilogue *e1, int64_t n, const lt_real *packed2, const lt_epilogue *e2, lt_real *c);

/**
 * lt_gemm_batch - count products of one shape; operand i starts at a + i * a_step and so on
 *
 * A step of 0 shares that input. C's must not overlap. Biases are the same for all of them; the
 * residual of product i starts c_step after that of product i - 1, as C does.
 */
LT_API void lt_gemm_batch(int64_t count, lt_trans ta, lt_trans tb, int64_t m, int64_t n, int64_t k,
                          const lt_real *a, int64_t lda, int64_t a_step,
                          const lt_real *b, int64_t ldb, int64_t b_step,
                          bool add, lt_real *c, int64_t ldc, int64_t c_step, const lt_epilogue *e);

#ifdef __cplusplus
}
#endif
#endif
