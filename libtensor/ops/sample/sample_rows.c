/* SPDX-License-Identifier: Apache-2.0 */
/* sample_rows: bilinear samples of a map whose cells are rows, 0 outside it.
 *   map (B, h w, C)   place (B, N, 2): column and row, a cell's centre being a whole number   ->   y (B, N, C)
 *   dmap[cell] += weight dy        by image and some channels, in the order of places, which are constants
 */
#include "libtensor/ops/common.h"

enum { MAP, PLACE };
enum { BLOCK = 64, CORNERS = 4, CHANNELS = 32 };    /* places at a time; channels of a task of the gradient */

typedef struct { int h, w; } sample_rows_attr;

static lt_status infer(lt_call *c)
{
    const sample_rows_attr *a = c->attr;
    char text[LT_SHAPE_TEXT];

    if (lt_want_rank(c, MAP, "map", 3) || lt_want_rank(c, PLACE, "places", 3))
        return LT_ESHAPE;
    if (a->h < 1 || a->w < 1 || (int64_t)a->h * a->w != lt_dim(c->in[MAP], 1))
        return lt_fail(c, "the map has %lld cells, want those of %d x %d", (long long)lt_dim(c->in[MAP], 1), a->h,
                       a->w);
    if (lt_dim(c->in[PLACE], 0) != lt_dim(c->in[MAP], 0) || lt_dim(c->in[PLACE], 2) != 2)
        return lt_fail(c, "places are %s, want (%lld, places, 2)", lt_shape_text(&c->in[PLACE]->shape, text),
                       (long long)lt_dim(c->in[MAP], 0));
    c->out->shape = LT_SHAPE(lt_dim(c->in[MAP], 0), lt_dim(c->in[PLACE], 1), lt_dim(c->in[MAP], 2));
    return LT_OK;
}

static int64_t blocks_of(const lt_call *c)
{
    return lt_ceil_div(lt_dim(c->in[PLACE], 1), BLOCK);
}

typedef struct {
    lt_real place[2 * BLOCK], weight[CORNERS * BLOCK];
    int32_t at[CORNERS * BLOCK];
} looked;

/* Block `block` of image b, channels from `channel` on, d of them */
static lt_samples look(const lt_call *c, int64_t b, int64_t block, int64_t channel, int64_t d, looked *k)
{
    const sample_rows_attr *a = c->attr;
    const int64_t N = lt_dim(c->in[PLACE], 1), n = lt_min_i64(BLOCK, N - block * BLOCK), C = lt_dim(c->in[MAP], 2);

    lt_k->turn(k->place, BLOCK, (const lt_real *)c->in[PLACE]->data + 2 * (b * N + block * BLOCK), 2, n, 2, false);
    lt_k->corners(k->at, k->weight, BLOCK, k->place, k->place + BLOCK, a->h, a->w, (size_t)n);
    return (lt_samples){
        .x = (const lt_real *)c->in[MAP]->data + b * lt_dim(c->in[MAP], 1) * C + channel, .ldx = C, .d = d, .rows = n,
        .taps = CORNERS, .stride = BLOCK, .at = k->at, .weight = k->weight,
    };
}

/* Where the block's first place has this channel, in y */
static int64_t row_at(const lt_call *c, int64_t b, int64_t block, int64_t channel)
{
    return (b * lt_dim(c->out, 1) + block * BLOCK) * lt_dim(c->out, 2) + channel;
}

static void forward_block(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const int64_t b = task / blocks_of(c), block = task % blocks_of(c), C = lt_dim(c->out, 2);
    looked k;
    const lt_samples s = look(c, b, block, 0, C, &k);

    lt_k->sample((lt_real *)c->out->data + row_at(c, b, block, 0), C, &s);
}

static void forward(const lt_call *c)
{
    lt_parallel_for(lt_dim(c->out, 0) * blocks_of(c), forward_block, (void *)c);
}

static int64_t slices_of(const lt_call *c)
{
    return lt_ceil_div(lt_dim(c->out, 2), CHANNELS);
}

static void backward_slice(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const int64_t b = task / slices_of(c), channel = task % slices_of(c) * CHANNELS, C = lt_dim(c->out, 2);
    const int64_t d = lt_min_i64(CHANNELS, C - channel), cells = lt_dim(c->in[MAP], 1);
    lt_real *dmap = c->din[MAP] + b * cells * C + channel;
    looked k;

    for (int64_t i = 0; i < cells; i++)
        op_start(c, MAP, (b * cells + i) * C + channel, d);
    for (int64_t block = 0; block < blocks_of(c); block++) {
        const lt_samples s = look(c, b, block, channel, d, &k);

        lt_k->sample_spread(dmap, c->dout + row_at(c, b, block, channel), C, &s);
    }
}

static void backward(const lt_call *c)
{
    if (c->din[MAP])
        lt_parallel_for(lt_dim(c->out, 0) * slices_of(c), backward_slice, (void *)c);
}

static int64_t macs(const lt_call *c)
{
    return lt_numel(c->out) * CORNERS;
}

static const lt_op sample_rows_op = {
    .name = "sample_rows", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(MAP) | LT_KEEP_IN(PLACE), .infer = infer,
    .forward = forward, .backward = backward, .macs = macs,
};

lt_tensor *(lt_sample_rows)(lt_tensor *map, lt_tensor *place, int h, int w)
{
    const sample_rows_attr a = { h, w };

    return lt_apply(&sample_rows_op, &a, sizeof(a), (lt_tensor *[]){ map, place }, 2);
}
