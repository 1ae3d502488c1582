/* SPDX-License-Identifier: Apache-2.0 */
#include "models/body/volume_loss.h"

#include <math.h>
#include <string.h>

enum { PLACES, KNOWN };

static lt_status infer(lt_call *c)
{
    const volume_size *a = c->attr;

    if (lt_want_rank(c, PLACES, "places", 3))
        return LT_ESHAPE;
    if (lt_dim(c->in[PLACES], 2) != 3)
        return lt_fail(c, "a place has %lld numbers, want 3", (long long)lt_dim(c->in[PLACES], 2));
    if (lt_want_shape(c, KNOWN, "known", LT_SHAPE(lt_dim(c->in[PLACES], 0), lt_dim(c->in[PLACES], 1))))
        return LT_ESHAPE;
    c->out->shape = LT_SHAPE(lt_dim(c->in[PLACES], 0), lt_dim(c->in[PLACES], 1), a->depth * a->rows * a->columns);
    return LT_OK;
}

/* Two neighbouring cells of a line and the share of each; a line's ends hold what is beyond. */
typedef struct {
    int cell[2];
    double share[2];
} cells_around;

static cells_around around(double at, int n)
{
    const double inside = fmax(0, fmin(n - 1, at));
    const int low = (int)inside;

    const double rest = inside - low;

    return (cells_around){ .cell = { low, low + 1 < n ? low + 1 : low }, .share = { 1 - rest, rest } };
}

static void forward(const lt_call *c)
{
    const volume_size *a = c->attr;
    const lt_real *place = c->in[PLACES]->data, *known = c->in[KNOWN]->data;
    lt_real *volume = c->out->data;

    memset(volume, 0, (size_t)lt_numel(c->out) * sizeof(*volume));
    for (int64_t i = 0; i < lt_numel(c->in[KNOWN]); i++, place += 3, volume += a->depth * a->rows * a->columns) {
        const cells_around x = around((double)place[0], a->columns), y = around((double)place[1], a->rows);
        const cells_around z = around((double)place[2], a->depth);

        for (int k = 0; k < 8; k++) {
            const int right = k & 1, below = k >> 1 & 1, behind = k >> 2;

            volume[(z.cell[behind] * a->rows + y.cell[below]) * a->columns + x.cell[right]] +=
                known[i] * (lt_real)(z.share[behind] * y.share[below] * x.share[right]);
        }
    }
}

static const lt_op volume_target_op = {
    .name = "volume_target", .flags = LT_OP_DETACH, .infer = infer, .forward = forward,
};

lt_tensor *volume_loss(lt_tensor *logits, lt_tensor *places, lt_tensor *known, volume_size size, lt_tensor *weight)
{
    lt_tensor *in[2] = { places, known };

    return lt_cross_entropy(logits, lt_apply(&volume_target_op, &size, sizeof(size), in, 2), weight);
}
