/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/gemm/tiles.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/gemm/product.h"

#include <string.h>

enum {
    SIDE = LT_TILES_SIDE,
    FEW = 64,                   /* rows, columns or terms are too few */
    ROWS = 128,                 /* of a task */
    COLUMNS = 256,              /* at a time, and of a task where tasks would be few */
    TASKS = 8,
    SEGMENTS = LT_SCRATCH_A / (ROWS * LT_TILES_ROW),        /* of A at a time */
};

static int64_t sides_of(int64_t n)
{
    return lt_ceil_div(n, SIDE);
}

bool lt_gemm_tiles_suits(int64_t m, int64_t n, int64_t k)
{
    return lt_k->gemm_tiles && m >= FEW && n >= FEW && k >= FEW && n * k > FEW * FEW;
}

/* ---- B: panels of 32 columns, blocks of 32 rows ---------------------------------------------------------- */

int64_t lt_gemm_tiles_packed(int64_t n, int64_t k)
{
    return sides_of(n) * sides_of(k) * LT_TILES_BLOCK;
}

typedef struct { lt_trans tb; int64_t n, k; const lt_real *b; int64_t ldb; lt_real *packed; } pack_job;

static void pack_panel(void *ctx, int64_t panel)
{
    const pack_job *j = ctx;
    const int64_t n = lt_min_i64(SIDE, j->n - panel * SIDE);
    lt_real *out = j->packed + panel * sides_of(j->k) * LT_TILES_BLOCK;
    _Alignas(LT_ALIGN) lt_real turned[SIDE * SIDE];

    if (!j->tb) {
        lt_k->tiles_right(out, 0, j->b + panel * SIDE, j->ldb, j->k, n);
        return;
    }
    for (int64_t l = 0; l < j->k; l += SIDE, out += LT_TILES_BLOCK) {
        const int64_t k = lt_min_i64(SIDE, j->k - l);

        lt_k->turn(turned, SIDE, j->b + panel * SIDE * j->ldb + l, j->ldb, n, k, false);
        lt_k->tiles_right(out, 0, turned, SIDE, k, n);
    }
}

void lt_gemm_tiles_pack(lt_trans tb, int64_t n, int64_t k, const lt_real *b, int64_t ldb, lt_real *packed)
{
    pack_job j = { tb, n, k, b, ldb, packed };

    lt_parallel_for(sides_of(n), pack_panel, &j);
}

/* ---- C --------------------------------------------------------------------------------------------------- */

/* A row of C = or += one that tiles left in blocks, ROWS of each */
static void store_row(lt_real *c, const lt_real *made, int64_t columns, bool add)
{
    lt_real line[COLUMNS], *out = add ? line : c;
    const int64_t whole = columns / LT_BLOCK;

    for (int64_t b = 0; b < whole; b++)
        memcpy(out + b * LT_BLOCK, made + b * ROWS * LT_BLOCK, LT_BLOCK * sizeof(*c));
    memcpy(out + whole * LT_BLOCK, made + whole * ROWS * LT_BLOCK, (size_t)(columns % LT_BLOCK) * sizeof(*c));
    if (add)
        lt_k->add_to(c, line, (size_t)columns);
}

/* ---- C = A B --------------------------------------------------------------------------------------------- */

typedef struct {
    int64_t m, n, k;
    const lt_real *a, *packed;
    lt_real *c;
    int64_t lda, ldc;
    bool add;
    const lt_epilogue *e;
    int64_t rows, bands, groups;        /* of a task; bands of rows, groups of columns */
} job;

typedef struct { const job *j; int64_t row, rows, column, columns; } job_task;

/* Rows of the band, `segments` segments from the first on; eight rows at a time, so that a page is met once */
static void pack_rows(const job_task *t, lt_real *out, int64_t first, int64_t segments)
{
    enum { AT_ONCE = 8 };
    const job *j = t->j;

    for (int64_t row = 0; row < t->rows; row += AT_ONCE)
        for (int64_t s = 0; s < segments; s++) {
            const int64_t at = (first + s) * SIDE;
            const lt_real *a = j->a + (t->row + row) * j->lda + at;

            lt_k->tiles_left(out + (s * ROWS + row) * LT_TILES_ROW, a, LT_BLOCK, j->lda, lt_min_i64(SIDE, j->k - at),
                             lt_min_i64(AT_ONCE, t->rows - row), NULL);
        }
}

