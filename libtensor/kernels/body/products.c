/* SPDX-License-Identifier: Apache-2.0 */
/* Products of matrices, and of maps that convolutions pack or read as they lie. */
#include "libtensor/kernels/vec/vec.h"

#include "libtensor/kernels/body/math.inc"
#include "libtensor/kernels/body/each.inc"
#include "libtensor/kernels/body/epilogue.inc"
#include "libtensor/kernels/body/turn.inc"
#include "libtensor/kernels/body/tile.inc"
#include "libtensor/kernels/body/gemm.inc"
#include "libtensor/kernels/body/blocks.inc"
#include "libtensor/kernels/body/image.inc"
#include "libtensor/kernels/body/weights.inc"

void ISA(add_products)(lt_kernels *k)
{
    add_gemm(k);
    add_blocks(k);
    add_image(k);
    add_weights(k);
}
