/* SPDX-License-Identifier: Apache-2.0 */
/* Products of matrices, and of maps that convolutions pack or read as they lie. */
#include "libtensor/kernels/vec/vec.h"

#include "libtensor/kernels/vec/math.inc"
#include "libtensor/kernels/vec/each.inc"
#include "libtensor/kernels/vec/epilogue.inc"
#include "libtensor/kernels/vec/turn.inc"
#include "libtensor/kernels/tile/tile.inc"
#include "libtensor/kernels/tile/gemm.inc"
#include "libtensor/kernels/tile/blocks.inc"
#include "libtensor/kernels/tile/image.inc"
#include "libtensor/kernels/tile/weights.inc"

void ISA(add_products)(lt_kernels *k)
{
    add_gemm(k);
    add_blocks(k);
    add_image(k);
    add_weights(k);
}
