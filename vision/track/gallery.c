/* SPDX-License-Identifier: Apache-2.0 */
#include "vision/track/gallery.h"

#include "libtensor/base/arena.h"
#include "libtensor/kernels/gemm/gemm.h"

#include <math.h>
#include <string.h>

lt_status gallery_init(gallery *g, int budget, int size)
{
    *g = (gallery){ .budget = budget, .size = size };
    g->row = lt_alloc((size_t)budget * (size_t)size * sizeof(*g->row));
    return g->row ? LT_OK : lt_error(LT_ENOMEM, "no memory for how a track looked");
}

void gallery_fini(gallery *g)
{
    lt_release(g->row);
    *g = (gallery){ 0 };
}

bool gallery_unit(const float *embedding, int size, float *unit)
{
    double sum = 0, scale;

    for (int i = 0; i < size; i++)
        sum += (double)embedding[i] * (double)embedding[i];
    if (!isfinite(sum) || sum <= 0)
        return false;
    scale = 1 / sqrt(sum);
    for (int i = 0; i < size; i++)
        unit[i] = (float)((double)embedding[i] * scale);
    return true;
}

void gallery_add(gallery *g, const float *unit)
{
    memcpy(g->row + (size_t)g->next * (size_t)g->size, unit, (size_t)g->size * sizeof(*unit));
    g->next = (g->next + 1) % g->budget;
    g->n += g->n < g->budget;
}

void gallery_distances(const gallery *g, const float *units, int n, float *scratch, double *out)
{
    lt_gemm(LT_NO_TRANS, LT_TRANS, g->n, n, g->size, g->row, g->size, units, g->size, false, scratch, n, NULL);
    for (int j = 0; j < n; j++) {
        float most = -1;

        for (int i = 0; i < g->n; i++)
            most = fmaxf(most, scratch[(size_t)i * (size_t)n + (size_t)j]);
        out[j] = 1 - (double)most;
    }
}
