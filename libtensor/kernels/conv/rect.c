/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The gradients of a convolution of which only a rectangle of each image's result counts: the rectangles, and what
 * windows reach around them, are stacked in one high map with zeros between them, which goes the way of any other.
 */
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv/internal.h"

#include <string.h>

/* An image's part of the stack: g of its map, of which dy has r alone, from row `at` of the stack on. */
typedef struct {
    lt_rect r, g;
    int64_t at;
} piece;

typedef struct {
    const lt_conv2d_params *p;
    const piece *piece;
    lt_conv2d_params high;      /* the stack: one image */
    bool around;                /* take all of g, not r alone */
    int64_t channels;
    lt_real *maps, *stack;      /* (n, channels, h, w); (channels, h, w) of the stack */
} stacking;

static void take_plane(void *ctx, int64_t channel)
{
    const stacking *s = ctx;
    const int64_t n = s->high.h * s->high.w;
    lt_real *to = s->stack + channel * n;

    memset(to, 0, (size_t)n * sizeof(lt_real));
    for (int64_t i = 0; i < s->p->n; i++) {
        const piece *c = &s->piece[i];
        const lt_rect part = s->around ? c->g : c->r;
        const lt_real *map = s->maps + (i * s->channels + channel) * s->p->h * s->p->w;

        for (int64_t y = part.y0; y < part.y1; y++)
            memcpy(to + (c->at + y - c->g.y0) * s->high.w + part.x0 - c->g.x0, map + y * s->p->w + part.x0,
                   (size_t)(part.x1 - part.x0) * sizeof(lt_real));
    }
}

static void add_plane(void *ctx, int64_t channel)
{
    const stacking *s = ctx;
    const lt_real *from = s->stack + channel * s->high.h * s->high.w;

    for (int64_t i = 0; i < s->p->n; i++) {
        const piece *c = &s->piece[i];
        lt_real *map = s->maps + (i * s->channels + channel) * s->p->h * s->p->w;

        for (int64_t y = c->g.y0; y < c->g.y1; y++)
            lt_k->add_to(map + y * s->p->w + c->g.x0, from + (c->at + y - c->g.y0) * s->high.w,
                         (size_t)(c->g.x1 - c->g.x0));
    }
}

/* r and as far around it as windows reach, clipped to the map */
static lt_rect reached(const lt_conv2d_params *p, lt_rect r)
{
    return (lt_rect){
        lt_max_i64(0, r.y0 - p->pad_h), lt_min_i64(p->h, r.y1 + p->pad_h),
        lt_max_i64(0, r.x0 - p->pad_w), lt_min_i64(p->w, r.x1 + p->pad_w),
    };
}

static lt_conv2d_params params_of_stack(const lt_conv2d_params *p, int64_t h, int64_t w)
{
    lt_conv2d_params high = *p;

    high.n = 1, high.h = h, high.w = w;
    return high;
}

/* Where each rectangle goes; an empty one goes nowhere. A stack of nothing is empty. */
static lt_conv2d_params stack(const lt_conv2d_params *p, const lt_rect *r, piece *out)
{
    int64_t h = 0, w = 0;

    for (int64_t i = 0; i < p->n; i++) {
        out[i] = (piece){ .at = h };
        if (r[i].y0 >= r[i].y1 || r[i].x0 >= r[i].x1)
            continue;
        out[i].r = r[i];
        out[i].g = reached(p, r[i]);
        h += out[i].g.y1 - out[i].g.y0 + p->pad_h;
        w = lt_max_i64(w, out[i].g.x1 - out[i].g.x0);
    }
    return params_of_stack(p, h, w);
}

/* Elements of the stacks of dy and of x, in whose place dx comes first, and of the weights; bytes of the rest */
typedef struct { int64_t dy, x, packed; size_t rest; } room;

static int64_t aligned(int64_t n)
{
    return lt_ceil_div(n, LT_ALIGN) * LT_ALIGN;
}

static room room_of(const lt_conv2d_params *high)
{
    const size_t data = lt_conv2d_backward_data_work(high), weights = lt_conv2d_weights_work(high);

    return (room){
        aligned(high->o * high->h * high->w), aligned(high->c * high->h * high->w),
        aligned(lt_conv2d_data_packed(high)), data > weights ? data : weights,
    };
}

static int64_t pieces_bytes(const lt_conv2d_params *p)
{
    return aligned(p->n * (int64_t)sizeof(piece));
}

bool lt_conv2d_stacks_rects(const lt_conv2d_params *p)
{
    return !conv_pointwise(p) && p->stride_h == 1 && p->stride_w == 1 && lt_conv2d_out_h(p) == p->h
           && lt_conv2d_out_w(p) == p->w;
}

size_t lt_conv2d_backward_rects_work(const lt_conv2d_params *p)
{
    size_t most = 0;

    for (int64_t h = 1; h <= p->n * (p->h + p->pad_h); h++)
        for (int64_t w = 1; w <= p->w; w++) {
            const lt_conv2d_params high = params_of_stack(p, h, w);
            const room r = room_of(&high);
            const size_t bytes = (size_t)(r.dy + r.x + r.packed) * sizeof(lt_real) + r.rest;

            most = bytes > most ? bytes : most;
        }
    return (size_t)pieces_bytes(p) + most;
}

void lt_conv2d_backward_rects(const lt_conv2d_params *p, const lt_rect *r, const lt_real *x, const lt_real *weights,
                              const lt_real *dy, const lt_conv2d_gradients *to, void *work)
{
    stacking s = { .p = p, .piece = work, .high = stack(p, r, work) };
    const room n = room_of(&s.high);
    lt_real *high_dy = (lt_real *)(void *)((char *)work + pieces_bytes(p)), *high_x = high_dy + n.dy;
    lt_real *packed = high_x + n.x;
    void *rest = packed + n.packed;

    if (!s.high.h)
        return;
    s.channels = p->o, s.maps = (lt_real *)dy, s.stack = high_dy;
    lt_parallel_for(p->o, take_plane, &s);
    if (to->bias)
        lt_conv2d_backward_bias(&s.high, high_dy, to->bias);
    s.channels = p->c, s.maps = to->x, s.stack = high_x;
    if (to->x) {
        lt_conv2d_data_pack(&s.high, weights, packed);
        lt_conv2d_backward_data(&s.high, high_dy, packed, false, high_x, rest);
        lt_parallel_for(p->c, add_plane, &s);
    }
    s.maps = (lt_real *)x, s.around = true;
    if (to->weights) {
        lt_parallel_for(p->c, take_plane, &s);
        lt_conv2d_backward_weights(&s.high, high_x, high_dy, true, to->weights, rest);
    }
}
