/* SPDX-License-Identifier: Apache-2.0 */
/* A vector of 16 floats, and a tile of 14 x 2 of them: 28 of the 32 registers. */
#ifndef LT_KERNELS_VEC_AVX512_H
#define LT_KERNELS_VEC_AVX512_H

#include "libtensor/kernels/vec/unit.h"

#include <immintrin.h>

#define ISA(name) lt_avx512_##name

typedef __m512 vec;
typedef __m512i ivec;

/* PARTS_ARE_FREE: to load or store some lanes takes no longer than all of them. */
enum { VL = 16, TILE_ROWS = 14, TILE_VECS = 2, PARTS_ARE_FREE = true };
#define TILE_LIST(X) ROWS14(X, 1) ROWS14(X, 2)

INLINE vec v_zero(void) { return _mm512_setzero_ps(); }
INLINE vec v_set(float x) { return _mm512_set1_ps(x); }
INLINE vec v_load(const float *p) { return _mm512_loadu_ps(p); }
INLINE void v_store(float *p, vec v) { _mm512_storeu_ps(p, v); }
INLINE vec v_fma(vec a, vec b, vec c) { return _mm512_fmadd_ps(a, b, c); }

/* sum + w x[at], but where at is below 0 */
INLINE vec v_fma_at(vec w, const float *x, const int32_t *at, vec sum)
{
    const __m512i place = _mm512_loadu_si512(at);
    const __mmask16 there = _knot_mask16(_mm512_movepi32_mask(place));

    return _mm512_mask3_fmadd_ps(w, _mm512_mask_i32gather_ps(_mm512_setzero_ps(), there, place, x, 4), sum, there);
}

/* The same where at is below 32 */
INLINE vec v_fma_among(vec w, const float *x, const int32_t *at, vec sum)
{
    const __m512i place = _mm512_loadu_si512(at);
    const __mmask16 there = _knot_mask16(_mm512_movepi32_mask(place));

    return _mm512_mask3_fmadd_ps(w, _mm512_permutex2var_ps(v_load(x), place, v_load(x + 16)), sum, there);
}


/* Integers in the lanes: of the same bits, of the nearest, even where it stands between two, and back to floats */
INLINE ivec i_bits(vec v) { return _mm512_castps_si512(v); }
INLINE vec v_bits(ivec i) { return _mm512_castsi512_ps(i); }
INLINE ivec i_near(vec x) { return _mm512_cvtps_epi32(x); }
INLINE vec v_of_int(ivec i) { return _mm512_cvtepi32_ps(i); }
INLINE ivec i_set(int32_t x) { return _mm512_set1_epi32(x); }
INLINE ivec i_load(const uint32_t *p) { return _mm512_loadu_si512(p); }
INLINE ivec i_xor(ivec a, ivec b) { return _mm512_xor_si512(a, b); }

/* The lower words of products of words without sign, and the upper ones. By shuffles, as the port of the products is
 * that of shifts, too. */
INLINE ivec i_multiply(ivec a, uint32_t b, ivec *upper)
{
    const ivec factor = i_set((int32_t)b), even = _mm512_mul_epu32(a, factor);
    const ivec odd = _mm512_mul_epu32(_mm512_shuffle_epi32(a, _MM_PERM_DDBB), factor);

    *upper = _mm512_mask_shuffle_epi32(odd, 0x5555, even, _MM_PERM_DDBB);
    return _mm512_mask_shuffle_epi32(even, 0xaaaa, odd, _MM_PERM_CCAA);
}

/* x where a word without sign is at least `least`, else 0 */
INLINE vec v_where_at_least(ivec word, uint32_t least, float x)
{
    return _mm512_maskz_mov_ps(_mm512_cmpge_epu32_mask(word, i_set((int32_t)least)), v_set(x));
}

/* The lowest bytes of four, the first one lowest */
INLINE ivec i_bytes(const ivec x[4])
{
    const ivec byte = _mm512_set1_epi32(255);
    const ivec lo = _mm512_or_si512(_mm512_and_si512(x[0], byte), _mm512_slli_epi32(_mm512_and_si512(x[1], byte), 8));

    return _mm512_or_si512(lo, _mm512_or_si512(_mm512_slli_epi32(_mm512_and_si512(x[2], byte), 16),
                                               _mm512_slli_epi32(x[3], 24)));
}

