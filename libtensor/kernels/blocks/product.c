/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/blocks/product.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/blocks/blocks.h"
#include "libtensor/kernels/conv/internal.h"
#include "libtensor/kernels/conv/turned.h"

#include <string.h>

enum {
    POSITIONS = 112,            /* of a band of the result, about: eight tiles of 14 */
    PER_PRODUCT = LT_PACK_K / LT_BLOCK,     /* segments of A at a time: the panel of B stays in L1 */
    LINES = 8,                  /* bands of a map that is copied */
};

/* How the windows see the map, or a copy of it with its padding, where columns are dealt to as many phases as the
 * step has: then positions beside each other in a row of y read positions beside each other. A 1 x 1 window's copy has
 * only what is read; then, and without a copy, all of y is one row. */
typedef struct {
    bool copied, one_row;
    int64_t row, block, image;          /* elements from row to row, block to block, image to image */
    int64_t high, wide;                 /* rows and columns of each phase */
    int phases;
    int64_t rows, cols, line;           /* of y, as the product goes over it; from one row's view to the next */
    int64_t segments;
} view;

static view view_of(const lt_conv2d_params *p)
{
    const bool point = p->kh == 1 && p->kw == 1 && !p->pad_h && !p->pad_w;
    const int64_t out_h = lt_conv2d_out_h(p), out_w = lt_conv2d_out_w(p);
    view v = { .copied = !conv_pointwise(p), .one_row = point, .phases = point ? 1 : p->stride_w };

    v.high = point ? out_h : p->h + 2 * p->pad_h;
    v.wide = point ? out_w : lt_ceil_div(p->w + 2 * p->pad_w, p->stride_w);
    v.row = v.phases * v.wide * LT_BLOCK;
    v.block = v.high * v.row;
    v.image = lt_blocks_of(p->c) * v.block;
    v.line = p->stride_h * v.row;
    v.rows = point ? 1 : out_h;
    v.cols = point ? out_h * out_w : out_w;
    v.segments = (int64_t)p->kh * p->kw * lt_blocks_of(p->c);
    return v;
}

typedef struct {
    const lt_conv2d_params *p;
    view v;
    const lt_real *x, *packed;
    const lt_conv2d_around *around;
    lt_real *y, *copy;
    int64_t *segment;
    int64_t panels, columns;            /* panels of B; columns, those of the last block included */
    int64_t bands, band;                /* parts of y's rows, or where there is but one, of its columns */
    bool panels_first;
} product_job;

/* A row of one phase: columns from, from + step ... of a row of the map, which may be outside of it */
static void copy_phase(lt_real *to, const lt_real *row, int64_t w, int64_t from, int64_t step, int64_t n)
{
    for (int64_t i = 0; i < n; i++, from += step)
        if (row && from >= 0 && from < w)
            memcpy(to + i * LT_BLOCK, row + from * LT_BLOCK, LT_BLOCK * sizeof(lt_real));
        else
            memset(to + i * LT_BLOCK, 0, LT_BLOCK * sizeof(lt_real));
}

static void copy_row(const product_job *j, lt_real *to, const lt_real *map, int64_t row)
{
    const lt_conv2d_params *p = j->p;
    const int64_t y = j->v.one_row ? row * p->stride_h : row - p->pad_h;
    const lt_real *from = y >= 0 && y < p->h ? map + y * p->w * LT_BLOCK : NULL;

    for (int i = 0; i < j->v.phases; i++)
        copy_phase(to + i * j->v.wide * LT_BLOCK, from, p->w, i - p->pad_w, p->stride_w, j->v.wide);
}

static void copy_band(void *ctx, int64_t task)
{
    const product_job *j = ctx;
    const int64_t blocks = lt_blocks_of(j->p->c), band = task / blocks % LINES, image = task / blocks / LINES;
    const int64_t block = image * blocks + task % blocks;
    const lt_real *map = j->x + block * j->p->h * j->p->w * LT_BLOCK;

    for (int64_t y = band * j->v.high / LINES; y < (band + 1) * j->v.high / LINES; y++)
        copy_row(j, j->copy + block * j->v.block + y * j->v.row, map, y);
}

