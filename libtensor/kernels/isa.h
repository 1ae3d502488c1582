/* SPDX-License-Identifier: Apache-2.0 */
/* What table.c fills tables with, for each instruction set: to overwrite the entries that it has. */
#ifndef LT_KERNELS_ISA_H
#define LT_KERNELS_ISA_H

#include "libtensor/kernels/kernels.h"

/* The units in body/, tile/ and splat/; and products of bytes for CPUs with VNNI, if the compiler knows it */
#define LT_UNITS(isa)                                                                               \
    void lt_##isa##_add_elements(lt_kernels *k);                                                    \
    void lt_##isa##_add_attention(lt_kernels *k);                                                   \
    void lt_##isa##_add_products(lt_kernels *k);                                                    \
    void lt_##isa##_add_bytes(lt_kernels *k);                                                       \
    void lt_##isa##_add_depthwise(lt_kernels *k);                                                   \
    void lt_##isa##_add_winograd(lt_kernels *k);                                                    \
    void lt_##isa##_add_splat(lt_kernels *k);                                                       \
    void lt_##isa##_add_vnni(lt_kernels *k);
LT_UNITS(generic)
LT_UNITS(avx2)
LT_UNITS(avx512)

/* amx/kernels.c */
void lt_kernels_add_amx(lt_kernels *k);

#endif