/* sum + the four products of an unsigned and a signed byte, without VNNI. By 16 bits, for products of bytes that are
 * added in 16 bits (vpmaddubsw) are cut off. */
INLINE ivec i_dot(ivec sum, ivec u, ivec s)
{
    const ivec even = _mm512_madd_epi16(_mm512_and_si512(u, _mm512_set1_epi16(255)),
                                        _mm512_srai_epi16(_mm512_slli_epi16(s, 8), 8));
    const ivec odd = _mm512_madd_epi16(_mm512_srli_epi16(u, 8), _mm512_srai_epi16(s, 8));

    return _mm512_add_epi32(_mm512_add_epi32(sum, even), odd);
}

/* The same with VNNI, of which the compiler must be told */
#define VNNI_TARGET __attribute__((target("avx512vnni")))
#define VNNI_DOT(sum, u, s) _mm512_dpbusd_epi32(sum, u, s)

/* DL doubles, of as many elements */
typedef __m512d dvec;
enum { DL = 8 };

INLINE dvec d_set(double x) { return _mm512_set1_pd(x); }
INLINE dvec d_load(const double *p) { return _mm512_loadu_pd(p); }
INLINE dvec d_widen(const float *p) { return _mm512_cvtps_pd(_mm256_loadu_ps(p)); }
INLINE void d_store(double *p, dvec v) { _mm512_storeu_pd(p, v); }

/* v in a register: the compiler would load it again for each of its uses */
INLINE vec v_keep(vec v)
{
    __asm__("" : "+v"(v));
    return v;
}

INLINE vec v_relu(vec x) { return _mm512_max_ps(_mm512_setzero_ps(), x); }
INLINE vec v_leaky_relu(vec x, float slope)
{
    return _mm512_mask_mul_ps(x, _mm512_cmp_ps_mask(x, v_zero(), _CMP_LT_OQ), x, v_set(slope));
}

INLINE __mmask16 first_lanes(int n)         /* any n */
{
    const unsigned clipped = (unsigned)(n < 0 ? 0 : n > VL ? VL : n);

    return (__mmask16)((1u << clipped) - 1);
}

INLINE vec v_load_part(const float *p, int lo, int hi)
{
    return _mm512_maskz_loadu_ps((__mmask16)(first_lanes(hi) & ~first_lanes(lo)), p);
}

INLINE void v_store_part(float *p, vec v, int hi)
{
    _mm512_mask_storeu_ps(p, first_lanes(hi), v);
}

/* p[0], p[2], p[4] ...: those of the places lo <= i < hi, zero for the others */
INLINE vec v_load_even(const float *p, int lo, int hi)
{
    const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);

    return _mm512_permutex2var_ps(v_load_part(p, lo, hi), even,
                                  v_load_part(p + VL, lo - VL, hi - VL));
}

/* a[0], b[0], a[1], b[1] ... */
INLINE void v_zip(vec out[2], vec a, vec b)
{
    const __m512i lo = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);

    out[0] = _mm512_permutex2var_ps(a, lo, b);
    out[1] = _mm512_permutex2var_ps(a, _mm512_add_epi32(lo, _mm512_set1_epi32(VL / 2)), b);
}

/* p[2 i] = fma(s, x[i], p[2 i]) for i < n, at most VL */
INLINE void v_fma_even(float *p, vec s, vec x, int n)
{
    const __m512i twice = _mm512_setr_epi32(0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7);
    const vec lo = _mm512_permutexvar_ps(twice, x);
    const vec hi = _mm512_permutexvar_ps(_mm512_add_epi32(twice, _mm512_set1_epi32(VL / 2)), x);

    const __mmask16 even = 0x5555 & first_lanes(2 * n), even_hi = 0x5555 & first_lanes(2 * n - VL);

    _mm512_mask_storeu_ps(p, even, v_fma(s, lo, _mm512_maskz_loadu_ps(even, p)));
    _mm512_mask_storeu_ps(p + VL, even_hi, v_fma(s, hi, _mm512_maskz_loadu_ps(even_hi, p + VL)));
}

