/* SPDX-License-Identifier: Apache-2.0 */
/* A vector of 8 floats, and a tile of 6 x 2 of them: 12 of the 16 registers. */
#ifndef LT_KERNELS_VEC_AVX2_H
#define LT_KERNELS_VEC_AVX2_H

#include "libtensor/kernels/vec/unit.h"

#include <immintrin.h>

#define ISA(name) lt_avx2_##name

typedef __m256 vec;
typedef __m256i ivec;

enum { VL = 8, TILE_ROWS = 6, TILE_VECS = 2, PARTS_ARE_FREE = false };
#define TILE_LIST(X) ROWS6(X, 1) ROWS6(X, 2)

INLINE vec v_zero(void) { return _mm256_setzero_ps(); }
INLINE vec v_set(float x) { return _mm256_set1_ps(x); }
INLINE vec v_load(const float *p) { return _mm256_loadu_ps(p); }
INLINE void v_store(float *p, vec v) { _mm256_storeu_ps(p, v); }
INLINE vec v_fma(vec a, vec b, vec c) { return _mm256_fmadd_ps(a, b, c); }

/* sum + w x[at], but where at is below 0 */
INLINE vec v_fma_at(vec w, const float *x, const int32_t *at, vec sum)
{
    const __m256i place = _mm256_loadu_si256((const __m256i *)(const void *)at);
    const __m256 none = _mm256_castsi256_ps(place), there = _mm256_xor_ps(none, _mm256_set1_ps(-0.0f));
    const __m256 picked = _mm256_mask_i32gather_ps(_mm256_setzero_ps(), x, place, there, 4);

    return _mm256_blendv_ps(_mm256_fmadd_ps(w, picked, sum), sum, none);
}

/* The same where at is below 32 */
INLINE vec v_fma_among(vec w, const float *x, const int32_t *at, vec sum) { return v_fma_at(w, x, at, sum); }

/* Integers in the lanes: of the same bits, of the nearest, even where it stands between two, and back to floats */
INLINE ivec i_bits(vec v) { return _mm256_castps_si256(v); }
INLINE vec v_bits(ivec i) { return _mm256_castsi256_ps(i); }
INLINE ivec i_near(vec x) { return _mm256_cvtps_epi32(x); }
INLINE vec v_of_int(ivec i) { return _mm256_cvtepi32_ps(i); }
INLINE ivec i_set(int32_t x) { return _mm256_set1_epi32(x); }
INLINE ivec i_load(const uint32_t *p) { return _mm256_loadu_si256((const void *)p); }
INLINE ivec i_xor(ivec a, ivec b) { return _mm256_xor_si256(a, b); }

/* The lower words of products of words without sign, and the upper ones */
INLINE ivec i_multiply(ivec a, uint32_t b, ivec *upper)
{
    const ivec factor = i_set((int32_t)b), even = _mm256_mul_epu32(a, factor);
    const ivec odd = _mm256_mul_epu32(_mm256_srli_epi64(a, 32), factor);

    *upper = _mm256_blend_epi32(_mm256_srli_epi64(even, 32), odd, 0xaa);
    return _mm256_blend_epi32(even, _mm256_slli_epi64(odd, 32), 0xaa);
}

/* x where a word without sign is at least `least`, else 0 */
INLINE vec v_where_at_least(ivec word, uint32_t least, float x)
{
    const ivec is = _mm256_cmpeq_epi32(_mm256_max_epu32(word, i_set((int32_t)least)), word);

    return _mm256_and_ps(_mm256_castsi256_ps(is), v_set(x));
}

/* The lowest bytes of four, the first one lowest */
INLINE ivec i_bytes(const ivec x[4])
{
    const ivec byte = _mm256_set1_epi32(255);
    const ivec lo = _mm256_or_si256(_mm256_and_si256(x[0], byte), _mm256_slli_epi32(_mm256_and_si256(x[1], byte), 8));

    return _mm256_or_si256(lo, _mm256_or_si256(_mm256_slli_epi32(_mm256_and_si256(x[2], byte), 16),
                                               _mm256_slli_epi32(x[3], 24)));
}

