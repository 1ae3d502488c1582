/* SPDX-License-Identifier: Apache-2.0 */
/* The shared bodies, compiled for AVX-512: the compiler's vectors, and vec.h's in the products. */
#include "libtensor/kernels/avx512/vec.h"
#include "libtensor/kernels/isa.h"

#include "libtensor/kernels/body/all.inc"

/* And products of bytes where the CPU has VNNI, which not all with AVX-512 have. */
#define BYTES(name) vnni_##name
#define BYTES_TARGET __attribute__((target("avx512vnni")))
#define DOT(sum, u, s) _mm512_dpbusd_epi32(sum, u, s)
#include "libtensor/kernels/body/bytes_tile.inc"

void lt_kernels_add_avx512(lt_kernels *k)
{
    add_all(k);
    k->isa = LT_ISA_AVX512;
    if (lt_cpu_has_vnni(LT_ISA_AVX512))
        vnni_add(k);
}

void lt_kernels_add_avx512_exact(lt_kernels *k)
{
    bytes_add(k);
}
