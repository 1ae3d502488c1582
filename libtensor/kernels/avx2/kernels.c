/* SPDX-License-Identifier: Apache-2.0 */
/* The shared bodies, compiled for AVX2: the compiler's vectors, and vec.h's in the products. */
#include "libtensor/kernels/avx2/vec.h"
#include "libtensor/kernels/isa.h"

#include "libtensor/kernels/body/all.inc"

void lt_kernels_add_avx2(lt_kernels *k)
{
    add_all(k);
    k->isa = LT_ISA_AVX2;
}