static void find_segments(const lt_conv2d_params *p, const view *v, int64_t *segment)
{
    for (int ky = 0; ky < p->kh; ky++)
        for (int kx = 0; kx < p->kw; kx++) {
            const int64_t x = kx * p->dil_w;
            const int64_t at = ky * p->dil_h * v->row + (x % v->phases * v->wide + x / v->phases) * LT_BLOCK;

            for (int64_t b = 0; b < lt_blocks_of(p->c); b++)
                *segment++ = at + b * v->block;
        }
}

/* Channels of a segment that are not there have no part in a chain; behind a window's taps follow more. */
static int64_t last_columns(const lt_conv2d_params *p)
{
    return p->kh * p->kw == 1 && p->c % LT_BLOCK ? p->c % LT_BLOCK : LT_BLOCK;
}

typedef struct { int64_t image, band, panel; } product_task;

/* A thread's tasks follow each other: they share the maps, or with many weights a panel of these. */
static product_task task_of(const product_job *j, int64_t task)
{
    const int64_t bands = j->bands * j->p->n;
    const int64_t at = j->panels_first ? task % bands : task / j->panels;

    return (product_task){ at / j->bands, at % j->bands, j->panels_first ? task / bands : task % j->panels };
}

typedef struct { int64_t first, end; } segments;

/* Of the taps' rows that see the map from one of n rows of y, from `row` on: others are all padding. One at least */
static segments seen_from(const lt_conv2d_params *p, int64_t row, int64_t n)
{
    const int64_t each = p->kw * lt_blocks_of(p->c), top = row * p->stride_h - p->pad_h;
    const int64_t bottom = top + (n - 1) * p->stride_h;             /* of the first tap's rows, in x */
    const int64_t end = lt_min_i64(p->kh, lt_max_i64(1, lt_ceil_div(p->h - top, p->dil_h)));
    const int64_t first = lt_min_i64(end - 1, lt_max_i64(0, lt_ceil_div(-bottom, p->dil_h)));

    return (segments){ first * each, end * each };
}

/* The panel's sums over segments [from, end) of s, g of which is known but for them; e: what follows the last of
 * them */
static void multiply(const product_job *j, const product_task *t, lt_blocks g, segments s, int64_t from, int64_t end,
                     const lt_epilogue *e)
{
    const int64_t nr = lt_k->nr, all = j->v.segments;
    _Alignas(LT_ALIGN) lt_real gated[LT_PACK_K * LT_TURNED_LANES];

    g.segment = j->segment + from, g.segments = end - from;
    g.last = end == all ? last_columns(j->p) : LT_BLOCK;
    g.b = j->packed + (t->panel * all + from) * nr * LT_BLOCK;
    g.add = from > s.first;
    if (j->around->gate) {
        lt_k->scale_panels(gated, g.b, j->around->gate + t->image * j->p->c + from * LT_BLOCK,
                           (g.segments - 1) * LT_BLOCK + g.last, nr);
        g.b = gated;
    }
    lt_k->gemm_blocks(&g, end == s.end ? e : NULL);
}

