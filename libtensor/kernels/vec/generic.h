/* SPDX-License-Identifier: Apache-2.0 */
/* A vector of one element: what the tiles of plain C are made of. */
#ifndef LT_KERNELS_VEC_GENERIC_H
#define LT_KERNELS_VEC_GENERIC_H

#include "libtensor/kernels/vec/unit.h"

#define ISA(name) lt_generic_##name

typedef lt_real vec;
typedef int32_t ivec;

enum { VL = 1, TILE_ROWS = 4, TILE_VECS = 4, PARTS_ARE_FREE = false };
#define TILE_LIST(X) ROWS4(X, 1) ROWS4(X, 4)

INLINE vec v_zero(void) { return 0; }
INLINE vec v_set(lt_real x) { return x; }
INLINE vec v_load(const lt_real *p) { return *p; }
INLINE void v_store(lt_real *p, vec v) { *p = v; }
INLINE vec v_fma(vec a, vec b, vec c) { return FMA(a, b, c); }

/* sum + w x[at], but where at is below 0 */
INLINE vec v_fma_at(vec w, const lt_real *x, const int32_t *at, vec sum) { return *at < 0 ? sum : FMA(w, x[*at], sum); }

/* The same where at is below 32 */
INLINE vec v_fma_among(vec w, const lt_real *x, const int32_t *at, vec sum) { return v_fma_at(w, x, at, sum); }

/* DL doubles, of as many elements */
typedef double dvec;
enum { DL = 1 };

INLINE dvec d_set(double x) { return x; }
INLINE dvec d_load(const double *p) { return *p; }
INLINE dvec d_widen(const lt_real *p) { return (double)*p; }
INLINE void d_store(double *p, dvec v) { *p = v; }

INLINE vec v_keep(vec v) { return v; }
INLINE vec v_relu(vec x) { return x < 0 ? 0 : x; }
INLINE vec v_leaky_relu(vec x, lt_real slope) { return x < 0 ? slope * x : x; }

/* Lanes [lo, hi) alone; the others are zero when loaded and left alone when stored. */
INLINE vec v_load_part(const lt_real *p, int lo, int hi) { return lo <= 0 && hi > 0 ? *p : 0; }
INLINE void v_store_part(lt_real *p, vec v, int hi)
{
    if (hi > 0)
        *p = v;
}

/* p[0], p[2], p[4] ...: those of the places lo <= i < hi, zero for the others */
INLINE vec v_load_even(const lt_real *p, int lo, int hi) { return v_load_part(p, lo, hi); }

/* a[0], b[0], a[1], b[1] ... */
INLINE void v_zip(vec out[2], vec a, vec b) { out[0] = a, out[1] = b; }

INLINE void v_fma_even(lt_real *p, vec s, vec x, int n) { *p = n ? v_fma(s, x, *p) : *p; }

/* out[j]: p[j], p[4 + j], p[8 + j] ..., and back */
INLINE void v_load4(vec out[4], const lt_real *p)
{
    for (int j = 0; j < 4; j++)
        out[j] = p[j];
}

INLINE void v_store4(lt_real *p, const vec x[4])
{
    for (int j = 0; j < 4; j++)
        p[j] = x[j];
}

/* p[3 * i + a] = x[a][i], i < n */
INLINE void v_store3(lt_real *p, const vec x[3], int n)
{
    for (int a = 0; n && a < 3; a++)
        p[a] = x[a];
}

/* out[j * row + i] = x[i * col + j] for i < lanes, j < VL */
INLINE void v_transpose(lt_real *out, int64_t row, const lt_real *x, int64_t col, int lanes)
{
    (void)row, (void)col, (void)lanes;
    *out = *x;
}

INLINE vec v_max(vec a, vec b) { return a > b ? a : b; }        /* b where one is NaN */
INLINE vec v_min(vec a, vec b) { return a < b ? a : b; }        /* likewise */
INLINE vec v_abs(vec x) { return FABS(x); }

/* Of two numbers, without a branch; b where one is NaN */
INLINE lt_real s_max(lt_real a, lt_real b) { return a > b ? a : b; }
INLINE lt_real s_min(lt_real a, lt_real b) { return a < b ? a : b; }

INLINE vec v_copysign(vec size, vec sign) { return COPYSIGN(size, sign); }
INLINE vec v_where_less(vec a, vec b, vec yes, vec no) { return a < b ? yes : no; }
INLINE unsigned v_at_most(vec a, vec b) { return a <= b; }     /* bit i: a[i] <= b[i] */

/* Which lanes: where a < b, in both, in any; and what a vector has there, 0 elsewhere */
typedef bool mvec;

INLINE mvec m_less(vec a, vec b) { return a < b; }
INLINE mvec m_both(mvec a, mvec b) { return a & b; }
INLINE bool m_any(mvec m) { return m; }
INLINE vec v_where(mvec m, vec yes, vec no) { return m ? yes : no; }
INLINE vec v_only(mvec m, vec v) { return m ? v : 0; }

