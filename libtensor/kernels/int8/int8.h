/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Convolutions and products with weights whose inputs are read as 8-bit integers. Weights become integers from -127
 * to 127 with a scale for each output channel. Sums are exact, so results have the same bits on any instruction set
 * and number of threads. Not in the double build, where nothing suits.
 *
 * A NaN in the input is the least integer: these find no NaN.
 */
#ifndef LT_KERNELS_INT8_INT8_H
#define LT_KERNELS_INT8_INT8_H

#include "libtensor/kernels/conv/conv.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * lt_conv2d_int8_suits   - one group, enough channels for four in a word, sums that fit 32 bits
 * lt_conv2d_int8_pack    - weights as integers, in the order in which forward reads them, and their scales times r's
 * lt_conv2d_int8_forward - y = act(scale * the sum of integers + bias + residual); x times its gate is what is rounded
 *
 * packed has lt_conv2d_int8_packed(p) elements and serves the instruction set in use when it was made; work are
 * lt_conv2d_int8_pack_work(p) and lt_conv2d_int8_work(p) bytes, aligned to LT_ALIGN, contents indifferent. around
 * makes no mean, and its residual is not y.
 */
LT_API bool lt_conv2d_int8_suits(const lt_conv2d_params *p);
LT_API int64_t lt_conv2d_int8_packed(const lt_conv2d_params *p);
LT_API size_t lt_conv2d_int8_pack_work(const lt_conv2d_params *p);
LT_API void lt_conv2d_int8_pack(const lt_conv2d_params *p, const lt_int8_range *r, const lt_real *weights,
                                lt_real *packed, void *work);
LT_API size_t lt_conv2d_int8_work(const lt_conv2d_params *p);
LT_API void lt_conv2d_int8_forward(const lt_conv2d_params *p, const lt_int8_range *r, const lt_real *x,
                                   const lt_real *packed, const lt_conv2d_around *around, lt_real *y, void *work);

/**
 * lt_conv2d_int8_forward_rect - the same for one image, and only for the positions of y that rect has
 *
 * As lt_conv2d_forward_rect; strides of 1. The same bits as lt_conv2d_int8_forward.
 */
LT_API bool lt_conv2d_int8_takes_rect(const lt_conv2d_params *p);
LT_API size_t lt_conv2d_int8_rect_work(const lt_conv2d_params *p);
LT_API void lt_conv2d_int8_forward_rect(const lt_conv2d_params *p, const lt_int8_range *r, lt_rect rect,
                                        const lt_real *x, const lt_real *packed, const lt_real *bias,
                                        const lt_real *residual, lt_act act, lt_real *y, void *work);

/**
 * lt_gemm_int8 - C (m, n) = scale[j] * the sum of integers of A (m, k) and W (n, k), and then what e says
 *
 * All are stored by rows without gaps. The rest as above, with what lt_gemm_int8_pack made of W.
 */
LT_API bool lt_gemm_int8_suits(int64_t n, int64_t k);
LT_API int64_t lt_gemm_int8_packed(int64_t n, int64_t k);
LT_API size_t lt_gemm_int8_pack_work(int64_t n, int64_t k);
LT_API void lt_gemm_int8_pack(int64_t n, int64_t k, const lt_int8_range *r, const lt_real *weights, lt_real *packed,
                              void *work);
LT_API size_t lt_gemm_int8_work(int64_t m, int64_t k);
LT_API void lt_gemm_int8(int64_t m, int64_t n, int64_t k, const lt_int8_range *r, const lt_real *a,
                         const lt_real *packed, const lt_epilogue *e, lt_real *c, void *work);

#ifdef __cplusplus
}
#endif
#endif
