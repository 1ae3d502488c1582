/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Products of floats on AMX, whose tiles multiply bfloat16s and add floats, 16 times as many at once as AVX-512.
 *
 * A float is the sum of three bfloat16s, exactly: the nearest one, the nearest one to what is left, and the rest. Of
 * the nine products of two such sums six are taken; the others are together at most 2^-23 of the whole. What comes out
 * is as near as a chain of multiply-adds, if not bit by bit the same; an infinity, whose rest is none, makes it NaN.
 *
 * A pause of the tiles, however short, costs half a microsecond (measured on an Intel server CPU), and other work does
 * not overlap with them: products are better few and long.
 *
 * Operands are packed in blocks of SIDE rows or columns and SIDE steps of the sum, as [part][half][16][16] pairs of
 * bfloat16s: step p of the sum in the lower half of a pair, p + 16 in the upper one.
 */
#ifndef LT_KERNELS_AMX_TILES_H
#define LT_KERNELS_AMX_TILES_H

#include "libtensor/kernels/vec/avx512.h"

#ifdef LT_DOUBLE
#error "tiles add floats"
#endif

enum { SIDE = 32, HALF = SIDE / 2, TILE = HALF * HALF, PART = 2 * TILE, PARTS = 3, BLOCK = PARTS * PART };

/* The tile registers' sizes, in the form of LDTILECFG: eight of 16 rows of 64 bytes */
typedef struct {
    uint8_t palette, start_row, unused[14];
    uint16_t row_bytes[16];
    uint8_t rows[16];
} tile_config;

/* Around whatever uses tiles */
INLINE void tiles_begin(void)
{
    static const tile_config config = {
        .palette = 1, .row_bytes = { 64, 64, 64, 64, 64, 64, 64, 64 },
        .rows = { HALF, HALF, HALF, HALF, HALF, HALF, HALF, HALF },
    };

    _tile_loadconfig(&config);
}

INLINE void tiles_end(void)
{
    _tile_release();
}

/* ---- packing ------------------------------------------------------------------------------------------ */

/* Each lane's nearest bfloat16, as a float. A NaN may become a number: its rest is NaN. */
INLINE vec v_bfloat(vec x)
{
    const ivec near = _mm512_add_epi32(i_bits(x), i_set(0x8000));

    return v_bits(_mm512_and_si512(near, i_set(-0x10000)));
}

/* The upper halves of lo and of hi, which belong in the lower and the upper halves of pairs */
INLINE vec pair(vec lo, vec hi)
{
    enum { SELECT = 0xca };                             /* where the first is set the second, else the third */

    return v_bits(_mm512_ternarylogic_epi32(i_set(-0x10000), i_bits(hi), _mm512_srli_epi32(i_bits(lo), 16), SELECT));
}

/* A row of 16 pairs, into each of the three parts, so far apart: lo in the lower halves, hi in the upper ones */
INLINE void split(lt_real *out, const int64_t apart, vec lo, vec hi)
{
    for (int part = 0; part < PARTS - 1; part++) {
        const vec near_lo = v_bfloat(lo), near_hi = v_bfloat(hi);

        v_store(out + part * apart, pair(near_lo, near_hi));
        lo -= near_lo, hi -= near_hi;
    }
    v_store(out + (PARTS - 1) * apart, pair(lo, hi));
}

/* One block of an operand whose rows are sums' rows or columns: x[i * ld + c] for i < rows, c < cols, else zeros */
INLINE void pack_rows(lt_real *block, const lt_real *x, int64_t ld, int rows, int cols, vec s)
{
    for (int i = 0; i < SIDE; i++) {
        const int lo = i < rows ? cols : 0;
        const lt_real *row = x + (i < rows ? i : 0) * ld;

        split(block + i * HALF, PART, s * v_load_part(row, 0, lo), s * v_load_part(row + HALF, 0, lo - HALF));
    }
}

