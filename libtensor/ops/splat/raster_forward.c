/* SPDX-License-Identifier: Apache-2.0 */
/* Drawing: to the screen by blocks, into lists, tile by tile. */
#include "libtensor/ops/splat/raster.h"

typedef struct {
    const lt_call *c;
    raster_frame *f;
    lt_splat_view view;
} drawing;

/* ---- memory --------------------------------------------------------------------------------------------- */

size_t raster_frame_bytes(const lt_call *c)
{
    const lt_splat_opts *o = raster_opts(c);
    const int64_t n = lt_dim(c->in[RASTER_CENTRE], 0);
    const int64_t tiles = lt_ceil_div(o->width, LT_SPLAT_TILE) * lt_ceil_div(o->height, LT_SPLAT_TILE);

    return (size_t)op_aligned(sizeof(raster_frame)) + lt_splat_lists_bytes(n, o->width, o->height)
        + (size_t)n * sizeof(lt_splat_seen) + (size_t)tiles * sizeof(*((raster_frame *)0)->state);
}

static raster_frame *new_frame(const lt_call *c)
{
    const lt_splat_opts *o = raster_opts(c);
    const int64_t n = lt_dim(c->in[RASTER_CENTRE], 0);
    raster_frame *f = c->train ? c->saved[0] : c->work;
    char *next = (char *)f + op_aligned(sizeof(*f));

    f->lists = lt_splat_lists_in(next, n, o->width, o->height);
    next += lt_splat_lists_bytes(n, o->width, o->height);
    f->seen = (void *)next;
    f->state = (void *)(f->seen + n);
    return f;
}

/* ---- to the screen -------------------------------------------------------------------------------------- */

static void project_block(void *ctx, int64_t block)
{
    const drawing *d = ctx;
    const lt_splat_cloud cloud = raster_cloud(d->c);
    const int64_t at = block * RASTER_BLOCK, n = lt_min_i64(RASTER_BLOCK, cloud.n - at);
    lt_splat_seen *seen = d->f->seen + at;
    lt_real *radius = (lt_real *)d->c->outs[RASTER_RADIUS]->data + at;

    lt_k->splat.project(seen, radius, &cloud, &d->view, at, n);
    for (int64_t i = 0; i < n; i++) {
        d->f->lists.covers[at + i] = lt_splat_covers(&seen[i], &d->view);
        radius[i] = d->f->lists.covers[at + i] ? radius[i] : 0;
    }
}

/* ---- tile by tile --------------------------------------------------------------------------------------- */

/* Where the pixels of a tile go */
typedef struct {
    const lt_splat_opts *o;
    const lt_splat_tile *t;
    lt_real *image;
} picture;

static void put_channel(const picture *p, int channel, const lt_real value[LT_SPLAT_CELLS])
{
    const int64_t x0 = (int64_t)p->t->x0, y0 = (int64_t)p->t->y0, W = p->o->width, H = p->o->height;
    const size_t n = (size_t)lt_min_i64(LT_SPLAT_TILE, W - x0);

    for (int64_t y = y0; y < lt_min_i64(H, y0 + LT_SPLAT_TILE); y++)
        memcpy(p->image + (channel * H + y) * W + x0, value + (y - y0) * LT_SPLAT_TILE, n * sizeof(*value));
}

/* colour, and b if there is one, + light * background */
static void put_colour(const picture *p, int channel, const lt_real *a, const lt_real *b, const lt_real *light)
{
    lt_real value[LT_SPLAT_CELLS];

    for (int i = 0; i < LT_SPLAT_CELLS; i++)
        value[i] = a[i] + (b ? b[i] : 0) + (light ? light[i] : 0);
    put_channel(p, channel, value);
}

static void put_images(const picture *p, lt_real (*state)[LT_SPLAT_CELLS])
{
    const raster_channels at = raster_channels_of(p->o);
    const lt_real *white = p->o->white ? state[LT_SPLAT_LIGHT] : NULL;
    lt_real opacity[LT_SPLAT_CELLS];

    for (int i = 0; i < LT_SPLAT_CELLS; i++) {
        state[LT_SPLAT_LIGHT][i] = state[LT_SPLAT_LIGHT][i] < 0 ? -state[LT_SPLAT_LIGHT][i] : state[LT_SPLAT_LIGHT][i];
        opacity[i] = 1 - state[LT_SPLAT_LIGHT][i];
    }
    for (int k = 0; k < 3; k++)
        put_colour(p, at.colour + k, state[LT_SPLAT_SET + k], p->o->sets ? state[LT_SPLAT_OTHER + k] : NULL, white);
    if (at.opacity >= 0)
        put_channel(p, at.opacity, opacity);
    if (at.depth >= 0)
        put_channel(p, at.depth, state[LT_SPLAT_DEPTH]);
    for (int s = 0; p->o->sets && s < 2; s++) {
        const int own = s ? LT_SPLAT_OTHER : LT_SPLAT_SET, other = s ? LT_SPLAT_SET : LT_SPLAT_OTHER;

        for (int k = 0; k < 3; k++)             /* on white the other set is white */
            put_colour(p, at.set_colour + 3 * s + k, state[own + k],
                       white ? state[other + LT_SPLAT_SHARE] : NULL, white);
        put_channel(p, at.set_opacity + s, state[own + LT_SPLAT_SHARE]);
    }
}

static void draw_tile(void *ctx, int64_t task)
{
    const drawing *d = ctx;
    const lt_splat_lists *l = &d->f->lists;
    const int64_t tile = l->longest[task];
    const lt_splat_opts *o = raster_opts(d->c);
    const lt_splat_tile t = raster_tile(d->c, d->f, tile);
    _Alignas(LT_ALIGN) lt_real state[LT_SPLAT_PLANES][LT_SPLAT_CELLS];
    const picture p = { o, &t, d->c->out->data };

    if (l->from > 0) {
        memcpy(state, d->f->state[tile], sizeof(state));
    } else {
        memset(state, 0, sizeof(state));
        raster_start_light(state[LT_SPLAT_LIGHT], o, &t);
    }
    lt_k->splat.blend(state[0], &t);
    if (d->c->train || l->to < l->drawn)
        memcpy(d->f->state[tile], state, sizeof(state));
    if (l->to == l->drawn)
        put_images(&p, state);
}

void raster_forward(const lt_call *c)
{
    drawing d = { c, new_frame(c), raster_view(c) };
    lt_splat_lists *l = &d.f->lists;

    lt_parallel_for(lt_ceil_div(l->n, RASTER_BLOCK), project_block, &d);
    lt_splat_sort(l, d.f->seen);
    do {
        lt_splat_fill(l, d.f->seen, &d.view);
        lt_parallel_for(l->tiles, draw_tile, &d);
    } while (l->to < l->drawn);
    *(lt_real *)c->outs[RASTER_INSTANCES]->data = (lt_real)l->instances;
}
