/* SPDX-License-Identifier: Apache-2.0 */
/* The vectors of the instruction set that a unit is compiled for, as Makefile.am has it. */
#ifndef LT_KERNELS_VEC_VEC_H
#define LT_KERNELS_VEC_VEC_H

#if defined(UNITS_FOR_AVX512)
#include "libtensor/kernels/vec/avx512.h"
#elif defined(UNITS_FOR_AVX2)
#include "libtensor/kernels/vec/avx2.h"
#else
#include "libtensor/kernels/vec/generic.h"
#endif

#include "libtensor/kernels/isa.h"

enum { NR = VL * TILE_VECS };           /* columns of a panel: nr in kernels.h */

#endif
