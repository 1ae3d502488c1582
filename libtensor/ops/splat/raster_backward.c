/* SPDX-License-Identifier: Apache-2.0 */
/* The gradient: tile by tile to instances, their sums to Gaussians, those off the screen again. */
#include "libtensor/ops/splat/raster.h"

/* What a tile that is not finished goes on with */
typedef struct {
    lt_real light[LT_SPLAT_CELLS], rest[LT_SPLAT_CELLS];
} tile_progress;

typedef struct {
    const lt_call *c;
    raster_frame *f;
    lt_splat_view view;
    lt_splat_cloud_grad to;
    tile_progress *progress;                    /* (tiles) */
    lt_real (*slopes)[LT_SPLAT_SLOPES];         /* (capacity) */
} descent;

static lt_splat_lists sizes_of(const lt_call *c)
{
    return lt_splat_lists_in(NULL, lt_dim(c->in[RASTER_CENTRE], 0), raster_opts(c)->width, raster_opts(c)->height);
}

size_t raster_grad_bytes(const lt_call *c)
{
    const lt_splat_lists l = sizes_of(c);

    return (size_t)l.tiles * sizeof(tile_progress) + (size_t)l.capacity * LT_SPLAT_SLOPES * sizeof(lt_real);
}

/* ---- a tile --------------------------------------------------------------------------------------------- */

typedef lt_real (*planes)[LT_SPLAT_CELLS];

/* Adds a channel of the images' gradient; nothing for -1, or outside the image. */
static void add_channel(const lt_call *c, const lt_splat_tile *t, int channel, lt_real sum[LT_SPLAT_CELLS])
{
    const lt_splat_opts *o = raster_opts(c);
    const int64_t x0 = (int64_t)t->x0, y0 = (int64_t)t->y0, n = lt_min_i64(LT_SPLAT_TILE, o->width - x0);

    for (int64_t y = y0; channel >= 0 && y < lt_min_i64(o->height, y0 + LT_SPLAT_TILE); y++)
        lt_k->add_to(sum + (y - y0) * LT_SPLAT_TILE, c->dout + (channel * o->height + y) * o->width + x0, (size_t)n);
}

/* What a weight of 1 gives in set s: its share of all images that it is in. On white the other set's is one of them. */
static void find_gift(const lt_call *c, const lt_splat_tile *t, int s, planes give)
{
    const lt_splat_opts *o = raster_opts(c);
    const raster_channels at = raster_channels_of(o);

    for (int k = 0; k < 3; k++) {
        add_channel(c, t, at.colour + k, give[k]);
        if (o->sets)
            add_channel(c, t, at.set_colour + 3 * s + k, give[k]);
        if (o->sets && o->white)
            add_channel(c, t, at.set_colour + 3 * (1 - s) + k, give[LT_SPLAT_SHARE]);
    }
    add_channel(c, t, at.opacity, give[LT_SPLAT_SHARE]);
    if (o->sets)
        add_channel(c, t, at.set_opacity + s, give[LT_SPLAT_SHARE]);
}

/* What light gives that reaches a white background */
static void find_background(const lt_call *c, const lt_splat_tile *t, lt_real give[LT_SPLAT_CELLS])
{
    const raster_channels at = raster_channels_of(raster_opts(c));

    memset(give, 0, LT_SPLAT_CELLS * sizeof(*give));
    for (int k = 0; raster_opts(c)->white && k < 3; k++) {
        add_channel(c, t, at.colour + k, give);
        for (int s = 0; raster_opts(c)->sets && s < 2; s++)
            add_channel(c, t, at.set_colour + 3 * s + k, give);
    }
}

/* What all that is seen in each pixel gives, from the sums that forward left */
static void find_rest(const lt_call *c, const lt_splat_tile *t, const lt_real (*state)[LT_SPLAT_CELLS], planes grad)
{
    lt_real background[LT_SPLAT_CELLS], *rest = grad[LT_SPLAT_GRAD_REST];

    find_background(c, t, background);
    for (int i = 0; i < LT_SPLAT_CELLS; i++) {
        const lt_real light = state[LT_SPLAT_LIGHT][i] < 0 ? -state[LT_SPLAT_LIGHT][i] : state[LT_SPLAT_LIGHT][i];
        const lt_real share = t->sets ? state[LT_SPLAT_SET + LT_SPLAT_SHARE][i] : 1 - light;

        rest[i] = light * background[i] + share * grad[LT_SPLAT_SHARE][i]
            + state[LT_SPLAT_DEPTH][i] * grad[LT_SPLAT_GRAD_DEPTH][i];
        for (int k = 0; k < 3; k++)
            rest[i] += state[LT_SPLAT_SET + k][i] * grad[k][i];
        for (int k = 0; k < 4; k++)
            rest[i] += state[LT_SPLAT_OTHER + k][i] * grad[LT_SPLAT_GRAD_OTHER + k][i];
    }
}