/* sum + the four products of an unsigned and a signed byte. By 16 bits, for products of bytes that are added in 16
 * bits (vpmaddubsw) are cut off. */
INLINE ivec i_dot(ivec sum, ivec u, ivec s)
{
    const ivec even = _mm256_madd_epi16(_mm256_and_si256(u, _mm256_set1_epi16(255)),
                                        _mm256_srai_epi16(_mm256_slli_epi16(s, 8), 8));
    const ivec odd = _mm256_madd_epi16(_mm256_srli_epi16(u, 8), _mm256_srai_epi16(s, 8));

    return _mm256_add_epi32(_mm256_add_epi32(sum, even), odd);
}

/* The same with VNNI in 256 bits, where the compiler knows it */
#if defined(__clang__) ? __clang_major__ >= 12 : __GNUC__ >= 11
#define VNNI_TARGET __attribute__((target("avxvnni")))
#define VNNI_DOT(sum, u, s) _mm256_dpbusd_avx_epi32(sum, u, s)
#endif

/* DL doubles, of as many elements */
typedef __m256d dvec;
enum { DL = 4 };

INLINE dvec d_set(double x) { return _mm256_set1_pd(x); }
INLINE dvec d_load(const double *p) { return _mm256_loadu_pd(p); }
INLINE dvec d_widen(const float *p) { return _mm256_cvtps_pd(_mm_loadu_ps(p)); }
INLINE void d_store(double *p, dvec v) { _mm256_storeu_pd(p, v); }

/* v in a register: the compiler would load it again for each of its uses */
INLINE vec v_keep(vec v)
{
    __asm__("" : "+x"(v));
    return v;
}

INLINE vec v_relu(vec x) { return _mm256_max_ps(_mm256_setzero_ps(), x); }
INLINE vec v_leaky_relu(vec x, float slope)
{
    return _mm256_blendv_ps(x, x * v_set(slope), _mm256_cmp_ps(x, v_zero(), _CMP_LT_OQ));
}