/* The same, summed over rows: its columns are the other operand's */
INLINE void pack_summed(lt_real *block, const lt_real *x, int64_t ld, int rows, int cols, vec s)
{
    for (int i = 0; i < HALF; i++)
        for (int half = 0; half < 2; half++) {
            const lt_real *at = x + half * HALF;
            const int n = cols - half * HALF, low = i < rows ? i : 0, high = i + HALF < rows ? i + HALF : 0;

            split(block + half * TILE + i * HALF, PART, s * v_load_part(at + low * ld, 0, i < rows ? n : 0),
                  s * v_load_part(at + high * ld, 0, i + HALF < rows ? n : 0));
        }
}

/* From the operand on the left to the one on the right, or back */
INLINE void turn_block(lt_real *out, const lt_real *block)
{
    for (int tile = 0; tile < BLOCK; tile += TILE)
        v_transpose(out + tile, HALF, block + tile, HALF, HALF);
}

/* ---- products ----------------------------------------------------------------------------------------- */

#define TILES_LEFT(part) \
    do { \
        _tile_loadd(4, a + (part) * a_part, a_row * 4); \
        _tile_loadd(5, a + (part) * a_part + HALF * a_row, a_row * 4); \
    } while (0)
#define TILES_RIGHT(part) \
    do { \
        _tile_loadd(6, b + (part) * PART, 64); \
        _tile_loadd(7, b + (part) * PART + TILE, 64); \
    } while (0)
#define TILES_MULTIPLY() \
    do { \
        _tile_dpbf16ps(0, 4, 6); \
        _tile_dpbf16ps(1, 4, 7); \
        _tile_dpbf16ps(2, 5, 6); \
        _tile_dpbf16ps(3, 5, 7); \
    } while (0)

/* Parts of a, and its rows, are so far apart. */
INLINE void tiles_multiply(const lt_real *a, const int64_t a_part, const int64_t a_row, const lt_real *b)
{
    TILES_LEFT(0);
    TILES_RIGHT(2);
    TILES_MULTIPLY();
    TILES_RIGHT(1);
    TILES_MULTIPLY();
    TILES_LEFT(1);
    TILES_MULTIPLY();
    TILES_RIGHT(0);
    TILES_MULTIPLY();
    TILES_LEFT(2);
    TILES_MULTIPLY();
    TILES_LEFT(0);
    TILES_MULTIPLY();
}

/* The same with left and right in each other's place: the transpose, bit by bit */
INLINE void tiles_multiply_mirrored(const lt_real *a, const lt_real *b)
{
    enum { a_part = PART, a_row = HALF };

    TILES_RIGHT(0);
    TILES_LEFT(2);
    TILES_MULTIPLY();
    TILES_LEFT(1);
    TILES_MULTIPLY();
    TILES_RIGHT(1);
    TILES_MULTIPLY();
    TILES_LEFT(0);
    TILES_MULTIPLY();
    TILES_RIGHT(2);
    TILES_MULTIPLY();
    TILES_RIGHT(0);
    TILES_MULTIPLY();
}

/* c[SIDE][SIDE] = the products of n blocks of a and of b, so many elements apart */
INLINE void tiles_product(lt_real (*c)[SIDE], const lt_real *a, int64_t a_step, const lt_real *b, int64_t b_step,
                          int64_t n, const bool mirrored)
{
    __asm__ volatile("" ::: "memory");                  /* tiles are loaded behind the compiler's back */
    _tile_zero(0);
    _tile_zero(1);
    _tile_zero(2);
    _tile_zero(3);
    for (int64_t i = 0; i < n; i++)
        if (mirrored)
            tiles_multiply_mirrored(a + i * a_step, b + i * b_step);
        else
            tiles_multiply(a + i * a_step, PART, HALF, b + i * b_step);
    _tile_stored(0, c[0], sizeof(*c));
    _tile_stored(1, c[0] + HALF, sizeof(*c));
    _tile_stored(2, c[HALF], sizeof(*c));
    _tile_stored(3, c[HALF] + HALF, sizeof(*c));
    __asm__ volatile("" ::: "memory");
}

#endif
