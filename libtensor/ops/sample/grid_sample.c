/* SPDX-License-Identifier: Apache-2.0 */
/* grid_sample: bilinear samples of a map at given places, 0 outside       [Jaderberg et al. 2015, section 3.3]
 *   x (B, C, H, W)   grid (B, h, w, 2)   ->   y (B, C, h, w)
 *   a place (u, v) in [-1, 1] is column ((u + 1) W - 1) / 2, row ((v + 1) H - 1) / 2: -1 and 1 are the
 *   outer edges of the first and last cell
 *   dx += the corners' weights times dy      dgrid += (W, H) / 2 times the sum over channels of dy dy/d(u, v)
 *
 * Maps are turned so that the channels of a cell lie side by side: a sample is then four rows, weighed.
 */
#include "libtensor/ops/common.h"

enum { X, GRID };
enum { CHANNELS = 16, PLACES = 64, CORNERS = 4 };

typedef struct {
    int64_t B, C, H, W, P;          /* P places an image */
    int64_t runs, blocks;           /* of channels, of places */
} sizes;

static sizes sizes_of(const lt_call *c)
{
    sizes s = {
        .B = lt_dim(c->in[X], 0), .C = lt_dim(c->in[X], 1), .H = lt_dim(c->in[X], 2), .W = lt_dim(c->in[X], 3),
        .P = lt_dim(c->in[GRID], 1) * lt_dim(c->in[GRID], 2),
    };

    s.runs = lt_ceil_div(s.C, CHANNELS);
    s.blocks = lt_ceil_div(s.P, PLACES);
    return s;
}

static lt_status infer(lt_call *c)
{
    const lt_tensor *x = c->in[X], *grid = c->in[GRID];

    if (lt_want_rank(c, X, "map", 4) || lt_want_rank(c, GRID, "grid", 4)
        || lt_want_shape(c, GRID, "grid", LT_SHAPE(lt_dim(x, 0), lt_dim(grid, 1), lt_dim(grid, 2), 2)))
        return LT_ESHAPE;
    if (lt_dim(x, 2) < 1 || lt_dim(x, 3) < 1)
        return lt_fail(c, "the map is empty");
    c->out->shape = LT_SHAPE(lt_dim(x, 0), lt_dim(x, 1), lt_dim(grid, 1), lt_dim(grid, 2));
    return LT_OK;
}

static int64_t turned(const sizes *s)
{
    return s->B * s->runs * CHANNELS * s->H * s->W;
}

/* work: the maps, turned run by run; in backward their gradients likewise */
static void plan(lt_call *c)
{
    const sizes s = sizes_of(c);

    c->work_bytes = (size_t)(turned(&s) * (c->train ? 2 : 1)) * sizeof(lt_real);
}

/* Run `run` of image b: its first channel, how many, and its turned map in `maps`. */
typedef struct {
    int64_t first, n;
    lt_real *map;
} channel_run;

static channel_run run_of(const sizes *s, lt_real *maps, int64_t b, int64_t run)
{
    const int64_t first = run * CHANNELS;

    return (channel_run){ first, lt_min_i64(CHANNELS, s->C - first),
                          maps + (b * s->runs + run) * CHANNELS * s->H * s->W };
}

static void turn_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const sizes s = sizes_of(c);
    const int64_t b = task / s.runs, cells = s.H * s.W;
    const channel_run r = run_of(&s, c->work, b, task % s.runs);

    lt_k->turn(r.map, CHANNELS, (const lt_real *)c->in[X]->data + (b * s.C + r.first) * cells, cells, r.n, cells,
               false);
}

/* ---- some places of an image ---------------------------------------------------------------------------- */

typedef struct {
    int64_t b, first, rows;
    lt_real x[PLACES], y[PLACES];
    int32_t at[CORNERS][PLACES];
    lt_real weight[CORNERS][PLACES];
} places;

static void look(const lt_call *c, const sizes *s, int64_t b, int64_t block, places *p)
{
    const lt_real *grid;

    p->b = b;
    p->first = block * PLACES;
    p->rows = lt_min_i64(PLACES, s->P - p->first);
    grid = (const lt_real *)c->in[GRID]->data + 2 * (b * s->P + p->first);
    for (int64_t i = 0; i < p->rows; i++) {
        p->x[i] = ((grid[2 * i] + 1) * (lt_real)s->W - 1) / 2;
        p->y[i] = ((grid[2 * i + 1] + 1) * (lt_real)s->H - 1) / 2;
    }
    lt_k->corners(p->at[0], p->weight[0], PLACES, p->x, p->y, s->H, s->W, (size_t)p->rows);
}

static lt_samples samples_of(const places *p, const channel_run *r)
{
    return (lt_samples){
        .x = r->map, .ldx = CHANNELS, .d = r->n, .rows = p->rows, .taps = CORNERS, .stride = PLACES,
        .at = p->at[0], .weight = p->weight[0],
    };
}

