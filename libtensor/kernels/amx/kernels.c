/* SPDX-License-Identifier: Apache-2.0 */
/* What AMX's tiles do better than AVX-512: long sums. */
#include "libtensor/kernels/amx/tiles.h"
#include "libtensor/kernels/isa.h"

#include "libtensor/kernels/vec/math.inc"
#include "libtensor/kernels/amx/attention.inc"
#include "libtensor/kernels/amx/attention_grad.inc"
#include "libtensor/kernels/amx/product.inc"

/* Narrow heads stay with AVX-512. */
static void add_attention(lt_kernels *k)
{
    k->attention[1] = (lt_attention_kernels){
        .packing = { PANELS * QUERIES, 0, attend_packed, attend_pack },
        .grad_packing = { GRAD_ROWS, GRAD_ROWS, attend_grad_packed, attend_grad_pack },
        .attend = attend, .attend_grad = attend_grad,
    };
}

void lt_kernels_add_amx(lt_kernels *k)
{
    add_attention(k);
    add_product(k);
    k->isa = LT_ISA_AMX;
}