/* Some columns of the band's sums, to C, and what follows */
static void finish(const job_task *t, const lt_real *made, int64_t column, int64_t columns)
{
    const job *j = t->j;

    for (int64_t row = t->row; row < t->row + t->rows; row++, made += LT_BLOCK) {
        lt_real *c = j->c + row * j->ldc + column;

        store_row(c, made, columns, j->add);
        if (j->e) {
            lt_epilogue e = *j->e;

            e.col_bias = e.col_bias ? e.col_bias + column : NULL;
            e.row_bias = e.row_bias ? e.row_bias + row : NULL;
            e.residual = e.residual ? e.residual + row * e.ld_residual + column : NULL;
            lt_k->epilogue(c, j->ldc, 1, columns, &e);
        }
    }
}

/* Whether sums may grow in C itself */
static bool in_place(const job *j)
{
    return !j->add && !j->e;
}

/* Where segments of packed rows stand */
static void find_segments(int64_t segment[SEGMENTS])
{
    for (int64_t s = 0; s < SEGMENTS; s++)
        segment[s] = s * ROWS * LT_TILES_ROW;
}

/* A product of packed rows, without what it takes from B */
static lt_tiles product_of(const job_task *t, const lt_real *a, const int64_t *segment, lt_real *made)
{
    return (lt_tiles){
        .a = a, .rows = t->rows, .lines = 1, .segment = segment, .b_panel = sides_of(t->j->k) * LT_TILES_BLOCK,
        .c = made, .c_row = LT_BLOCK, .plane = ROWS * LT_BLOCK,
    };
}

/* Some columns of a band: packs its rows by parts of their terms, and adds up what these give. */
static void multiply(const job_task *t, lt_real *a, lt_real *made, int64_t column, int64_t columns)
{
    const job *j = t->j;
    const int64_t sides = sides_of(j->k), parts = lt_ceil_div(sides, SEGMENTS);
    int64_t segment[SEGMENTS];
    lt_tiles g = product_of(t, a, segment, made);

    find_segments(segment);
    g.n = columns;
    if (in_place(j))
        g.c = j->c + t->row * j->ldc + column, g.c_row = j->ldc, g.plane = LT_BLOCK;
    for (int64_t i = 0; i < parts; i++) {
        const int64_t from = i * sides / parts;

        g.segments = (i + 1) * sides / parts - from;
        g.b = j->packed + column / SIDE * g.b_panel + from * LT_TILES_BLOCK;
        g.add = i > 0;
        if (i + 1 == parts && !in_place(j))
            g.fetch = (lt_fetch){ j->c + t->row * j->ldc + column, j->ldc, t->rows, lt_ceil_div(columns, LT_BLOCK) };
        if (parts > 1 || column == t->column)
            pack_rows(t, a, from, g.segments);
        lt_k->gemm_tiles(&g);
    }
}

static void run_task(void *ctx, lt_real *a, lt_real *made)
{
    const job_task *t = ctx;
    const job *j = t->j;
    const int64_t end = t->column + t->columns;

    for (int64_t at = t->column; at < end; at += COLUMNS) {
        const int64_t columns = lt_min_i64(COLUMNS, end - at);

        multiply(t, a, made, at, columns);
        if (!in_place(j))
            finish(t, made, at, columns);
    }
}

static void run(void *ctx, int64_t index)
{
    const job *j = ctx;
    const int64_t sides = sides_of(j->n), group = index / j->bands;
    job_task t = { .j = j, .row = index % j->bands * j->rows, .column = group * sides / j->groups * SIDE };

    t.rows = lt_min_i64(j->rows, j->m - t.row);
    t.columns = lt_min_i64((group + 1) * sides / j->groups * SIDE, j->n) - t.column;
    lt_with_scratch(run_task, &t);
}

void lt_gemm_tiles(int64_t m, int64_t n, int64_t k, const lt_real *a, int64_t lda, const lt_real *packed, bool add,
                   lt_real *c, int64_t ldc, const lt_epilogue *e)
{
    job j = { m, n, k, a, packed, c, lda, ldc, add, e, .rows = lt_tile_size(m, ROWS, SIDE) };

    j.bands = lt_ceil_div(m, j.rows);
    j.groups = lt_max_i64(1, lt_min_i64(lt_ceil_div(TASKS, j.bands), n / COLUMNS));
    lt_parallel_for(j.bands * j.groups, run, &j);
}

/* ---- C = op2(op1(A B1) B2) ------------------------------------------------------------------------------- */

enum {
    MIDDLE = 128,               /* columns of the middle at a time: as they are, and as rows on the left */
    MIDDLE_ROWS = ROWS * MIDDLE,
    MIDDLE_LEFT = MIDDLE / SIDE * ROWS * LT_TILES_ROW,
};

typedef struct { job first, second; } pair_job;
typedef struct { const pair_job *j; job_task first, second; } pair_task;

