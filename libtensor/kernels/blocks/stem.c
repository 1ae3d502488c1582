/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/blocks/stem.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/blocks/conv.h"
#include "libtensor/kernels/conv/internal.h"
#include "libtensor/kernels/conv/turned.h"
#include "libtensor/kernels/gemm/product.h"

#include <string.h>

enum { STRIDE = 2, MOST_LINES = 64 };   /* of all channels, for one row of the result */

/* Rows of the result go in bands. For each a thread copies the lines that it reads, with their zeros. */
typedef struct {
    const lt_conv2d_params *p;
    const lt_real *x, *packed;
    const lt_conv2d_around *around;
    lt_real *y;
    int64_t rows, cols, columns;        /* of y; columns: channels, those of the last block included */
    int64_t band, bands;
    int64_t line, k;                    /* elements of a copied line, of a window */
} stem_job;

static int64_t lines_of(const lt_conv2d_params *p, int64_t rows)
{
    return (rows - 1) * STRIDE + (int64_t)(p->kh - 1) * p->dil_h + 1;
}

static int64_t copied(const lt_conv2d_params *p, int64_t rows)
{
    return p->c * lines_of(p, rows) * (p->w + 2 * p->pad_w);
}

bool lt_stem_suits(const lt_conv2d_params *p)
{
    return p->c < LT_BLOCK && p->o >= LT_BLOCK && p->groups == 1 && p->stride_h == STRIDE && p->stride_w == STRIDE
           && p->dil_w == 1 && !conv_nothing(p) && p->c * p->kh <= MOST_LINES && copied(p, 1) <= LT_SCRATCH_A;
}

static stem_job plan(const lt_conv2d_params *p)
{
    enum { POSITIONS = 224 };           /* of a band, about */
    stem_job j = {
        .p = p, .rows = lt_conv2d_out_h(p), .cols = lt_conv2d_out_w(p), .columns = lt_blocks_of(p->o) * LT_BLOCK,
        .line = p->w + 2 * p->pad_w, .k = p->c * p->kh * p->kw,
    };

    j.band = lt_min_i64(j.rows, lt_max_i64(1, POSITIONS / j.cols));
    while (copied(p, j.band) > LT_SCRATCH_A)
        j.band--;
    j.bands = lt_ceil_div(j.rows, j.band);
    return j;
}

/* ---- weights: panels [channel][ky][kx][nr] -------------------------------------------------------------- */

int64_t lt_stem_packed(const lt_conv2d_params *p)
{
    const stem_job j = plan(p);

    return lt_product_packed_b(j.columns, j.k);
}

void lt_stem_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed)
{
    const int64_t k = plan(p).k;

    memset(packed, 0, (size_t)lt_stem_packed(p) * sizeof(lt_real));
    lt_k->pack_b(packed, weights, 1, k, k, p->o);
}

/* ---- maps ------------------------------------------------------------------------------------------------ */

static void copy_line(const stem_job *j, lt_real *to, const lt_real *map, int64_t y)
{
    const int64_t w = j->p->w, pad = j->p->pad_w;

    if (y < 0 || y >= j->p->h) {
        memset(to, 0, (size_t)j->line * sizeof(*to));
        return;
    }
    memset(to, 0, (size_t)pad * sizeof(*to));
    memcpy(to + pad, map + y * w, (size_t)w * sizeof(*to));
    memset(to + pad + w, 0, (size_t)pad * sizeof(*to));
}

/* One panel of output channels of a band, g of which is known but for them */
static void multiply(const stem_job *j, lt_blocks g, int64_t image, int64_t row, int64_t o)
{
    const int64_t plane = j->rows * j->cols * LT_BLOCK;
    const int64_t at = (image * lt_blocks_of(j->p->o) + o / LT_BLOCK) * plane + row * j->cols * LT_BLOCK + o % LT_BLOCK;
    lt_real bias[LT_TURNED_LANES];
    lt_epilogue e;

    g.b = j->packed + o * j->k;
    g.n = lt_min_i64(lt_k->nr, j->columns - o);
    g.c = j->y + at;
    g.plane = plane, g.c_line = j->cols * LT_BLOCK;
    e = conv_panel_epilogue(j->p, j->around, o, g.n, at, bias);
    lt_k->gemm_blocks(&g, &e);
}

typedef struct { const stem_job *j; int64_t image, row, rows; } band;

static void run_band(void *ctx, lt_real *a, lt_real *b)
{
    const band *t = ctx;
    const stem_job *j = t->j;
    const lt_conv2d_params *p = j->p;
    const int64_t lines = lines_of(p, t->rows);
    int64_t segment[MOST_LINES];

    (void)b;
    for (int64_t i = 0; i < p->c * lines; i++)
        copy_line(j, a + i * j->line, j->x + (t->image * p->c + i / lines) * p->h * p->w,
                  t->row * STRIDE - p->pad_h + i % lines);
    for (int64_t i = 0; i < p->c * p->kh; i++)
        segment[i] = (i / p->kh * lines + i % p->kh * p->dil_h) * j->line;
    for (int64_t o = 0; o < j->columns; o += lt_k->nr)
        multiply(j, (lt_blocks){
            .a = a, .rows = j->cols, .step = STRIDE, .lines = t->rows, .line = STRIDE * j->line, .segment = segment,
            .segments = p->c * p->kh, .each = p->kw, .last = p->kw,
        }, t->image, t->row, o);
}

static void run_task(void *ctx, int64_t task)
{
    const stem_job *j = ctx;
    const int64_t row = task % j->bands * j->band;
    band t = { j, task / j->bands, row, lt_min_i64(j->band, j->rows - row) };

    lt_with_scratch(run_band, &t);
}

void lt_stem_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed, const lt_conv2d_around *around,
                     lt_real *y)
{
    stem_job j = plan(p);

    j.x = x, j.packed = packed, j.around = around, j.y = y;
    lt_parallel_for(p->n * j.bands, run_task, &j);
}