INLINE __m256i lanes_below(int n)
{
    return _mm256_cmpgt_epi32(_mm256_set1_epi32(n), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
}

INLINE vec v_load_part(const float *p, int lo, int hi)
{
    return _mm256_maskload_ps(p, _mm256_andnot_si256(lanes_below(lo), lanes_below(hi)));
}

INLINE void v_store_part(float *p, vec v, int hi)
{
    _mm256_maskstore_ps(p, lanes_below(hi), v);
}

/* p[0], p[2], p[4] ...: those of the places lo <= i < hi, zero for the others */
INLINE vec v_load_even(const float *p, int lo, int hi)
{
    const vec a = v_load_part(p, lo, hi), b = v_load_part(p + VL, lo - VL, hi - VL);
    const __m256d halves = _mm256_castps_pd(_mm256_shuffle_ps(a, b, 0x88));     /* a b a b */

    return _mm256_castpd_ps(_mm256_permute4x64_pd(halves, 0xd8));
}

/* a[0], b[0], a[1], b[1] ... */
INLINE void v_zip(vec out[2], vec a, vec b)
{
    const vec even = _mm256_unpacklo_ps(a, b), odd = _mm256_unpackhi_ps(a, b);      /* of each half */

    out[0] = _mm256_permute2f128_ps(even, odd, 0x20);
    out[1] = _mm256_permute2f128_ps(even, odd, 0x31);
}

/* p[2 i] = fma(s, x[i], p[2 i]) for i < n, at most VL; what lies between is stored as it was */
INLINE void v_fma_even(float *p, vec s, vec x, int n)
{
    const __m256i twice = _mm256_setr_epi32(0, 0, 1, 1, 2, 2, 3, 3);
    const vec lo = _mm256_permutevar8x32_ps(x, twice);
    const vec hi = _mm256_permutevar8x32_ps(x, _mm256_add_epi32(twice, _mm256_set1_epi32(VL / 2)));
    const int end = 2 * n - 1;
    const vec p0 = v_load_part(p, 0, end), p1 = v_load_part(p + VL, 0, end - VL);

    v_store_part(p, _mm256_blend_ps(p0, v_fma(s, lo, p0), 0x55), end);
    v_store_part(p + VL, _mm256_blend_ps(p1, v_fma(s, hi, p1), 0x55), end - VL);
}

/* out[j]: p[j], p[4 + j], p[8 + j] ..., and back: a transpose of pairs of 128-bit parts, then of fours */
INLINE void v_load4(vec out[4], const float *p)
{
    const vec a = _mm256_loadu_ps(p), b = _mm256_loadu_ps(p + VL);
    const vec c = _mm256_loadu_ps(p + 2 * VL), d = _mm256_loadu_ps(p + 3 * VL);
    const vec ac = _mm256_permute2f128_ps(a, c, 0x20), ac2 = _mm256_permute2f128_ps(a, c, 0x31);
    const vec bd = _mm256_permute2f128_ps(b, d, 0x20), bd2 = _mm256_permute2f128_ps(b, d, 0x31);
    const vec lo = _mm256_unpacklo_ps(ac, bd), hi = _mm256_unpackhi_ps(ac, bd);
    const vec lo2 = _mm256_unpacklo_ps(ac2, bd2), hi2 = _mm256_unpackhi_ps(ac2, bd2);

    out[0] = _mm256_unpacklo_ps(lo, lo2);
    out[1] = _mm256_unpackhi_ps(lo, lo2);
    out[2] = _mm256_unpacklo_ps(hi, hi2);
    out[3] = _mm256_unpackhi_ps(hi, hi2);
}

INLINE void v_store4(float *p, const vec x[4])
{
    const vec lo = _mm256_unpacklo_ps(x[0], x[2]), hi = _mm256_unpackhi_ps(x[0], x[2]);
    const vec lo2 = _mm256_unpacklo_ps(x[1], x[3]), hi2 = _mm256_unpackhi_ps(x[1], x[3]);
    const vec a = _mm256_unpacklo_ps(lo, lo2), b = _mm256_unpackhi_ps(lo, lo2);
    const vec c = _mm256_unpacklo_ps(hi, hi2), d = _mm256_unpackhi_ps(hi, hi2);

    _mm256_storeu_ps(p, _mm256_permute2f128_ps(a, b, 0x20));
    _mm256_storeu_ps(p + VL, _mm256_permute2f128_ps(c, d, 0x20));
    _mm256_storeu_ps(p + 2 * VL, _mm256_permute2f128_ps(a, b, 0x31));
    _mm256_storeu_ps(p + 3 * VL, _mm256_permute2f128_ps(c, d, 0x31));
}

/* p[3 * i + a] = x[a][i], i < n */
INLINE void v_store3(float *p, const vec x[3], int n)
{
    float row[3][VL];

    for (int a = 0; a < 3; a++)
        v_store(row[a], x[a]);
    for (int i = 0; i < n; i++)
        for (int a = 0; a < 3; a++)
            p[3 * i + a] = row[a][i];
}

/* out[j * row + i] = x[i * col + j] for i < lanes, j < VL. Pairs, then fours of rows within each 128
 * bits; then the halves change places. */
INLINE void v_transpose(float *out, int64_t row, const float *x, int64_t col, int lanes)
{
    vec a[VL], b[VL];

#pragma GCC unroll 8
    for (int i = 0; i < VL; i++) {
        a[i] = _mm256_loadu_ps(x);
        x += i + 1 < lanes ? col : 0;
    }
#pragma GCC unroll 8
    for (int i = 0; i < VL; i += 2) {
        b[i] = _mm256_unpacklo_ps(a[i], a[i + 1]);
        b[i + 1] = _mm256_unpackhi_ps(a[i], a[i + 1]);
    }
#pragma GCC unroll 8
    for (int i = 0; i < VL; i += 4)
#pragma GCC unroll 2
        for (int h = 0; h < 2; h++) {
            a[i + 2 * h] = _mm256_shuffle_ps(b[i + h], b[i + h + 2], 0x44);
            a[i + 2 * h + 1] = _mm256_shuffle_ps(b[i + h], b[i + h + 2], 0xee);
        }
#pragma GCC unroll 8
    for (int c = 0; c < 4; c++) {
        v_store_part(out + c * row, _mm256_permute2f128_ps(a[c], a[4 + c], 0x20), lanes);
        v_store_part(out + (4 + c) * row, _mm256_permute2f128_ps(a[c], a[4 + c], 0x31), lanes);
    }
}

INLINE vec v_max(vec a, vec b) { return _mm256_max_ps(a, b); }  /* b where one is NaN */
INLINE vec v_min(vec a, vec b) { return _mm256_min_ps(a, b); }  /* likewise */

/* Of two numbers, without a branch; b where one is NaN */
INLINE float s_max(float a, float b) { return _mm_cvtss_f32(_mm_max_ss(_mm_set_ss(a), _mm_set_ss(b))); }
INLINE float s_min(float a, float b) { return _mm_cvtss_f32(_mm_min_ss(_mm_set_ss(a), _mm_set_ss(b))); }

INLINE vec v_abs(vec x) { return _mm256_andnot_ps(v_set(-0.0f), x); }
INLINE vec v_copysign(vec size, vec sign)           /* size >= 0 */
{
    return _mm256_or_ps(size, _mm256_and_ps(sign, v_set(-0.0f)));
}

INLINE vec v_where_less(vec a, vec b, vec yes, vec no)
{
    return _mm256_blendv_ps(no, yes, _mm256_cmp_ps(a, b, _CMP_LT_OQ));
}

INLINE unsigned v_at_most(vec a, vec b)             /* bit i: a[i] <= b[i] */
{
    return (unsigned)_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_LE_OQ));
}

