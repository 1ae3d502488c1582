/* SPDX-License-Identifier: Apache-2.0 */
/* Products of 8-bit integers, on VNNI as well where vec.h has it: not every CPU of the instruction set does. */
#include "libtensor/kernels/vec/vec.h"

#ifndef LT_DOUBLE
#include "libtensor/kernels/vec/math.inc"
#include "libtensor/kernels/vec/each.inc"
#include "libtensor/kernels/vec/epilogue.inc"
#include "libtensor/kernels/tile/tile.inc"
#include "libtensor/kernels/tile/bytes.inc"

#define TILE(name) exact_##name
#define TILE_TARGET
#define DOT(sum, u, s) i_dot(sum, u, s)
#include "libtensor/kernels/tile/bytes_tile.inc"

#ifdef VNNI_DOT
#define TILE(name) vnni_##name
#define TILE_TARGET VNNI_TARGET
#define DOT(sum, u, s) VNNI_DOT(sum, u, s)
#include "libtensor/kernels/tile/bytes_tile.inc"
#endif
#endif

void ISA(add_bytes)(lt_kernels *k)
{
    (void)k;
#ifndef LT_DOUBLE
    add_bytes(k);
    exact_add(k);
#endif
}

void ISA(add_vnni)(lt_kernels *k)
{
    (void)k;
#ifdef VNNI_DOT
    vnni_add(k);
#endif
}
