/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Maps in blocks of channels (kernels.h: LT_BLOCK): brought there and back, and their means.
 */
#ifndef LT_KERNELS_BLOCKS_BLOCKS_H
#define LT_KERNELS_BLOCKS_BLOCKS_H

#include "libtensor/kernels/kernels.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lt_blocks_of - how many blocks c channels make */
static inline int64_t lt_blocks_of(int64_t c) { return lt_ceil_div(c, LT_BLOCK); }

/**
 * lt_blocks_from_maps - (n, c, positions) to (n, blocks, positions, LT_BLOCK); zeros behind the last channel
 * lt_blocks_to_maps   - and back
 * lt_blocks_mean      - mean (n, c) of each channel over the positions of x in blocks, summed in double one by one
 */
LT_API void lt_blocks_from_maps(lt_real *y, const lt_real *x, int64_t n, int64_t c, int64_t positions);
LT_API void lt_blocks_to_maps(lt_real *y, const lt_real *x, int64_t n, int64_t c, int64_t positions);
LT_API void lt_blocks_mean(lt_real *mean, const lt_real *x, int64_t n, int64_t c, int64_t positions);

#ifdef __cplusplus
}
#endif
#endif
