/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/blocks/tiles.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/blocks/conv.h"
#include "libtensor/kernels/conv/internal.h"

#include <string.h>

/*
 * A task makes some columns of y of a band of positions, or of the bands of some small images: it packs its part of x
 * by chunks of channels, whose sums it adds up. A window of one tap reads positions as they come. Otherwise rows and
 * columns of x with its padding are dealt to as many phases as steps, so that taps move by whole positions, and rows of
 * a phase follow each other: where one ends, a few positions are computed that y has not.
 */
enum {
    POSITIONS = 128,            /* of a task, about; and the fewest for which tiles' larger weights are worth reading */
    MANY_WEIGHTS = 1 << 18,     /* from here on twice as many */
    OUTPUTS = 128,              /* at least, for each reading of x, where tasks would be few */
    TASKS = 8,
    ROOM = LT_SCRATCH_A - LT_TILES_SIDE * LT_TILES_ROW,     /* for packed x: tiles read past its end */
};

typedef struct {
    const lt_conv2d_params *p;
    const lt_real *x, *packed;
    const lt_conv2d_around *around;
    lt_real *y;
    bool point;
    int64_t out_h, out_w, pairs, taps;      /* pairs of blocks of channels */
    int64_t units;                          /* of an image: positions of a point, else rows of y */
    int64_t wide;                           /* positions of a row of a phase */
    int64_t band, bands;                    /* units of a task; tasks of an image */
    int64_t images;                         /* of a task */
    int64_t outputs, groups;                /* of a task; tasks of a band */
} tiles_job;

static int64_t rows_of_phase(const tiles_job *j, int64_t rows)
{
    return rows + (j->p->kh - 1) * j->p->dil_h / j->p->stride_h;
}

/* Of one image's band: positions of packed x, and of the product */
static int64_t positions_read(const tiles_job *j, int64_t units)
{
    return j->point ? units : j->p->stride_h * j->p->stride_w * rows_of_phase(j, units) * j->wide;
}

static int64_t positions_made(const tiles_job *j, int64_t units)
{
    return j->point ? units : (units - 1) * j->wide + j->out_w;
}

static tiles_job plan(const lt_conv2d_params *p)
{
    tiles_job j = {
        .p = p, .point = p->kh == 1 && p->kw == 1 && !p->pad_h && !p->pad_w, .taps = (int64_t)p->kh * p->kw,
        .out_h = lt_conv2d_out_h(p), .out_w = lt_conv2d_out_w(p), .pairs = lt_ceil_div(p->c, LT_TILES_SIDE),
    };
    const int64_t positions = p->c * p->o * j.taps < MANY_WEIGHTS ? POSITIONS : 2 * POSITIONS;
    int64_t most, parts;

    j.wide = j.out_w + (p->kw - 1) * p->dil_w / p->stride_w;
    j.units = j.point ? j.out_h * j.out_w : j.out_h;
    most = lt_max_i64(1, j.point ? positions : positions / j.wide);
    j.band = lt_tile_size(j.units, most, j.point ? LT_TILES_SIDE : 1);
    j.bands = lt_ceil_div(j.units, j.band);
    j.images = lt_tile_size(p->n, lt_max_i64(1, positions / positions_made(&j, j.units)), 1);
    parts = lt_ceil_div(p->n, j.images) * j.bands;
    j.groups = lt_max_i64(1, lt_min_i64(lt_ceil_div(TASKS, parts), p->o / OUTPUTS));
    most = lt_ceil_div(lt_ceil_div(p->o, j.groups), LT_TILES_SIDE);
    if (!j.point)
        most = lt_min_i64(most, LT_SCRATCH_B / (j.images * positions_made(&j, j.band) * LT_TILES_SIDE));
    j.outputs = lt_max_i64(1, most) * LT_TILES_SIDE;
    j.groups = lt_ceil_div(p->o, j.outputs);
    return j;
}

