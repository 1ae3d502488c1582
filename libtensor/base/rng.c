/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/base/rng.h"

#include <math.h>

enum { ROUNDS = 10 };

static const double TWO_PI = 6.283185307179586476925286766559;

static uint32_t mul_hi_lo(uint32_t a, uint32_t b, uint32_t *lo)
{
    const uint64_t p = (uint64_t)a * b;

    *lo = (uint32_t)p;
    return (uint32_t)(p >> 32);
}

void lt_philox(const uint32_t key[2], const uint32_t ctr[4], uint32_t out[4])
{
    uint32_t k0 = key[0], k1 = key[1];
    uint32_t c0 = ctr[0], c1 = ctr[1], c2 = ctr[2], c3 = ctr[3];

    for (int i = 0; i < ROUNDS; i++) {
        uint32_t lo0, lo1;
        const uint32_t hi0 = mul_hi_lo(0xD2511F53u, c0, &lo0);
        const uint32_t hi1 = mul_hi_lo(0xCD9E8D57u, c2, &lo1);

        c0 = hi1 ^ c1 ^ k0;
        c1 = lo1;
        c2 = hi0 ^ c3 ^ k1;
        c3 = lo0;
        k0 += 0x9E3779B9u;
        k1 += 0xBB67AE85u;
    }
    out[0] = c0;
    out[1] = c1;
    out[2] = c2;
    out[3] = c3;
}

static void fill_block(lt_rng *r, uint64_t block)
{
    const uint32_t key[2] = { (uint32_t)r->seed, (uint32_t)(r->seed >> 32) };
    const uint32_t ctr[4] = { (uint32_t)block, (uint32_t)(block >> 32),
                              (uint32_t)r->stream, (uint32_t)(r->stream >> 32) };

    lt_philox(key, ctr, r->word);
    r->block = block + 1;
}

/* Draw i is word i % 4 of block i / 4. */
uint32_t lt_rng_u32(lt_rng *r)
{
    if (r->block != r->index / 4 + 1)
        fill_block(r, r->index / 4);
    return r->word[r->index++ % 4];
}

uint64_t lt_rng_mix(uint64_t a, uint64_t b)
{
    uint64_t z = a + 0x9E3779B97F4A7C15u * (b + 1);

    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

double lt_rng_uniform(lt_rng *r)
{
    const uint64_t hi = lt_rng_u32(r) >> 5, lo = lt_rng_u32(r) >> 6;

    return ((double)hi * 67108864.0 + (double)lo) / 9007199254740992.0;
}

double lt_rng_range(lt_rng *r, double lo, double hi)
{
    return lo + (hi - lo) * lt_rng_uniform(r);
}

double lt_rng_normal(lt_rng *r)
{
    const double u = 1.0 - lt_rng_uniform(r);           /* (0, 1]: the logarithm is finite */
    const double v = lt_rng_uniform(r);

    return sqrt(-2.0 * log(u)) * cos(TWO_PI * v);
}

uint32_t lt_rng_below(lt_rng *r, uint32_t n)
{
    const uint32_t reject = n ? -n % n : 0;             /* 2^32 mod n draws would be one too many */
    uint32_t x;

    if (n == 0)
        return 0;
    do
        x = lt_rng_u32(r);
    while (x < reject);
    return x % n;
}

void lt_rng_permute(lt_rng *r, uint32_t *order, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t j = lt_rng_below(r, i + 1);

        order[i] = order[j];
        order[j] = i;
    }
}