/* Which lanes: where a < b, in both, in any; and what a vector has there, 0 elsewhere */
typedef __m256 mvec;

INLINE mvec m_less(vec a, vec b) { return _mm256_cmp_ps(a, b, _CMP_LT_OQ); }
INLINE mvec m_both(mvec a, mvec b) { return _mm256_and_ps(a, b); }
INLINE bool m_any(mvec m) { return _mm256_movemask_ps(m) != 0; }
INLINE vec v_where(mvec m, vec yes, vec no) { return _mm256_blendv_ps(no, yes, m); }
INLINE vec v_only(mvec m, vec v) { return _mm256_and_ps(m, v); }

/* 2^n, where shifted = n + 1.5 * 2^23: for -126 <= n <= 127; and x times it, for any n */
INLINE vec pow2_of(ivec n)
{
    return _mm256_castsi256_ps(_mm256_add_epi32(_mm256_slli_epi32(n, 23), _mm256_set1_epi32(0x3f800000)));
}

INLINE vec v_pow2(vec shifted) { return pow2_of(_mm256_castps_si256(shifted)); }

/* table[n], where shifted = n + 1.5 * 2^23 and 0 <= n < 8 */
INLINE vec v_of_eight(const float *table, vec shifted)
{
    return _mm256_permutevar8x32_ps(_mm256_loadu_ps(table), _mm256_castps_si256(shifted));
}

/* 2^(n / 8), where shifted = n / 8 + 1.5 * 2^20 */
INLINE vec v_pow2_eighths(vec shifted)
{
    const ivec n = _mm256_castps_si256(shifted);
    const ivec part = _mm256_permutevar8x32_epi32(_mm256_loadu_si256((const void *)eighths), n);

    return _mm256_castsi256_ps(_mm256_add_epi32(_mm256_slli_epi32(n, 20), part));
}

