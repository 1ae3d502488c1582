/* SPDX-License-Identifier: Apache-2.0 */
/* Winograd's transforms. */
#include "libtensor/kernels/vec/vec.h"

#include "libtensor/kernels/vec/each.inc"
#include "libtensor/kernels/vec/turn.inc"
#include "libtensor/kernels/body/winograd.inc"
#include "libtensor/kernels/body/windows.inc"
#include "libtensor/kernels/body/winograd2.inc"
#include "libtensor/kernels/body/winograd_blocks.inc"
#include "libtensor/kernels/body/tall.inc"

void ISA(add_winograd)(lt_kernels *k)
{
    add_winograd(k);
    add_windows(k);
    add_winograd2(k);
    add_winograd_blocks(k);
    add_tall(k);
}