/* out[j]: p[j], p[4 + j], p[8 + j] ..., and back */
INLINE void v_load4(vec out[4], const float *p)
{
    const __m512i first = _mm512_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28, 1, 5, 9, 13, 17, 21, 25, 29);
    const __m512i second = _mm512_add_epi32(first, _mm512_set1_epi32(2));
    const vec a = _mm512_loadu_ps(p), b = _mm512_loadu_ps(p + VL);
    const vec c = _mm512_loadu_ps(p + 2 * VL), d = _mm512_loadu_ps(p + 3 * VL);
    const vec lo = _mm512_permutex2var_ps(a, first, b), hi = _mm512_permutex2var_ps(c, first, d);
    const vec lo2 = _mm512_permutex2var_ps(a, second, b), hi2 = _mm512_permutex2var_ps(c, second, d);

    out[0] = _mm512_shuffle_f32x4(lo, hi, 0x44);
    out[1] = _mm512_shuffle_f32x4(lo, hi, 0xee);
    out[2] = _mm512_shuffle_f32x4(lo2, hi2, 0x44);
    out[3] = _mm512_shuffle_f32x4(lo2, hi2, 0xee);
}

INLINE void v_store4(float *p, const vec x[4])
{
    const __m512i first = _mm512_setr_epi32(0, 16, 8, 24, 1, 17, 9, 25, 2, 18, 10, 26, 3, 19, 11, 27);
    const __m512i second = _mm512_add_epi32(first, _mm512_set1_epi32(4));
    const vec lo = _mm512_shuffle_f32x4(x[0], x[2], 0x44), hi = _mm512_shuffle_f32x4(x[0], x[2], 0xee);
    const vec lo2 = _mm512_shuffle_f32x4(x[1], x[3], 0x44), hi2 = _mm512_shuffle_f32x4(x[1], x[3], 0xee);

    _mm512_storeu_ps(p, _mm512_permutex2var_ps(lo, first, lo2));
    _mm512_storeu_ps(p + VL, _mm512_permutex2var_ps(lo, second, lo2));
    _mm512_storeu_ps(p + 2 * VL, _mm512_permutex2var_ps(hi, first, hi2));
    _mm512_storeu_ps(p + 3 * VL, _mm512_permutex2var_ps(hi, second, hi2));
}

/* p[3 * i + a] = x[a][i], i < n */
INLINE void v_store3(float *p, const vec x[3], int n)
{
    static const int32_t two[3][16] = {         /* x[0], x[1] at 16; x[2]'s places are filled by three */
        { 0, 16, 0, 1, 17, 0, 2, 18, 0, 3, 19, 0, 4, 20, 0, 5 },
        { 21, 0, 6, 22, 0, 7, 23, 0, 8, 24, 0, 9, 25, 0, 10, 26 },
        { 0, 11, 27, 0, 12, 28, 0, 13, 29, 0, 14, 30, 0, 15, 31, 0 },
    };
    static const int32_t three[3][16] = {       /* what two made, x[2] at 16 */
        { 0, 1, 16, 3, 4, 17, 6, 7, 18, 9, 10, 19, 12, 13, 20, 15 },
        { 0, 21, 2, 3, 22, 5, 6, 23, 8, 9, 24, 11, 12, 25, 14, 15 },
        { 26, 1, 2, 27, 4, 5, 28, 7, 8, 29, 10, 11, 30, 13, 14, 31 },
    };

    for (int i = 0; i < 3; i++) {
        const vec pairs = _mm512_permutex2var_ps(x[0], _mm512_loadu_si512(two[i]), x[1]);

        v_store_part(p + 16 * i, _mm512_permutex2var_ps(pairs, _mm512_loadu_si512(three[i]), x[2]), 3 * n - 16 * i);
    }
}

/* out[j * row + i] = x[i * col + j] for i < lanes, j < VL. Pairs, then fours of rows within each 128
 * bits; then the 128-bit parts change places. */