bool lt_gemm_tiles_pair_suits(int64_t m, int64_t k, int64_t hidden, int64_t n)
{
    return lt_gemm_tiles_suits(m, hidden, k) && lt_gemm_tiles_suits(m, n, hidden) && hidden % SIDE == 0
           && sides_of(k) * ROWS * LT_TILES_ROW + MIDDLE_ROWS <= LT_SCRATCH_A
           && MIDDLE_LEFT + ROWS * sides_of(n) * SIDE <= LT_SCRATCH_B;
}

/* op1 of some columns of the middle, and their way to the left of the second product */
static void turn_middle(const pair_task *t, lt_real *middle, lt_real *left, int64_t column, int64_t columns)
{
    const lt_epilogue *e = t->j->first.e;

    for (int64_t c = 0; c < columns; c += SIDE, middle += ROWS * SIDE, left += ROWS * LT_TILES_ROW) {
        for (int64_t b = 0; b < SIDE; b += LT_BLOCK)
            lt_k->finish_block(middle + ROWS * b, e->col_bias ? e->col_bias + column + c + b : NULL, NULL, e->act,
                               t->first.rows);
        lt_k->tiles_left(left, middle, ROWS * LT_BLOCK, LT_BLOCK, SIDE, t->first.rows, NULL);
    }
}

static void run_pair(void *ctx, lt_real *a, lt_real *left)
{
    const pair_task *t = ctx;
    const job *first = &t->j->first, *second = &t->j->second;
    lt_real *middle = a + sides_of(first->k) * ROWS * LT_TILES_ROW, *made = left + MIDDLE_LEFT;
    int64_t segment[SEGMENTS];
    lt_tiles in = product_of(&t->first, a, segment, middle), out = product_of(&t->second, left, segment, made);

    find_segments(segment);
    pack_rows(&t->first, a, 0, sides_of(first->k));
    in.segments = sides_of(first->k), out.n = second->n;
    for (int64_t at = 0; at < first->n; at += MIDDLE) {
        in.b = first->packed + at / SIDE * in.b_panel, out.b = second->packed + at / SIDE * LT_TILES_BLOCK;
        in.n = lt_min_i64(MIDDLE, first->n - at), out.segments = in.n / SIDE;
        out.add = at > 0;
        lt_k->gemm_tiles(&in);
        turn_middle(t, middle, left, at, in.n);
        lt_k->gemm_tiles(&out);
    }
    finish(&t->second, made, 0, second->n);
}

static void run_band(void *ctx, int64_t band)
{
    const pair_job *j = ctx;
    const int64_t row = band * j->first.rows, rows = lt_min_i64(j->first.rows, j->first.m - row);
    pair_task t = { j, { .j = &j->first, .row = row, .rows = rows }, { .j = &j->second, .row = row, .rows = rows } };

    lt_with_scratch(run_pair, &t);
}

void lt_gemm_tiles_pair(int64_t m, int64_t k, const lt_real *a, int64_t hidden, const lt_real *packed1,
                        const lt_epilogue *e1, int64_t n, const lt_real *packed2, const lt_epilogue *e2, lt_real *c)
{
    pair_job j = {
        { .m = m, .n = hidden, .k = k, .a = a, .lda = k, .packed = packed1, .e = e1,
          .rows = lt_tile_size(m, ROWS, SIDE) },
        { .m = m, .n = n, .k = hidden, .packed = packed2, .c = c, .ldc = n, .e = e2 },
    };

    lt_parallel_for(lt_ceil_div(m, j.first.rows), run_band, &j);
}

/* ---- C = A^T B ------------------------------------------------------------------------------------------- */

/* A is the narrower of the two; where it was B the sums are turned at the end. Where tiles are few the terms are cut
 * into chunks, whose sums are added up in their order. */
typedef struct {
    int64_t m, n, k;
    const lt_real *a, *b;
    lt_real *c;                         /* of all chunks, one behind the other */
    bool add;
    int64_t tiles, across, chunks;      /* tiles of each chunk, and beside each other */
} sums_job;

typedef struct { const sums_job *j; int64_t row, rows, column, columns, from, to; lt_real *c; } sums_task;

/* Blocks of terms at a time; behind packed A the sums */
enum { SUMS = LT_SCRATCH_A / (COLUMNS * LT_TILES_ROW), MADE = SUMS * ROWS * LT_TILES_ROW };
_Static_assert(MADE + ROWS * COLUMNS <= LT_SCRATCH_B, "a tile's sums fit into scratch");

