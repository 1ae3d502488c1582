/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/blocks/places.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/gemm/product.h"

int64_t lt_places_window(int64_t o, int64_t segments)
{
    return lt_product_packed_b(o, segments * LT_BLOCK) + LT_PLACES_APART;
}

/* One panel of windows in one place */
static void multiply(void *ctx, int64_t task)
{
    const lt_places *j = ctx;
    const int64_t nr = lt_k->nr, panels = lt_ceil_div(j->o, nr), parts = lt_product_blocks(j->segments * LT_BLOCK);
    const int64_t place = task / panels, o = task % panels * nr;
    int64_t segment[LT_PLACES_SEGMENTS];
    lt_blocks g = { .a = j->in + place * j->in_place, .rows = j->tiles, .step = LT_BLOCK, .lines = 1,
                    .each = LT_BLOCK, .last = LT_BLOCK, .n = lt_min_i64(nr, j->o - o), .plane = j->tiles * LT_BLOCK };

    for (int64_t s = 0; s < j->segments; s++)
        segment[s] = s * g.plane;
    g.c = j->out + place * j->out_place + o / LT_BLOCK * g.plane + o % LT_BLOCK;
    for (int64_t i = 0; i < parts; i++) {
        const int64_t from = i * j->segments / parts;

        g.segment = segment + from;
        g.segments = (i + 1) * j->segments / parts - from;
        g.b = j->windows + place * j->window + (o * j->segments + from * nr) * LT_BLOCK;
        g.add = i > 0;
        lt_k->gemm_blocks(&g, NULL);
    }
}

void lt_places_multiply(const lt_places *j)
{
    lt_parallel_for(j->places * lt_ceil_div(j->o, lt_k->nr), multiply, (void *)j);
}