/* Channels are made up to whole blocks of tiles: up to an eighth more of them. */
static bool fills_tiles(const lt_conv2d_params *p)
{
    const int64_t c = lt_ceil_div(p->c, LT_TILES_SIDE) * LT_TILES_SIDE;
    const int64_t o = lt_ceil_div(p->o, LT_TILES_SIDE) * LT_TILES_SIDE;

    return 7 * c * o <= 8 * p->c * p->o;
}

bool lt_conv_tiles_suits(const lt_conv2d_params *p)
{
    enum { FEW = 64, LITTLE = 1 << 24 };        /* channels; multiplications */
    int64_t positions;
    tiles_job j;

    if (!lt_k->gemm_tiles || p->groups > 1 || p->c < FEW || p->o < FEW || conv_nothing(p) || !fills_tiles(p))
        return false;
    positions = p->n * lt_conv2d_out_h(p) * lt_conv2d_out_w(p);
    if (positions < POSITIONS || positions * p->c * p->o * p->kh * p->kw < LITTLE)
        return false;
    j = plan(p);
    return j.images * positions_read(&j, j.band) * LT_TILES_ROW <= ROOM
           && j.images * positions_made(&j, j.band) * LT_TILES_SIDE <= LT_SCRATCH_B;
}

/* ---- weights: panels of 32 outputs, [pair of blocks][tap][LT_TILES_BLOCK] ------------------------------ */

static int64_t panel_elements(const lt_conv2d_params *p)
{
    return lt_ceil_div(p->c, LT_TILES_SIDE) * p->kh * p->kw * LT_TILES_BLOCK;
}

int64_t lt_conv_tiles_packed(const lt_conv2d_params *p)
{
    return lt_ceil_div(p->o, LT_TILES_SIDE) * panel_elements(p);
}

typedef struct { const lt_conv2d_params *p; const lt_real *weights; lt_real *packed; } pack_job;

static void pack_panel(void *ctx, int64_t panel)
{
    const pack_job *j = ctx;
    const int64_t taps = (int64_t)j->p->kh * j->p->kw, c = j->p->c, o = panel * LT_TILES_SIDE;
    const int64_t n = lt_min_i64(LT_TILES_SIDE, j->p->o - o);
    _Alignas(LT_ALIGN) lt_real block[LT_TILES_SIDE * LT_TILES_SIDE];
    lt_real *out = j->packed + panel * panel_elements(j->p);

    for (int64_t l = 0; l < c; l += LT_TILES_SIDE)
        for (int64_t t = 0; t < taps; t++, out += LT_TILES_BLOCK) {
            const int64_t k = lt_min_i64(LT_TILES_SIDE, c - l);

            lt_k->pack_b(block, j->weights + (o * c + l) * taps + t, taps, c * taps, k, n);
            lt_k->tiles_right(out, 0, block, LT_TILES_SIDE, k, n);
        }
}

void lt_conv_tiles_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed)
{
    pack_job j = { p, weights, packed };

    lt_parallel_for(lt_ceil_div(p->o, LT_TILES_SIDE), pack_panel, &j);
}

/* ---- x ---------------------------------------------------------------------------------------------------- */

/* What a task does: images and units from the first on, outputs likewise */
typedef struct {
    const tiles_job *j;
    int64_t image, images, unit, units, output, outputs;
    int64_t read, made;
} tiles_task;

/* n positions of a pair of blocks, `step` positions of the map apart */
static void pack_run(const tiles_task *t, lt_real *out, int64_t image, int64_t pair, int64_t position, int64_t step,
                     int64_t n)
{
    const lt_conv2d_params *p = t->j->p;
    const int64_t block = p->h * p->w * LT_BLOCK, blocks = lt_blocks_of(p->c), c = pair * LT_TILES_SIDE;
    const lt_real *gate = t->j->around->gate, *x = t->j->x + (image * blocks + 2 * pair) * block;
    const int64_t there = gate ? p->c - c : lt_min_i64(2, blocks - 2 * pair) * LT_BLOCK;

    lt_k->tiles_left(out, x + position * LT_BLOCK, block, step * LT_BLOCK, lt_min_i64(LT_TILES_SIDE, there), n,
                     gate ? gate + image * p->c + c : NULL);
}