/* A block of terms from `at` on, of both sides */
static void pack_terms(const sums_task *t, lt_real *a, lt_real *b, int64_t at)
{
    const sums_job *j = t->j;
    const int64_t k = lt_min_i64(SIDE, t->to - at);

    lt_k->tiles_left_turned(a, j->a + at * j->m + t->row, j->m, k, t->rows);
    lt_k->tiles_right(b, SUMS * LT_TILES_BLOCK, j->b + at * j->n + t->column, j->n, k, t->columns);
}

static void run_sums(void *ctx, lt_real *b, lt_real *a)
{
    const sums_task *t = ctx;
    const sums_job *j = t->j;
    lt_real *made = a + MADE;
    int64_t segment[SUMS];
    lt_tiles g = {
        .a = a, .rows = t->rows, .lines = 1, .segment = segment, .b = b, .b_panel = SUMS * LT_TILES_BLOCK,
        .n = t->columns, .c = made, .c_row = LT_BLOCK, .plane = ROWS * LT_BLOCK,
    };

    for (int64_t s = 0; s < SUMS; s++)
        segment[s] = s * ROWS * LT_TILES_ROW;
    for (int64_t at = t->from; at < t->to; at += SUMS * SIDE) {
        g.segments = sides_of(lt_min_i64(SUMS * SIDE, t->to - at));
        g.add = at > t->from;
        for (int64_t s = 0; s < g.segments; s++)
            pack_terms(t, a + segment[s], b + s * LT_TILES_BLOCK, at + s * SIDE);
        lt_k->gemm_tiles(&g);
    }
    for (int64_t i = 0; i < t->rows; i++)
        store_row(t->c + (t->row + i) * j->n + t->column, made + i * LT_BLOCK, t->columns, j->add);
}

static void sum_tile(void *ctx, int64_t index)
{
    const sums_job *j = ctx;
    const int64_t tile = index % j->tiles, chunk = index / j->tiles, sides = sides_of(j->k);
    sums_task t = {
        .j = j, .row = tile / j->across * ROWS, .column = tile % j->across * COLUMNS, .c = j->c + chunk * j->m * j->n,
        .from = chunk * sides / j->chunks * SIDE, .to = lt_min_i64((chunk + 1) * sides / j->chunks * SIDE, j->k),
    };

    t.rows = lt_min_i64(ROWS, j->m - t.row);
    t.columns = lt_min_i64(COLUMNS, j->n - t.column);
    lt_with_scratch(run_sums, &t);
}

static sums_job plan_sums(int64_t m, int64_t n, int64_t k)
{
    sums_job j = { .m = lt_min_i64(m, n), .n = lt_max_i64(m, n), .k = k };

    j.across = lt_ceil_div(j.n, COLUMNS);
    j.tiles = lt_ceil_div(j.m, ROWS) * j.across;
    j.chunks = lt_max_i64(1, lt_min_i64(lt_ceil_div(TASKS, j.tiles), k / FEW));
    return j;
}

typedef struct { const sums_job *j; lt_real *c; bool turn, add; } gather_job;

/* Some rows of C from all chunks' sums; or some rows of these, which are columns of C */
static void gather_strip(void *ctx, int64_t strip)
{
    const gather_job *g = ctx;
    const sums_job *j = g->j;
    const int64_t at = strip * SIDE, rows = lt_min_i64(SIDE, j->m - at);

    for (int64_t i = 0; i < j->chunks; i++) {
        const lt_real *sums = j->c + (i * j->m + at) * j->n;

        if (g->turn)
            lt_k->turn(g->c + at, j->m, sums, j->n, rows, j->n, g->add || i > 0);
        else if (g->add || i > 0)
            lt_k->add_to(g->c + at * j->n, sums, (size_t)(rows * j->n));
        else
            memcpy(g->c + at * j->n, sums, (size_t)(rows * j->n) * sizeof(*sums));
    }
}

size_t lt_gemm_tiles_sums_work(int64_t m, int64_t n, int64_t k)
{
    const sums_job j = plan_sums(m, n, k);

    return m > n || j.chunks > 1 ? (size_t)(j.chunks * m * n) * sizeof(lt_real) : 0;
}

void lt_gemm_tiles_sums(int64_t m, int64_t n, int64_t k, const lt_real *a, const lt_real *b, bool add, lt_real *c,
                        void *work)
{
    sums_job j = plan_sums(m, n, k);
    const bool turn = m > n, gather = turn || j.chunks > 1;

    j.a = turn ? b : a, j.b = turn ? a : b;
    j.c = gather ? work : c;
    j.add = !gather && add;
    lt_parallel_for(j.tiles * j.chunks, sum_tile, &j);
    if (gather)
        lt_parallel_for(sides_of(j.m), gather_strip, &(gather_job){ &j, c, turn, add });
}
