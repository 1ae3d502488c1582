/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The gradients of a convolution of which only a rectangle of each result counts: the rectangle and what its windows
 * reach are copied to maps of their own, and those go the way of any others.
 */
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv_internal.h"

#include <string.h>

/* A map's part: what g has of it, of which only r holds anything. */
typedef struct {
    int64_t h, w;               /* of the map */
    lt_rect g, r;
    lt_real *map, *part;        /* (channels, h, w); (channels, rows of g, columns of g) */
} cutting;

static void take_plane(void *ctx, int64_t channel)
{
    const cutting *c = ctx;
    const lt_rect g = c->g, r = c->r;
    const int64_t wide = g.x1 - g.x0, n = (g.y1 - g.y0) * wide;
    const lt_real *map = c->map + channel * c->h * c->w;
    lt_real *part = c->part + channel * n;

    memset(part, 0, (size_t)n * sizeof(lt_real));
    for (int64_t y = r.y0; y < r.y1; y++)
        memcpy(part + (y - g.y0) * wide + r.x0 - g.x0, map + y * c->w + r.x0, (size_t)(r.x1 - r.x0) * sizeof(lt_real));
}

static void add_plane(void *ctx, int64_t channel)
{
    const cutting *c = ctx;
    const lt_rect g = c->g;
    const int64_t wide = g.x1 - g.x0;
    const lt_real *part = c->part + channel * (g.y1 - g.y0) * wide;
    lt_real *map = c->map + channel * c->h * c->w;

    for (int64_t y = g.y0; y < g.y1; y++, part += wide)
        lt_k->add_to(map + y * c->w + g.x0, part, (size_t)wide);
}

/* r and as far around it as windows reach, clipped to the map */
static lt_rect reached(const lt_conv2d_params *p, lt_rect r)
{
    return (lt_rect){
        lt_max_i64(0, r.y0 - p->pad_h), lt_min_i64(p->h, r.y1 + p->pad_h),
        lt_max_i64(0, r.x0 - p->pad_w), lt_min_i64(p->w, r.x1 + p->pad_w),
    };
}

static lt_conv2d_params params_of_part(const lt_conv2d_params *p, int64_t h, int64_t w)
{
    lt_conv2d_params part = *p;

    part.n = 1, part.h = h, part.w = w;
    return part;
}

/* Elements of the copies of dy and of x, in whose place dx comes first, and of the weights; bytes of the rest */
typedef struct { int64_t dy, x, packed; size_t rest; } room;

static int64_t aligned(int64_t n)
{
    return lt_ceil_div(n, LT_ALIGN) * LT_ALIGN;
}

static room room_of(const lt_conv2d_params *part)
{
    const size_t data = lt_conv2d_backward_data_work(part), weights = lt_conv2d_weights_work(part);
    const int64_t positions = part->h * part->w;

    return (room){
        aligned(part->o * positions), aligned(part->c * positions), aligned(lt_conv2d_data_packed(part)),
        data > weights ? data : weights,
    };
}

bool lt_conv2d_keeps_size(const lt_conv2d_params *p)
{
    return p->stride_h == 1 && p->stride_w == 1 && lt_conv2d_out_h(p) == p->h && lt_conv2d_out_w(p) == p->w;
}

size_t lt_conv2d_backward_rect_work(const lt_conv2d_params *p)
{
    size_t most = 0;

    for (int64_t h = 1; h <= p->h; h++)
        for (int64_t w = 1; w <= p->w; w++) {
            const lt_conv2d_params part = params_of_part(p, h, w);
            const room r = room_of(&part);
            const size_t bytes = (size_t)(r.dy + r.x + r.packed) * sizeof(lt_real) + r.rest;

            most = bytes > most ? bytes : most;
        }
    return most;
}

void lt_conv2d_backward_rect(const lt_conv2d_params *p, lt_rect r, const lt_real *x, const lt_real *weights,
                             const lt_real *dy, const lt_conv2d_gradients *to, void *work)
{
    const lt_rect g = reached(p, r);
    const lt_conv2d_params part = params_of_part(p, g.y1 - g.y0, g.x1 - g.x0);
    const room n = room_of(&part);
    lt_real *part_dy = work, *part_x = part_dy + n.dy, *packed = part_x + n.x;
    void *rest = packed + n.packed;
    cutting c = { p->h, p->w, g, r, (lt_real *)dy, part_dy };

    if (r.y0 >= r.y1 || r.x0 >= r.x1)
        return;
    lt_parallel_for(p->o, take_plane, &c);
    if (to->bias)
        lt_conv2d_backward_bias(&part, part_dy, to->bias);
    c = (cutting){ p->h, p->w, g, g, to->x, part_x };
    if (to->x) {
        lt_conv2d_data_pack(&part, weights, packed);
        lt_conv2d_backward_data(&part, part_dy, packed, false, part_x, rest);
        lt_parallel_for(p->c, add_plane, &c);
    }
    c.map = (lt_real *)x;
    if (to->weights) {
        lt_parallel_for(p->c, take_plane, &c);
        lt_conv2d_backward_weights(&part, part_x, part_dy, true, to->weights, rest);
    }
}
