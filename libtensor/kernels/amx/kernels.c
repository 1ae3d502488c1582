/* SPDX-License-Identifier: Apache-2.0 */
/* What AMX's tiles do better than AVX-512: long sums. */
#include "libtensor/kernels/amx/tiles.h"
#include "libtensor/kernels/isa.h"

#include "libtensor/kernels/body/math.inc"
#include "libtensor/kernels/amx/attention.inc"
#include "libtensor/kernels/amx/attention_grad.inc"
#include "libtensor/kernels/amx/product.inc"

void lt_kernels_add_amx(lt_kernels *k)
{
    add_attention(k);
    add_product(k);
    k->isa = LT_ISA_AMX;
}
