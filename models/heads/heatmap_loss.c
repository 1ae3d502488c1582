/* SPDX-License-Identifier: Apache-2.0 */
#include "models/heads/heatmap_loss.h"

#include <math.h>
#include <string.h>

typedef struct { int h, w, margin; } target_attr;

static lt_status target_infer(lt_call *c)
{
    const target_attr *a = c->attr;

    if (lt_want_rank(c, 0, "places", 3))
        return LT_ESHAPE;
    c->out->shape = LT_SHAPE(lt_dim(c->in[0], 0), lt_dim(c->in[0], 1), a->h * a->w);
    return LT_OK;
}

typedef struct { int low, high; double rest; } cells_around;

/* The cells whose centres lie on both sides of u, in [0, 1] of n cells without their margin */
static cells_around around(double u, int n, int margin)
{
    const double at = fmax(0, fmin(n - 1, u * (n - 2 * margin) + margin - 0.5));
    const int low = (int)at;

    return (cells_around){ .low = low, .high = low + 1 < n ? low + 1 : low, .rest = at - low };
}

static void target_forward(const lt_call *c)
{
    const target_attr *a = c->attr;
    const lt_real *places = c->in[0]->data;
    lt_real *map = c->out->data;

    memset(map, 0, (size_t)lt_numel(c->out) * sizeof(*map));
    for (int64_t i = 0; i < lt_dim(c->out, 0) * lt_dim(c->out, 1); i++, map += a->h * a->w) {
        const cells_around x = around((double)places[2 * i], a->w, a->margin);
        const cells_around y = around((double)places[2 * i + 1], a->h, a->margin);

        map[y.low * a->w + x.low] += (lt_real)((1 - y.rest) * (1 - x.rest));
        map[y.low * a->w + x.high] += (lt_real)((1 - y.rest) * x.rest);
        map[y.high * a->w + x.low] += (lt_real)(y.rest * (1 - x.rest));
        map[y.high * a->w + x.high] += (lt_real)(y.rest * x.rest);
    }
}

static const lt_op heatmap_target_op = {
    .name = "heatmap_target", .flags = LT_OP_DETACH, .infer = target_infer, .forward = target_forward,
};

lt_tensor *heatmap_loss(lt_tensor *logits, lt_tensor *places, int h, int w, int margin, lt_tensor *weight)
{
    const target_attr a = { .h = h, .w = w, .margin = margin };

    return lt_cross_entropy(logits, lt_apply(&heatmap_target_op, &a, sizeof(a), &places, 1), weight);
}
