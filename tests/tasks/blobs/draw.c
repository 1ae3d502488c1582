/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/tasks/blobs/draw.h"

#include "libtensor/graph/op.h"

#include <math.h>

enum { CENTRE, COUNT, GAIN };

static const double spread = 0.02;      /* twice the variance */

static void pixel_at(int i, lt_real p[2])
{
    p[0] = (lt_real)((i % DRAW_SIDE + 0.5) / DRAW_SIDE);
    p[1] = (lt_real)((i / DRAW_SIDE + 0.5) / DRAW_SIDE);
}

static lt_real blob_at(const lt_real p[2], const lt_real c[2])
{
    const lt_real x = p[0] - c[0], y = p[1] - c[1];

    return (lt_real)exp(-(x * x + y * y) / spread);
}

void draw_add(const lt_real *centre, int n, lt_real gain, lt_real *out)
{
    for (int i = 0; i < DRAW_PIXELS; i++) {
        lt_real p[2];

        pixel_at(i, p);
        for (int k = 0; k < n; k++)
            out[i] += gain * blob_at(p, centre + 2 * k);
    }
}

static lt_status infer(lt_call *c)
{
    c->out->shape = LT_SHAPE(DRAW_PIXELS);
    return lt_want_shape(c, GAIN, "gain", LT_SHAPE(1));
}

static int count_of(const lt_call *c)
{
    const int32_t n = *(const int32_t *)c->in[COUNT]->data, rows = (int32_t)lt_dim(c->in[CENTRE], 0);

    return n < 0 ? 0 : n > rows ? rows : n;
}

static void forward(const lt_call *c)
{
    lt_real *y = c->out->data;

    for (int i = 0; i < DRAW_PIXELS; i++)
        y[i] = 0;
    draw_add(c->in[CENTRE]->data, count_of(c), *(const lt_real *)c->in[GAIN]->data, y);
}

static void backward(const lt_call *c)
{
    const lt_real *centre = c->in[CENTRE]->data, gain = *(const lt_real *)c->in[GAIN]->data;

    for (int k = 0; k < count_of(c); k++)
        for (int i = 0; i < DRAW_PIXELS; i++) {
            lt_real p[2], b;

            pixel_at(i, p);
            b = blob_at(p, centre + 2 * k);
            for (int d = 0; d < 2 && c->din[CENTRE]; d++)
                c->din[CENTRE][2 * k + d] += c->dout[i] * gain * b * (lt_real)(2 / spread) * (p[d] - centre[2 * k + d]);
            if (c->din[GAIN])
                *c->din[GAIN] += c->dout[i] * b;
        }
}

static const lt_op draw_op = {
    .name = "draw", .any_type = LT_ANY_TYPE_IN(COUNT), .infer = infer, .forward = forward, .backward = backward,
};

lt_tensor *draw(lt_tensor *centre, lt_tensor *n, lt_tensor *gain)
{
    lt_tensor *const in[] = { centre, n, gain };

    return lt_apply(&draw_op, NULL, 0, in, 3);
}
