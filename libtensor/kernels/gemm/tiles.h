/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Products of dense rows on AMX's tiles, faster than lt_gemm's multiply-adds where there is enough to do: what linear
 * layers and the hand layer ask for. Each element is within 1e-6 of the sum of its terms' sizes from the exact one, and
 * NaN where a factor is infinite. Cut by the sizes alone: the same bits on any number of threads.
 */
#ifndef LT_KERNELS_GEMM_TILES_H
#define LT_KERNELS_GEMM_TILES_H

#include "libtensor/kernels/gemm/gemm.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lt_gemm_tiles_suits - whether this CPU has tiles, and C (m, n) with sums of k terms is better made by them */
LT_API bool lt_gemm_tiles_suits(int64_t m, int64_t n, int64_t k);

/**
 * lt_gemm_tiles_pack - op(B) (k, n) in the order in which lt_gemm_tiles reads it: lt_gemm_tiles_packed(n, k) elements
 * lt_gemm_tiles      - C (m, n) = or += A (m, k) B, and then what e says, or NULL; lda, ldc: as of lt_gemm
 */
LT_API int64_t lt_gemm_tiles_packed(int64_t n, int64_t k);
LT_API void lt_gemm_tiles_pack(lt_trans tb, int64_t n, int64_t k, const lt_real *b, int64_t ldb, lt_real *packed);
LT_API void lt_gemm_tiles(int64_t m, int64_t n, int64_t k, const lt_real *a, int64_t lda, const lt_real *packed,
                          bool add, lt_real *c, int64_t ldc, const lt_epilogue *e);

/**
 * lt_gemm_tiles_pair - C (m, n) = op2(op1(A B1) B2), op(X) = epilogue(X B): the same bits as lt_gemm_tiles twice
 *
 *   A (m, k)   packed1 of B1 (k, hidden)   packed2 of B2 (hidden, n)
 *
 * What lies between is only there some rows and columns at a time, in the cache of the thread that makes and reads it.
 * e1 has neither residual nor row_bias. lt_gemm_tiles_pair_suits: both products suit, and fit into a thread's scratch.
 */
LT_API bool lt_gemm_tiles_pair_suits(int64_t m, int64_t k, int64_t hidden, int64_t n);
LT_API void lt_gemm_tiles_pair(int64_t m, int64_t k, const lt_real *a, int64_t hidden, const lt_real *packed1,
                               const lt_epilogue *e1, int64_t n, const lt_real *packed2, const lt_epilogue *e2,
                               lt_real *c);

/**
 * lt_gemm_tiles_sums - C (m, n) = or += A^T B: sums over k rows, of A (k, m) and of B (k, n)
 *
 * work is lt_gemm_tiles_sums_work(m, n, k) bytes, aligned to LT_ALIGN, contents indifferent.
 */
LT_API size_t lt_gemm_tiles_sums_work(int64_t m, int64_t n, int64_t k);
LT_API void lt_gemm_tiles_sums(int64_t m, int64_t n, int64_t k, const lt_real *a, const lt_real *b, bool add,
                               lt_real *c, void *work);

#ifdef __cplusplus
}
#endif
#endif