static void start_tile(const descent *d, const lt_splat_tile *t, int64_t tile, planes grad, lt_real *light)
{
    const lt_splat_lists *l = &d->f->lists;

    memset(grad, 0, LT_SPLAT_GRAD_PLANES * sizeof(*grad));
    for (int s = 0; s < (t->sets ? 2 : 1); s++)
        find_gift(d->c, t, s, grad + s * LT_SPLAT_GRAD_OTHER);
    add_channel(d->c, t, raster_channels_of(raster_opts(d->c)).depth, grad[LT_SPLAT_GRAD_DEPTH]);
    if (l->from > 0) {
        memcpy(light, d->progress[tile].light, sizeof(d->progress[tile].light));
        memcpy(grad[LT_SPLAT_GRAD_REST], d->progress[tile].rest, sizeof(d->progress[tile].rest));
    } else {
        raster_start_light(light, raster_opts(d->c), t);
        find_rest(d->c, t, (const lt_real (*)[LT_SPLAT_CELLS])d->f->state[tile], grad);
    }
}

static void descend_tile(void *ctx, int64_t task)
{
    const descent *d = ctx;
    const lt_splat_lists *l = &d->f->lists;
    const int64_t tile = l->longest[task];
    const lt_splat_tile t = raster_tile(d->c, d->f, tile);
    _Alignas(LT_ALIGN) lt_real grad[LT_SPLAT_GRAD_PLANES][LT_SPLAT_CELLS], light[LT_SPLAT_CELLS];

    if (t.n == 0 && l->from == 0 && l->to == l->drawn)
        return;
    start_tile(d, &t, tile, grad, light);
    lt_k->splat.blend_grad(d->slopes, light, grad[0], &t);
    if (l->to < l->drawn) {
        memcpy(d->progress[tile].light, light, sizeof(light));
        memcpy(d->progress[tile].rest, grad[LT_SPLAT_GRAD_REST], sizeof(light));
    }
}

/* ---- Gaussians ------------------------------------------------------------------------------------------ */

/* A block of the order of depth: the instances of each in the order of tiles */
static void gather_block(void *ctx, int64_t block)
{
    const descent *d = ctx;
    const lt_splat_lists *l = &d->f->lists;
    const int64_t at = l->from + block * RASTER_BLOCK, n = lt_min_i64(RASTER_BLOCK, l->to - at);
    const lt_splat_cloud cloud = raster_cloud(d->c);
    lt_real sums[RASTER_BLOCK][LT_SPLAT_SLOPES];

    for (int64_t i = 0; i < n; i++) {
        const uint32_t g = l->order[at + i], first = l->instance[g];

        memcpy(sums[i], d->slopes[first], sizeof(sums[i]));
        for (uint32_t k = 1; k < l->covers[g]; k++)
            for (int j = 0; j < LT_SPLAT_SLOPES; j++)
                sums[i][j] += d->slopes[first + k][j];
    }
    lt_k->splat.project_grad(&d->to, &cloud, &d->view, l->order + at, (const lt_real (*)[LT_SPLAT_SLOPES])sums, n);
}

/* Lists that held everything still do. */
static void refill(const descent *d)
{
    lt_splat_lists *l = &d->f->lists;

    if (l->from == 0 && l->to == l->drawn)
        return;
    l->to = 0;
    lt_splat_fill(l, d->f->seen, &d->view);
}

void raster_backward(const lt_call *c)
{
    descent d = {
        .c = c, .f = c->saved[0], .view = raster_view(c),
        .to = { c->din[RASTER_CENTRE], c->din[RASTER_AXES], c->din[RASTER_OPACITY], c->din[RASTER_COLOUR],
                c->din[RASTER_OFFSET] },
        .progress = c->work,
    };
    lt_splat_lists *l = &d.f->lists;

    if (!c->dout)                       /* nobody asks for more than radii */
        return;
    d.slopes = (void *)(d.progress + l->tiles);
    for (refill(&d);; lt_splat_fill(l, d.f->seen, &d.view)) {
        lt_parallel_for(l->tiles, descend_tile, &d);
        lt_parallel_for(lt_ceil_div(l->to - l->from, RASTER_BLOCK), gather_block, &d);
        if (l->to == l->drawn)
            break;
    }
}
