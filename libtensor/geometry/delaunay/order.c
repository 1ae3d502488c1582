/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/base/rng.h"
#include "libtensor/geometry/delaunay/internal.h"

#include <stdlib.h>

enum { BITS = 16, ROUNDS = 24 };    /* of a place that the curve goes by; at most */

typedef struct {
    uint64_t key;                   /* the round, then the place on the curve */
    int32_t point;
} entry;

/* Where on Hilbert's curve a place is            [Skilling 2004, "Programming the Hilbert curve", the transpose] */
static uint64_t along_curve(const int32_t place[3])
{
    uint32_t x[3], t;
    uint64_t key = 0;

    for (int k = 0; k < 3; k++)
        x[k] = (uint32_t)place[k] >> (LT_DELAUNAY_BITS - BITS);
    for (uint32_t q = UINT32_C(1) << (BITS - 1); q > 1; q >>= 1)
        for (int k = 0; k < 3; k++) {
            const uint32_t low = q - 1;

            if (x[k] & q) {
                x[0] ^= low;
            } else {
                t = (x[0] ^ x[k]) & low;
                x[0] ^= t;
                x[k] ^= t;
            }
        }
    x[1] ^= x[0];
    x[2] ^= x[1];
    t = 0;
    for (uint32_t q = UINT32_C(1) << (BITS - 1); q > 1; q >>= 1)
        if (x[2] & q)
            t ^= q - 1;
    for (int b = BITS - 1; b >= 0; b--)
        for (int k = 0; k < 3; k++)
            key = key << 1 | (((x[k] ^ t) >> b) & 1);
    return key;
}

/* Half of the points are of the last round, a quarter of that before .. */
static uint64_t round_of(int64_t point)
{
    uint64_t draw = lt_rng_mix(UINT64_C(0x64656c61), (uint64_t)point);
    uint64_t round = ROUNDS;

    while (round > 0 && draw & 1) {
        draw >>= 1;
        round--;
    }
    return round;
}

static int by_key(const void *a, const void *b)
{
    const entry *x = a, *y = b;

    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return x->point < y->point ? -1 : x->point > y->point;
}

lt_status delaunay_order(lt_arena *arena, int64_t n, const int32_t (*grid)[3], int32_t **out)
{
    entry *list = lt_alloc((size_t)n * sizeof(*list));
    int32_t *order = lt_arena_array(arena, (size_t)n, sizeof(*order));

    if (!list || !order) {
        lt_release(list);
        return lt_error(LT_ENOMEM, "no memory for %lld points", (long long)n);
    }
    for (int64_t i = 0; i < n; i++)
        list[i] = (entry){ round_of(i) << 48 | along_curve(grid[i]), (int32_t)i };
    qsort(list, (size_t)n, sizeof(*list), by_key);
    for (int64_t i = 0; i < n; i++)
        order[i] = list[i].point;
    lt_release(list);
    *out = order;
    return LT_OK;
}
