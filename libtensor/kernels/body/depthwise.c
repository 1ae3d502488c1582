/* SPDX-License-Identifier: Apache-2.0 */
/* Depthwise convolutions and their gradients. */
#include "libtensor/kernels/vec/vec.h"

#include "libtensor/kernels/vec/math.inc"
#include "libtensor/kernels/vec/each.inc"
#include "libtensor/kernels/vec/epilogue.inc"
#include "libtensor/kernels/vec/sum.inc"
#include "libtensor/kernels/body/depthwise_lanes.inc"
#include "libtensor/kernels/body/depthwise.inc"
#include "libtensor/kernels/body/depthwise_gradients.inc"
#include "libtensor/kernels/body/blocks_finish.inc"
#include "libtensor/kernels/body/depthwise_blocks.inc"

void ISA(add_depthwise)(lt_kernels *k)
{
    add_depthwise(k);
    add_depthwise_gradients(k);
    add_blocks_finish(k);
    add_depthwise_blocks(k);
}