static void pack_nothing(lt_real *out, int64_t n)
{
    memset(out, 0, (size_t)(n * LT_TILES_ROW) * sizeof(*out));
}

/* Positions of y in a row, from unit on, of a window of one tap */
static void pack_point(const tiles_task *t, lt_real *out, int64_t image, int64_t pair)
{
    const lt_conv2d_params *p = t->j->p;
    const int64_t end = t->unit + t->units, w = conv_pointwise(p) ? t->j->units : t->j->out_w;

    for (int64_t at = t->unit; at < end; ) {
        const int64_t row = at / w, col = at % w, n = lt_min_i64(w - col, end - at);

        pack_run(t, out, image, pair, row * p->stride_h * p->w + col * p->stride_w, p->stride_w, n);
        out += n * LT_TILES_ROW;
        at += n;
    }
}

/* Columns from, from + step ... of a row of the map, or of none */
static void pack_row(const tiles_task *t, lt_real *out, int64_t image, int64_t pair, int64_t row, int64_t from)
{
    const lt_conv2d_params *p = t->j->p;
    const int64_t step = p->stride_w, wide = t->j->wide;
    const int64_t left = lt_min_i64(wide, lt_max_i64(0, lt_ceil_div(-from, step)));
    const int64_t right = lt_max_i64(left, lt_min_i64(wide, lt_ceil_div(p->w - from, step)));

    if (row < 0 || row >= p->h) {
        pack_nothing(out, wide);
        return;
    }
    pack_nothing(out, left);
    pack_run(t, out + left * LT_TILES_ROW, image, pair, row * p->w + from + left * step, step, right - left);
    pack_nothing(out + right * LT_TILES_ROW, wide - right);
}

static void pack_phases(const tiles_task *t, lt_real *out, int64_t image, int64_t pair)
{
    const lt_conv2d_params *p = t->j->p;
    const int64_t top = t->unit * p->stride_h - p->pad_h, rows = rows_of_phase(t->j, t->units);

    for (int py = 0; py < p->stride_h; py++)
        for (int px = 0; px < p->stride_w; px++)
            for (int64_t r = 0; r < rows; r++, out += t->j->wide * LT_TILES_ROW)
                pack_row(t, out, image, pair, top + py + r * p->stride_h, px - p->pad_w);
}

static void pack_maps(const tiles_task *t, lt_real *out, int64_t from, int64_t end)
{
    for (int64_t pair = from; pair < end; pair++)
        for (int64_t i = 0; i < t->images; i++, out += t->read * LT_TILES_ROW)
            (t->j->point ? pack_point : pack_phases)(t, out, t->image + i, pair);
}

/* ---- the product --------------------------------------------------------------------------------------------- */

/* Where taps of n pairs stand */
static void find_segments(const tiles_task *t, int64_t *segment, int64_t n)
{
    const lt_conv2d_params *p = t->j->p;
    const int64_t rows = rows_of_phase(t->j, t->units), wide = t->j->wide;

    for (int64_t i = 0; i < n; i++)
        for (int ky = 0; ky < p->kh; ky++)
            for (int kx = 0; kx < p->kw; kx++) {
                const int64_t y = ky * p->dil_h, x = kx * p->dil_w;
                const int64_t phase = y % p->stride_h * p->stride_w + x % p->stride_w;
                const int64_t at = (phase * rows + y / p->stride_h) * wide + x / p->stride_w;

                *segment++ = (i * t->images * t->read + at) * LT_TILES_ROW;
            }
}