INLINE void v_transpose(float *out, int64_t row, const float *x, int64_t col, int lanes)
{
    const __mmask16 keep = first_lanes(lanes);
    vec a[VL], b[VL];

#pragma GCC unroll 16
    for (int i = 0; i < VL; i++) {
        a[i] = _mm512_loadu_ps(x);
        x += i + 1 < lanes ? col : 0;
    }
#pragma GCC unroll 16
    for (int i = 0; i < VL; i += 2) {
        b[i] = _mm512_unpacklo_ps(a[i], a[i + 1]);
        b[i + 1] = _mm512_unpackhi_ps(a[i], a[i + 1]);
    }
#pragma GCC unroll 16
    for (int i = 0; i < VL; i += 4)
#pragma GCC unroll 2
        for (int h = 0; h < 2; h++) {
            const __m512d lo = _mm512_castps_pd(b[i + h]), hi = _mm512_castps_pd(b[i + h + 2]);

            a[i + 2 * h] = _mm512_castpd_ps(_mm512_unpacklo_pd(lo, hi));
            a[i + 2 * h + 1] = _mm512_castpd_ps(_mm512_unpackhi_pd(lo, hi));
        }
#pragma GCC unroll 16
    for (int c = 0; c < 4; c++) {           /* a[4 r + c]: column c of rows 4 r .. in each part */
        const vec p = _mm512_shuffle_f32x4(a[c], a[4 + c], 0x88);
        const vec q = _mm512_shuffle_f32x4(a[c], a[4 + c], 0xdd);
        const vec r = _mm512_shuffle_f32x4(a[8 + c], a[12 + c], 0x88);
        const vec s = _mm512_shuffle_f32x4(a[8 + c], a[12 + c], 0xdd);

        _mm512_mask_storeu_ps(out + c * row, keep, _mm512_shuffle_f32x4(p, r, 0x88));
        _mm512_mask_storeu_ps(out + (4 + c) * row, keep, _mm512_shuffle_f32x4(q, s, 0x88));
        _mm512_mask_storeu_ps(out + (8 + c) * row, keep, _mm512_shuffle_f32x4(p, r, 0xdd));
        _mm512_mask_storeu_ps(out + (12 + c) * row, keep, _mm512_shuffle_f32x4(q, s, 0xdd));
    }
}

INLINE vec v_max(vec a, vec b) { return _mm512_max_ps(a, b); }  /* b where one is NaN */
INLINE vec v_min(vec a, vec b) { return _mm512_min_ps(a, b); }  /* likewise */
INLINE vec v_abs(vec x) { return _mm512_abs_ps(x); }

/* Of two numbers, without a branch; b where one is NaN */
INLINE float s_max(float a, float b) { return _mm_cvtss_f32(_mm_max_ss(_mm_set_ss(a), _mm_set_ss(b))); }
INLINE float s_min(float a, float b) { return _mm_cvtss_f32(_mm_min_ss(_mm_set_ss(a), _mm_set_ss(b))); }

INLINE vec v_copysign(vec size, vec sign)           /* size >= 0 */
{
    return _mm512_or_ps(size, _mm512_and_ps(sign, v_set(-0.0f)));
}

INLINE vec v_where_less(vec a, vec b, vec yes, vec no)
{
    return _mm512_mask_mov_ps(no, _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ), yes);
}

INLINE unsigned v_at_most(vec a, vec b) { return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ); }   /* bit i: a[i] <= b[i] */

/* Which lanes: where a < b, in both, in any; and what a vector has there, 0 elsewhere */
typedef __mmask16 mvec;

