/* SPDX-License-Identifier: Apache-2.0 */
/* The plain C table: complete, the reference for the others, and the whole of the double build. */
#include "libtensor/kernels/generic/vec.h"
#include "libtensor/kernels/isa.h"

#include "libtensor/kernels/body/all.inc"

void lt_kernels_add_generic(lt_kernels *k)
{
    *k = (lt_kernels){ 0 };
    add_all(k);
    k->isa = LT_ISA_GENERIC;
}
