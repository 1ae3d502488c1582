/* SPDX-License-Identifier: Apache-2.0 */
#include "models/detect/cells.h"

#include <math.h>

int64_t cells_of(const lt_call *c)
{
    int64_t n = 0;

    for (int i = 0; i < DETECT_LEVELS; i++)
        n += lt_dim(c->in[i], 2) * lt_dim(c->in[i], 3);
    return n;
}

cell cell_at(const lt_call *c, int64_t i)
{
    cell out = { .level = 0, .at = i };
    int64_t w;

    while (out.at >= lt_dim(c->in[out.level], 2) * lt_dim(c->in[out.level], 3)) {
        out.at -= lt_dim(c->in[out.level], 2) * lt_dim(c->in[out.level], 3);
        out.level++;
    }
    w = lt_dim(c->in[out.level], 3);
    out.plane = lt_dim(c->in[out.level], 2) * w;
    out.stride = 8 << out.level;
    out.x = (double)(out.at % w) + 0.5;
    out.y = (double)(out.at / w) + 0.5;
    return out;
}

lt_status cells_check(lt_call *c, const char *what, int64_t channels)
{
    for (int i = 0; i < DETECT_LEVELS; i++) {
        const lt_tensor *x = c->in[i];

        if (lt_want_rank(c, i, what, 4))
            return LT_ESHAPE;
        if (lt_dim(x, 0) != lt_dim(c->in[0], 0) || lt_dim(x, 1) != (channels ? channels : lt_dim(c->in[0], 1)))
            return lt_fail(c, "%s of level %d has %lld images and %lld channels, want %lld and %lld", what, i,
                           (long long)lt_dim(x, 0), (long long)lt_dim(x, 1), (long long)lt_dim(c->in[0], 0),
                           (long long)(channels ? channels : lt_dim(c->in[0], 1)));
    }
    return LT_OK;
}

const lt_real *cell_values(const lt_call *c, int64_t b, const cell *at)
{
    const lt_tensor *x = c->in[at->level];

    return (const lt_real *)x->data + b * lt_dim(x, 1) * at->plane + at->at;
}

/* The mean bin of a side whose logits stand a plane apart; q (16): their softmax */
static double side(const lt_real *bins, int64_t plane, double *q)
{
    double top = (double)bins[0], sum = 0, mean = 0;

    for (int k = 1; k < DETECT_BINS; k++)
        top = fmax(top, (double)bins[k * plane]);
    for (int k = 0; k < DETECT_BINS; k++)
        sum += q[k] = exp((double)bins[k * plane] - top);
    for (int k = 0; k < DETECT_BINS; k++)
        mean += k * (q[k] /= sum);
    return mean;
}

ciou_box cell_box(const cell *at, const lt_real *bins, double *q)
{
    double d[DETECT_SIDES], room[DETECT_BINS];

    for (int s = 0; s < DETECT_SIDES; s++)
        d[s] = side(bins + s * DETECT_BINS * at->plane, at->plane, q ? q + s * DETECT_BINS : room);
    return (ciou_box){ { at->x - d[0], at->y - d[1], at->x + d[2], at->y + d[3] } };
}

const lt_real *object_at(const lt_tensor *objects, int64_t b, int64_t i)
{
    const lt_real *o = (const lt_real *)objects->data + (b * lt_dim(objects, 1) + i) * OBJECT_NUMBERS;

    return o[OBJECT_CLASS] >= 0 ? o : NULL;
}

ciou_box object_box(const lt_real *object, double stride)
{
    ciou_box b;

    for (int i = 0; i < 4; i++)
        b.v[i] = (double)object[OBJECT_X0 + i] / stride;
    return b;
}