static void run_product(void *ctx, int64_t task)
{
    const product_job *j = ctx;
    const product_task t = task_of(j, task);
    const int64_t nr = lt_k->nr, o = t.panel * nr, plane = j->v.rows * j->v.cols * LT_BLOCK;
    const int64_t row = j->v.one_row ? 0 : t.band * j->band, col = j->v.one_row ? t.band * j->band : 0;
    const int64_t at = (t.image * lt_blocks_of(j->p->o) + o / LT_BLOCK) * plane + o % LT_BLOCK
                       + (row * j->v.cols + col) * LT_BLOCK;
    lt_real bias[LT_TURNED_LANES];
    const lt_blocks g = {
        .a = (j->v.copied ? j->copy : j->x) + t.image * j->v.image + row * j->v.line + col * LT_BLOCK,
        .rows = j->v.one_row ? lt_min_i64(j->band, j->v.cols - col) : j->v.cols, .step = LT_BLOCK, .each = LT_BLOCK,
        .lines = j->v.one_row ? 1 : lt_min_i64(j->band, j->v.rows - row), .line = j->v.line,
        .n = lt_min_i64(nr, j->columns - o), .c = j->y + at, .plane = plane,
        .c_line = j->v.cols * LT_BLOCK,
    };
    const lt_epilogue e = conv_panel_epilogue(j->p, j->around, o, g.n, at, bias);

    const segments s = j->v.one_row ? (segments){ 0, j->v.segments } : seen_from(j->p, row, g.lines);
    const int64_t n = s.end - s.first, parts = lt_ceil_div(n, PER_PRODUCT);

    for (int64_t i = 0; i < parts; i++)
        multiply(j, &t, g, s, s.first + i * n / parts, s.first + (i + 1) * n / parts, &e);
}

static int64_t copy_elements(const lt_conv2d_params *p, const view *v)
{
    return v->copied ? p->n * v->image : 0;
}

size_t lt_blocks_product_work(const lt_conv2d_params *p)
{
    const view v = view_of(p);

    return (size_t)copy_elements(p, &v) * sizeof(lt_real) + (size_t)v.segments * sizeof(int64_t);
}

void lt_blocks_product_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed,
                               const lt_conv2d_around *around, lt_real *y, lt_real *work)
{
    product_job j = { .p = p, .v = view_of(p), .x = x, .packed = packed, .around = around, .y = y, .copy = work };
    const int64_t n = j.v.one_row ? j.v.cols : j.v.rows, per = j.v.one_row ? 1 : j.v.cols;

    j.columns = lt_blocks_of(p->o) * LT_BLOCK;
    j.panels = lt_ceil_div(j.columns, lt_k->nr);
    j.band = lt_tile_size(n, lt_max_i64(1, POSITIONS / per), 1);
    j.bands = lt_ceil_div(n, j.band);
    j.panels_first = p->o * p->kh * p->kw > p->h * p->w;
    j.segment = (int64_t *)(void *)(work + copy_elements(p, &j.v));
    find_segments(p, &j.v, j.segment);
    if (j.v.copied)
        lt_parallel_for(p->n * LINES * lt_blocks_of(p->c), copy_band, &j);
    lt_parallel_for(p->n * j.bands * j.panels, run_product, &j);
}

/* Panels of nr outputs: [segment][LT_BLOCK][nr], zeros for channels and outputs that are not there */
typedef struct { const lt_conv2d_params *p; const lt_real *weights; lt_real *packed; } pack_job;

static void pack_panel(void *ctx, int64_t panel)
{
    const pack_job *j = ctx;
    const int64_t nr = lt_k->nr, taps = (int64_t)j->p->kh * j->p->kw, c = j->p->c, o = panel * nr;
    const int64_t n = lt_max_i64(0, lt_min_i64(nr, j->p->o - o));
    lt_real *out = j->packed + o * taps * lt_blocks_of(c) * LT_BLOCK;

    for (int64_t t = 0; t < taps; t++)
        for (int64_t l = 0; l < c; l += LT_BLOCK, out += LT_BLOCK * nr) {
            memset(out, 0, (size_t)(LT_BLOCK * nr) * sizeof(lt_real));
            if (n)
                lt_k->pack_b(out, j->weights + (o * c + l) * taps + t, taps, c * taps, lt_min_i64(LT_BLOCK, c - l), n);
        }
}

int64_t lt_blocks_product_packed(const lt_conv2d_params *p)
{
    const int64_t k = (int64_t)p->kh * p->kw * lt_blocks_of(p->c) * LT_BLOCK;

    return lt_product_packed_b(lt_blocks_of(p->o) * LT_BLOCK, k);
}

void lt_blocks_product_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed)
{
    pack_job j = { p, weights, packed };

    lt_parallel_for(lt_ceil_div(lt_blocks_of(p->o) * LT_BLOCK, lt_k->nr), pack_panel, &j);
}
