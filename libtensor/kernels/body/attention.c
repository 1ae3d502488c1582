/* SPDX-License-Identifier: Apache-2.0 */
/* Attention and its gradients. */
#include "libtensor/kernels/vec/vec.h"

#include "libtensor/kernels/vec/math.inc"
#include "libtensor/kernels/vec/each.inc"
#include "libtensor/kernels/body/attention.inc"

void ISA(add_attention)(lt_kernels *k)
{
    add_attention(k);
}