INLINE vec v_times_pow2(vec x, vec shifted)         /* in two steps: 2^n itself may be subnormal */
{
    const ivec n = _mm256_sub_epi32(_mm256_castps_si256(shifted), _mm256_set1_epi32(0x4b400000));
    const ivec half = _mm256_srai_epi32(n, 1);

    return x * pow2_of(half) * pow2_of(_mm256_sub_epi32(n, half));
}

INLINE __m256d half_as_double(vec x, const int half)
{
    return _mm256_cvtps_pd(half ? _mm256_extractf128_ps(x, 1) : _mm256_castps256_ps128(x));
}

/* out += the sums of 32 numbers, for SUMMED rows: i and i + 16, and from there on in double by halves */
enum { SUMMED = 1 };

INLINE void v_add_sums32(double out[SUMMED], const vec x[SUMMED][4])
{
    const vec lo = x[0][0] + x[0][2], hi = x[0][1] + x[0][3];
    const __m256d low = half_as_double(lo, 0) + half_as_double(hi, 0);
    const __m256d four = low + (half_as_double(lo, 1) + half_as_double(hi, 1));
    const __m128d two = _mm256_castpd256_pd128(four) + _mm256_extractf128_pd(four, 1);

    out[0] += two[0] + two[1];
}

/* x's and y's sums of lanes that are eight, and then four apart */
INLINE vec sums_of_halves(const vec x[2], const vec y[2])
{
    const vec a = x[0] + x[1], b = y[0] + y[1];

    return _mm256_permute2f128_ps(a, b, 0x20) + _mm256_permute2f128_ps(a, b, 0x31);
}

/* out[j], j < n = the sum of the 16 numbers in x[j], by halves: i and i + 8, then i + 4 ...; 0 from even n on. */
INLINE void v_sums16(float out[16], const vec x[16][2], int n)
{
    const __m256i turned = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);

    for (int j = 0; j < 16; j += 8) {
        vec half[4], two[2];

        for (int i = 0; i < 4; i++) {
            half[i] = v_zero();
            if (j + 2 * i < n)
                half[i] = sums_of_halves(x[j + 2 * i], x[j + 2 * i + 1]);
        }
        for (int i = 0; i < 2; i++)
            two[i] = _mm256_shuffle_ps(half[2 * i], half[2 * i + 1], 0x44)
                + _mm256_shuffle_ps(half[2 * i], half[2 * i + 1], 0xee);
        v_store(out + j, _mm256_permutevar8x32_ps(_mm256_shuffle_ps(two[0], two[1], 0x88)
                                                  + _mm256_shuffle_ps(two[0], two[1], 0xdd), turned));
    }
}

INLINE float v_max_lanes(vec v)
{
    __m128 x = _mm_max_ps(_mm256_castps256_ps128(v), _mm256_extractf128_ps(v, 1));

    x = _mm_max_ps(x, _mm_movehl_ps(x, x));
    return _mm_cvtss_f32(_mm_max_ss(x, _mm_movehdup_ps(x)));
}

/* For maxima and their places: where v is larger than *best, or a NaN and *best is none, it takes over, and
 * so does its place. v_count: first, first + step ... */
INLINE ivec v_count(int32_t first, int step)
{
    const ivec lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);

    return _mm256_add_epi32(_mm256_set1_epi32(first), _mm256_mullo_epi32(lane, _mm256_set1_epi32(step)));
}

INLINE void v_store_count(int32_t *p, ivec v, int hi) { _mm256_maskstore_epi32(p, lanes_below(hi), v); }

INLINE void v_take_larger(vec *best, ivec *place, vec v, ivec at)
{
    const vec take = _mm256_and_ps(_mm256_cmp_ps(v, *best, _CMP_NLE_UQ), _mm256_cmp_ps(*best, *best, _CMP_ORD_Q));

    *best = _mm256_blendv_ps(*best, v, take);
    *place = _mm256_blendv_epi8(*place, at, _mm256_castps_si256(take));
}

#endif