/* Units of y in image i, of block b of the task's outputs: rows of a map, or of the scratch where they were made */
static void finish(const tiles_task *t, const lt_real *made, int64_t i, int64_t b)
{
    const tiles_job *j = t->j;
    const lt_conv2d_around *around = j->around;
    const int64_t per = j->point ? 1 : j->out_w, n = t->units * per, o = t->output + b * LT_BLOCK;
    const int64_t plane = j->out_h * j->out_w * LT_BLOCK, lanes = lt_min_i64(LT_BLOCK, j->p->o - o);
    const int64_t at = ((t->image + i) * lt_blocks_of(j->p->o) + o / LT_BLOCK) * plane + t->unit * per * LT_BLOCK;
    lt_real bias[LT_BLOCK] = { 0 };

    if (around->bias)
        memcpy(bias, around->bias + o, (size_t)lanes * sizeof(*bias));
    for (int64_t r = 0; made && r < t->units; r++)
        memcpy(j->y + at + r * per * LT_BLOCK, made + (b * t->images * t->made + i * t->made + r * j->wide) * LT_BLOCK,
               (size_t)(per * LT_BLOCK) * sizeof(lt_real));
    lt_k->finish_block(j->y + at, around->bias ? bias : NULL, around->residual ? around->residual + at : NULL,
                       around->act, n);
}

static tiles_task task_of(const tiles_job *j, int64_t index)
{
    const int64_t parts = lt_ceil_div(j->p->n, j->images) * j->bands, part = index % parts, group = index / parts;
    tiles_task t = { .j = j, .image = part / j->bands * j->images, .unit = part % j->bands * j->band,
                     .output = group * j->outputs };

    t.images = lt_min_i64(j->images, j->p->n - t.image);
    t.units = lt_min_i64(j->band, j->units - t.unit);
    t.outputs = lt_min_i64(j->outputs, lt_blocks_of(j->p->o) * LT_BLOCK - t.output);
    t.read = positions_read(j, t.units), t.made = positions_made(j, t.units);
    return t;
}

static void run_task(void *ctx, lt_real *a, lt_real *made)
{
    enum { MOST_SEGMENTS = 2048 };
    const tiles_task *t = ctx;
    const tiles_job *j = t->j;
    const int64_t plane = j->out_h * j->out_w * LT_BLOCK, blocks = lt_blocks_of(j->p->o);
    const int64_t most = lt_min_i64(ROOM / (t->images * t->read * LT_TILES_ROW), MOST_SEGMENTS / j->taps);
    const int64_t chunks = lt_ceil_div(j->pairs, most);
    int64_t segment[MOST_SEGMENTS];
    lt_tiles g = {
        .a = a, .rows = t->made, .lines = t->images, .line = t->read * LT_TILES_ROW,
        .segment = segment, .b_panel = panel_elements(j->p), .n = t->outputs, .c = made, .c_row = LT_BLOCK,
        .c_line = t->made * LT_BLOCK, .plane = t->images * t->made * LT_BLOCK,
    };

    if (j->point) {
        g.c = j->y + (t->image * blocks + t->output / LT_BLOCK) * plane + t->unit * LT_BLOCK;
        g.c_line = blocks * plane, g.plane = plane;
    }
    for (int64_t i = 0; i < chunks; i++) {
        const int64_t from = i * j->pairs / chunks, end = (i + 1) * j->pairs / chunks;

        pack_maps(t, a, from, end);
        find_segments(t, segment, end - from);
        g.segments = (end - from) * j->taps;
        g.b = j->packed + t->output / LT_TILES_SIDE * g.b_panel + from * j->taps * LT_TILES_BLOCK;
        g.add = i > 0;
        if (j->point && i + 1 == chunks)
            g.fetch = (lt_fetch){ g.c, plane, t->outputs / LT_BLOCK, t->made };
        lt_k->gemm_tiles(&g);
    }
    for (int64_t b = 0; b < t->outputs / LT_BLOCK; b++)
        for (int64_t i = 0; i < t->images; i++)
            finish(t, j->point ? NULL : made, i, b);
}

static void run(void *ctx, int64_t index)
{
    tiles_task t = task_of(ctx, index);

    lt_with_scratch(run_task, &t);
}

void lt_conv_tiles_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed,
                           const lt_conv2d_around *around, lt_real *y)
{
    tiles_job j = plan(p);

    j.x = x, j.packed = packed, j.around = around, j.y = y;
    lt_parallel_for(lt_ceil_div(p->n, j.images) * j.bands * j.groups, run, &j);
}