/* ---- forward -------------------------------------------------------------------------------------------- */

static void forward_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const sizes s = sizes_of(c);
    places p;

    look(c, &s, task / s.blocks, task % s.blocks, &p);
    for (int64_t run = 0; run < s.runs; run++) {
        const channel_run r = run_of(&s, c->work, p.b, run);
        const lt_samples samples = samples_of(&p, &r);
        lt_real tile[PLACES * CHANNELS];

        lt_k->sample(tile, CHANNELS, &samples);
        lt_k->turn((lt_real *)c->out->data + (p.b * s.C + r.first) * s.P + p.first, s.P, tile, CHANNELS, p.rows,
                   r.n, false);
    }
}

static void forward(const lt_call *c)
{
    const sizes s = sizes_of(c);

    if (s.P == 0)
        return;
    lt_parallel_for(s.B * s.runs, turn_task, (void *)c);
    lt_parallel_for(s.B * s.blocks, forward_task, (void *)c);
}

/* ---- backward ------------------------------------------------------------------------------------------- */

/* dy of these places, with the channels of a run side by side */
static void turn_dy(const lt_call *c, const sizes *s, const places *p, const channel_run *r, lt_real *tile)
{
    lt_k->turn(tile, CHANNELS, c->dout + (p->b * s->C + r->first) * s->P + p->first, s->P, r->n, p->rows, false);
}

static void grid_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const sizes s = sizes_of(c);
    lt_real dot[CORNERS][PLACES] = { { 0 } }, value[PLACES], dx[PLACES], dy[PLACES], *out;
    places p;

    look(c, &s, task / s.blocks, task % s.blocks, &p);
    for (int64_t run = 0; run < s.runs; run++) {
        const channel_run r = run_of(&s, c->work, p.b, run);
        const lt_samples samples = samples_of(&p, &r);
        lt_real tile[PLACES * CHANNELS];

        turn_dy(c, &s, &p, &r, tile);
        lt_k->sample_dots(dot[0], tile, CHANNELS, &samples);
    }
    lt_k->corners_grad(dx, dy, value, PLACES, dot[0], p.x, p.y, s.H, s.W, (size_t)p.rows);
    out = c->din[GRID] + 2 * (p.b * s.P + p.first);
    for (int64_t i = 0; i < p.rows; i++) {
        out[2 * i] += dx[i] * (lt_real)s.W / 2;
        out[2 * i + 1] += dy[i] * (lt_real)s.H / 2;
    }
}

/* A task owns a run of channels of an image and takes the places in their order. */
static void map_task(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const sizes s = sizes_of(c);
    const int64_t b = task / s.runs, cells = s.H * s.W;
    const channel_run r = run_of(&s, (lt_real *)c->work + turned(&s), b, task % s.runs);

    memset(r.map, 0, (size_t)(CHANNELS * cells) * sizeof(*r.map));
    for (int64_t block = 0; block < s.blocks; block++) {
        lt_real tile[PLACES * CHANNELS];
        lt_samples samples;
        places p;

        look(c, &s, b, block, &p);
        samples = samples_of(&p, &r);
        turn_dy(c, &s, &p, &r, tile);
        lt_k->sample_spread(r.map, tile, CHANNELS, &samples);
    }
    lt_k->turn(c->din[X] + (b * s.C + r.first) * cells, cells, r.map, CHANNELS, cells, r.n, true);
}

static void backward(const lt_call *c)
{
    const sizes s = sizes_of(c);

    if (s.P == 0)
        return;
    if (c->din[X])
        lt_parallel_for(s.B * s.runs, map_task, (void *)c);
    if (!c->din[GRID])
        return;
    lt_parallel_for(s.B * s.runs, turn_task, (void *)c);
    lt_parallel_for(s.B * s.blocks, grid_task, (void *)c);
}

static int64_t macs(const lt_call *c)
{
    return CORNERS * lt_numel(c->out);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    lt_onnx_same(w, n, "GridSample");
    lt_onnx_text_of(w, "mode", "bilinear");
    lt_onnx_text_of(w, "padding_mode", "zeros");
    lt_onnx_int(w, "align_corners", 0);
}

static const lt_op grid_sample_op = {
    .name = "grid_sample", .keeps = LT_KEEP_IN(X) | LT_KEEP_IN(GRID), .infer = infer, .plan = plan,
    .forward = forward, .backward = backward, .macs = macs, .onnx = onnx,
};

lt_tensor *(lt_grid_sample)(lt_tensor *x, lt_tensor *grid)
{
    return lt_apply(&grid_sample_op, NULL, 0, (lt_tensor *[]){ x, grid }, 2);
}