/* Words in the lanes */
INLINE ivec i_set(int32_t x) { return x; }
INLINE ivec i_load(const uint32_t *p) { return (ivec)*p; }
INLINE ivec i_xor(ivec a, ivec b) { return a ^ b; }

/* The lower words of products of words without sign, and the upper ones */
INLINE ivec i_multiply(ivec a, uint32_t b, ivec *upper)
{
    const uint64_t product = (uint64_t)(uint32_t)a * b;

    *upper = (ivec)(product >> 32);
    return (ivec)product;
}

/* x where a word without sign is at least `least`, else 0 */
INLINE vec v_where_at_least(ivec word, uint32_t least, lt_real x) { return (uint32_t)word >= least ? x : 0; }

#ifndef LT_DOUBLE
/* Integers in the lanes: of the same bits, of the nearest, even where it stands between two, and back to floats */
INLINE ivec i_bits(vec v) { return (ivec)bits_of(v); }
INLINE vec v_bits(ivec i) { return of_bits((uint32_t)i); }
INLINE ivec i_near(vec x) { return (ivec)(bits_of(x + 12582912.0f) - 0x4b400000u); }   /* |x| < 2^22 */
INLINE vec v_of_int(ivec i) { return (float)i; }

/* The lowest bytes of four, the first one lowest */
INLINE ivec i_bytes(const ivec x[4])
{
    return (ivec)(((uint32_t)x[0] & 255) | ((uint32_t)x[1] & 255) << 8 | ((uint32_t)x[2] & 255) << 16
                  | (uint32_t)x[3] << 24);
}

/* sum + the four products of an unsigned and a signed byte */
INLINE ivec i_dot(ivec sum, ivec u, ivec s)
{
    for (int i = 0; i < 32; i += 8)
        sum = (ivec)((uint32_t)sum + (uint32_t)((int32_t)((uint32_t)u >> i & 255) * (int8_t)((uint32_t)s >> i & 255)));
    return sum;
}

/* 2^n, where shifted = n + 1.5 * 2^23: for -126 <= n <= 127; and x times it, for any n */
INLINE vec v_pow2(vec shifted) { return of_bits((bits_of(shifted) << 23) + 0x3f800000u); }

/* table[n], where shifted = n + 1.5 * 2^23 and 0 <= n < 8 */
INLINE vec v_of_eight(const float *table, vec shifted) { return table[bits_of(shifted) % 8]; }

/* 2^(n / 8), where shifted = n / 8 + 1.5 * 2^20 */
INLINE vec v_pow2_eighths(vec shifted)
{
    return of_bits((bits_of(shifted) << 20) + eighths[bits_of(shifted) % 8]);
}

INLINE vec v_times_pow2(vec x, vec shifted)         /* in two steps: 2^n itself may be subnormal */
{
    const int32_t n = (int32_t)(bits_of(shifted) - 0x4b400000u), half = n >> 1;

    return x * of_bits((uint32_t)(half + 127) << 23) * of_bits((uint32_t)(n - half + 127) << 23);
}
#endif
/* out += the sums of 32 numbers, for SUMMED rows: i and i + 16, and from there on in double by halves */
enum { SUMMED = 1 };

INLINE void v_add_sums32(double out[SUMMED], const vec x[SUMMED][32])
{
    double sum[16];

    for (int i = 0; i < 16; i++)
        sum[i] = (double)(x[0][i] + x[0][i + 16]);
    for (int half = 8; half > 0; half /= 2)
        for (int i = 0; i < half; i++)
            sum[i] += sum[i + half];
    out[0] += sum[0];
}

/* out[j], j < n = the sum of the 16 numbers in x[j], by halves: i and i + 8, then i + 4 ...; 0 from even n on. */
INLINE void v_sums16(lt_real out[16], const vec x[16][16], int n)
{
    for (int j = 0; j < n; j++) {
        lt_real sum[8];

        for (int i = 0; i < 8; i++)
            sum[i] = x[j][i] + x[j][i + 8];
        for (int half = 4; half > 0; half /= 2)
            for (int i = 0; i < half; i++)
                sum[i] += sum[i + half];
        out[j] = sum[0];
    }
    for (int j = n; j < 16; j++)
        out[j] = 0;
}

INLINE lt_real v_max_lanes(vec v) { return v; }

/* For maxima and their places: where v is larger than *best, or a NaN and *best is none, it takes over, and
 * so does its place. v_count: first, first + step ... */
INLINE ivec v_count(int32_t first, int step) { (void)step; return first; }
INLINE void v_store_count(int32_t *p, ivec v, int hi)
{
    if (hi > 0)
        *p = v;
}

INLINE void v_take_larger(vec *best, ivec *place, vec v, ivec at)
{
    const bool take = !(v <= *best) & (*best == *best);

    *best = take ? v : *best;
    *place = take ? at : *place;
}

#endif
