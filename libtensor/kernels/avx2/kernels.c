/* SPDX-License-Identifier: Apache-2.0 */
/* The shared bodies, compiled for AVX2: the compiler's vectors, and vec.h's in the products. */
#include "libtensor/kernels/avx2/vec.h"
#include "libtensor/kernels/isa.h"

#include "libtensor/kernels/body/all.inc"

/* And products of bytes where the CPU has VNNI in 256 bits and the compiler knows it. */
#if defined(__clang__) ? __clang_major__ >= 12 : __GNUC__ >= 11
#define BYTES(name) vnni_##name
#define BYTES_TARGET __attribute__((target("avxvnni")))
#define DOT(sum, u, s) _mm256_dpbusd_avx_epi32(sum, u, s)
#include "libtensor/kernels/body/bytes_tile.inc"
#else
static void vnni_add(lt_kernels *k)
{
    bytes_add(k);
}
#endif

void lt_kernels_add_avx2(lt_kernels *k)
{
    add_all(k);
    k->isa = LT_ISA_AVX2;
    if (lt_cpu_has_vnni(LT_ISA_AVX2))
        vnni_add(k);
}

void lt_kernels_add_avx2_exact(lt_kernels *k)
{
    bytes_add(k);
}