INLINE mvec m_less(vec a, vec b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
INLINE mvec m_both(mvec a, mvec b) { return _kand_mask16(a, b); }
INLINE bool m_any(mvec m) { return m != 0; }
INLINE vec v_where(mvec m, vec yes, vec no) { return _mm512_mask_mov_ps(no, m, yes); }
INLINE vec v_only(mvec m, vec v) { return _mm512_maskz_mov_ps(m, v); }

/* 2^n, where shifted = n + 1.5 * 2^23: for -126 <= n <= 127; and x times it, for any n */
INLINE vec v_pow2(vec shifted)
{
    const ivec n = _mm512_slli_epi32(_mm512_castps_si512(shifted), 23);

    return _mm512_castsi512_ps(_mm512_add_epi32(n, _mm512_set1_epi32(0x3f800000)));
}

/* table[n], where shifted = n + 1.5 * 2^23 and 0 <= n < 8 */
INLINE vec v_of_eight(const float *table, vec shifted)
{
    return _mm512_permutexvar_ps(_mm512_castps_si512(shifted), _mm512_castps256_ps512(_mm256_loadu_ps(table)));
}

/* 2^(n / 8), where shifted = n / 8 + 1.5 * 2^20 */
INLINE vec v_pow2_eighths(vec shifted)
{
    const ivec n = _mm512_castps_si512(shifted), part = _mm512_permutexvar_epi32(n, _mm512_loadu_si512(eighths));

    return _mm512_castsi512_ps(_mm512_add_epi32(_mm512_slli_epi32(n, 20), part));
}

INLINE vec v_times_pow2(vec x, vec shifted) { return _mm512_scalef_ps(x, shifted - v_set(12582912.0f)); }

INLINE __m512d eight_sums(const vec x[2])
{
    const vec sum = x[0] + x[1];

    return _mm512_cvtps_pd(_mm512_castps512_ps256(sum)) + _mm512_cvtps_pd(_mm512_extractf32x8_ps(sum, 1));
}

/* Quarters of 128 bits: those of a and b by halves */
INLINE __m512d add_halves(__m512d a, __m512d b)
{
    return _mm512_shuffle_f64x2(a, b, 0x44) + _mm512_shuffle_f64x2(a, b, 0xee);
}

/* out += the sums of 32 numbers, for SUMMED rows: i and i + 16, and from there on in double by halves */
enum { SUMMED = 4 };

INLINE void v_add_sums32(double out[SUMMED], const vec x[SUMMED][2])
{
    const __m512d a = add_halves(eight_sums(x[0]), eight_sums(x[1]));
    const __m512d b = add_halves(eight_sums(x[2]), eight_sums(x[3]));
    const __m512d two = _mm512_shuffle_f64x2(a, b, 0x88) + _mm512_shuffle_f64x2(a, b, 0xdd);
    const __m512d one = two + _mm512_permute_pd(two, 0x55);
    const __m512d sums = _mm512_permutexvar_pd(_mm512_setr_epi64(0, 2, 4, 6, 0, 2, 4, 6), one);

    _mm256_storeu_pd(out, _mm256_loadu_pd(out) + _mm512_castpd512_pd256(sums));
}

/* x and y, two rows of parts each: the sums of parts that are two, and then one apart */
INLINE vec sums_of_halves(vec x, vec y) { return _mm512_shuffle_f32x4(x, y, 0x44) + _mm512_shuffle_f32x4(x, y, 0xee); }
INLINE vec sums_of_parts(vec x, vec y) { return _mm512_shuffle_f32x4(x, y, 0x88) + _mm512_shuffle_f32x4(x, y, 0xdd); }

INLINE vec sums_of_quarters(const vec x[4][1], int n)
{
    const vec none = v_zero();

    return n <= 0 ? none
        : sums_of_parts(sums_of_halves(x[0][0], x[1][0]), n <= 2 ? none : sums_of_halves(x[2][0], x[3][0]));
}

/* out[j], j < n = the sum of the 16 numbers in x[j], by halves: i and i + 8, then i + 4 ...; 0 from even n on.
 * Rows that end in one part of 128 bits are taken together, so that row 4 j + i comes out as element j of part i. */
INLINE void v_sums16(float out[16], const vec x[16][1], int n)
{
    const __m512i turned = _mm512_setr_epi32(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
    vec four[4], two[2];

#pragma GCC unroll 4
    for (int j = 0; j < 4; j++)
        four[j] = sums_of_quarters(x + 4 * j, n - 4 * j);
#pragma GCC unroll 2
    for (int j = 0; j < 2; j++)
        two[j] = _mm512_shuffle_ps(four[2 * j], four[2 * j + 1], 0x44)
            + _mm512_shuffle_ps(four[2 * j], four[2 * j + 1], 0xee);
    v_store(out, _mm512_permutexvar_ps(turned, _mm512_shuffle_ps(two[0], two[1], 0x88)
                                               + _mm512_shuffle_ps(two[0], two[1], 0xdd)));
}

INLINE float v_max_lanes(vec v) { return _mm512_reduce_max_ps(v); }

/* For maxima and their places: where v is larger than *best, or a NaN and *best is none, it takes over, and
 * so does its place. v_count: first, first + step ... */
INLINE ivec v_count(int32_t first, int step)
{
    const ivec lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);

    return _mm512_add_epi32(_mm512_set1_epi32(first), _mm512_mullo_epi32(lane, _mm512_set1_epi32(step)));
}

INLINE void v_store_count(int32_t *p, ivec v, int hi) { _mm512_mask_storeu_epi32(p, first_lanes(hi), v); }

INLINE void v_take_larger(vec *best, ivec *place, vec v, ivec at)
{
    const __mmask16 take = _mm512_cmp_ps_mask(v, *best, _CMP_NLE_UQ)
        & _mm512_cmp_ps_mask(*best, *best, _CMP_ORD_Q);

    *best = _mm512_mask_mov_ps(*best, take, v);
    *place = _mm512_mask_mov_epi32(*place, take, at);
}

#endif
