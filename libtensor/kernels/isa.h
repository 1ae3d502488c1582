/* SPDX-License-Identifier: Apache-2.0 */
/* What each instruction set's folder offers to table.c: to overwrite the entries that it has. */
#ifndef LT_KERNELS_ISA_H
#define LT_KERNELS_ISA_H

#include "libtensor/kernels/kernels.h"

void lt_kernels_add_generic(lt_kernels *k);
void lt_kernels_add_avx2(lt_kernels *k);
void lt_kernels_add_avx512(lt_kernels *k);
void lt_kernels_add_amx(lt_kernels *k);

/* lt_kernels_add_avx2_exact, lt_kernels_add_avx512_exact - their products of bytes without VNNI */
void lt_kernels_add_avx2_exact(lt_kernels *k);
void lt_kernels_add_avx512_exact(lt_kernels *k);

#endif
