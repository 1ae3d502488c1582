/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Counter-based random numbers: a draw is a function of (seed, stream, index), so it does not depend
 * on threads, on the order of calls, or on what ran before a resume.
 *
 * Source: Salmon et al. 2011, "Parallel random numbers: as easy as 1, 2, 3" (Philox4x32-10).
 */
#ifndef LT_BASE_RNG_H
#define LT_BASE_RNG_H

#include "libtensor/base/common.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lt_philox - the four words of counter ctr under key; the same on every machine */
LT_API void lt_philox(const uint32_t key[2], const uint32_t ctr[4], uint32_t out[4]);

/* A stream of draws. Copy it freely: it is its own state. stream tells uses of one seed apart. */
typedef struct {
    uint64_t seed, stream, index;   /* index: the next draw */
    uint64_t block;                 /* 1 + the block of four draws that word holds; 0: none */
    uint32_t word[4];
} lt_rng;

static inline lt_rng lt_rng_make(uint64_t seed, uint64_t stream)
{
    const lt_rng r = { .seed = seed, .stream = stream, .index = 0, .block = 0, .word = { 0 } };

    return r;
}

/* lt_rng_mix - one stream number out of two, for streams named by several numbers */
LT_API uint64_t lt_rng_mix(uint64_t a, uint64_t b);

LT_API uint32_t lt_rng_u32(lt_rng *r);                          /* 0 .. 2^32 - 1 */
LT_API double lt_rng_uniform(lt_rng *r);                        /* [0, 1), 53 bits */
LT_API double lt_rng_range(lt_rng *r, double lo, double hi);    /* [lo, hi) */
LT_API double lt_rng_normal(lt_rng *r);                         /* mean 0, deviation 1 */
LT_API uint32_t lt_rng_below(lt_rng *r, uint32_t n);            /* 0 .. n - 1, unbiased; 0 for n = 0 */

/* lt_rng_permute - fill order[n] with a random permutation of 0 .. n - 1 */
LT_API void lt_rng_permute(lt_rng *r, uint32_t *order, uint32_t n);

#ifdef __cplusplus
}
#endif
#endif
