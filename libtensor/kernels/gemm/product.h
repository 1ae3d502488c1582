/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One tile of a product whose operands are packed by the caller's functions: the loop that lt_gemm and
 * the convolutions share. For files of kernels/ only.
 */
#ifndef LT_KERNELS_GEMM_PRODUCT_H
#define LT_KERNELS_GEMM_PRODUCT_H

#include "libtensor/kernels/kernels.h"

/* The largest tile; a wider one is cut into strips that fit. They bound the scratch of a thread, and change no bit. */
enum { LT_TILE_M = 256, LT_TILE_N = 384 };

typedef struct { int64_t m0, m, n0, n; } lt_tile;

typedef struct lt_product {
    int64_t k;
    const lt_real *a;           /* all of A as lt_product_pack_a left it; or NULL, then pack_a or left */
    const lt_real *rows;        /* A as it is, with packed B only: element (i, l) is rows[i * ld_rows + l]; or NULL */
    int64_t ld_rows;
    const lt_real *b;           /* all of B as lt_product_pack_b left it; or NULL, then pack_b or right */
    int64_t b_step, b_columns;  /* between images in it, 0: they share one; what lt_product_pack_b had for n */
    const void *ctx;
    void (*pack_a)(const void *ctx, lt_real *out, const lt_tile *t, int64_t k0, int64_t k);
    void (*pack_b)(const void *ctx, lt_real *out, const lt_tile *t, int64_t image, int64_t k0,
                   int64_t k);
    /* Where AMX's tiles multiply, in the place of the two above; else NULL. Rows of tiles begin at multiples of
     * LT_TILES_SIDE then. left: the tile's rows as of tiles_left, every LT_TILES_SIDE terms `step` elements apart.
     * right: rows of B for the tile's columns, *ld elements apart, wherever they are, or in room as *ld comes. */
    void (*left)(const void *ctx, lt_real *out, int64_t step, const lt_tile *t, int64_t k0, int64_t k);
    const lt_real *(*right)(const void *ctx, lt_real *room, int64_t *ld, const lt_tile *t, int64_t image, int64_t k0,
                            int64_t k);
    lt_real *c;                 /* the tile's first element in image 0's result */
    int64_t ldc, c_step;        /* between rows, between images */
    bool add;
    const lt_bytes *bytes;      /* of the whole: k counts words, A has signed bytes, or rows unsigned ones; needs e, and
                                 * add is false. NULL: numbers */
    const lt_epilogue *e;       /* or NULL; its row_bias, col_bias and residual are the whole's */
} lt_product;

/**
 * lt_product_tile - images [from, to) of one tile: C (+)= A B[image]
 *
 * t->m <= LT_TILE_M. Uses the thread's scratch, unless p->rows and p->b are there.
 */
void lt_product_tile(const lt_product *p, const lt_tile *t, int64_t from, int64_t to);

/* lt_product_epilogue - what p->e says of this tile of one image */
lt_epilogue lt_product_epilogue(const lt_product *p, const lt_tile *t, int64_t image);

/**
 * lt_with_scratch - run fn with the calling thread's scratch: LT_SCRATCH_A and LT_SCRATCH_B elements
 *
 * The same that lt_product_tile uses, which fn may call only where that does not.
 */
enum { LT_SCRATCH_A = LT_TILE_M * LT_PACK_K, LT_SCRATCH_B = LT_TILE_N * LT_PACK_K };

void lt_with_scratch(void (*fn)(void *ctx, lt_real *a, lt_real *b), void *ctx);

/* lt_product_blocks - into how many almost equal blocks k is cut; block i starts at i * k / blocks */
static inline int64_t lt_product_blocks(int64_t k)
{
    return lt_max_i64(1, lt_ceil_div(k, LT_PACK_K));
}

/**
 * lt_product_pack_a - all m rows of A, in parallel: for each tile of tile_m rows, for each block of k
 * lt_product_pack_b - all n columns of B of each image, in parallel, `columns` of them in a task, a multiple of 64: for
 *                     each block of k, in whole panels
 *
 * out has m * k elements, or lt_product_packed_b(n, k) for each image. The part of a tile at m0 and a block at k0
 * starts at m0 * k + k0 * (the tile's rows). Tiles of B may be any whole panels.
 * With left it has lt_product_tiles_a(m, k) elements, or lt_product_tiles_b(n, k) for each image: product_tiles.c.
 */
int64_t lt_product_packed_b(int64_t n, int64_t k);
void lt_product_pack_a(const lt_product *p, int64_t m, int64_t tile_m, lt_real *out);
void lt_product_pack_b(const lt_product *p, int64_t images, int64_t n, int64_t columns, lt_real *out);

/* product_tiles.c: the same for products that have left, for product.c */
enum {
    LT_PRODUCT_TILES_M = 256,           /* the most rows of a tile, */
    LT_PRODUCT_TILES_N = 128,           /* and columns at a time */
    LT_PRODUCT_ROOM = LT_PRODUCT_TILES_N + LT_BLOCK,    /* for a row of them, and what is written too much */
};
int64_t lt_product_tiles_a(int64_t m, int64_t k);
int64_t lt_product_tiles_b(int64_t n, int64_t k);
void lt_product_tiles_pack_a(const lt_product *p, int64_t m, int64_t tile_m, lt_real *out);
void lt_product_tiles_pack_b(const lt_product *p, int64_t images, int64_t n, lt_real *out);
void lt_product_tiles_tile(const lt_product *p, const lt_tile *t, int64_t from, int64_t to);

/* lt_tile_size - cut n into equal parts of at most `most`, each a multiple of `unit`, but the last */
static inline int64_t lt_tile_size(int64_t n, int64_t most, int64_t unit)
{
    const int64_t parts = lt_max_i64(1, lt_ceil_div(n, most));

    return lt_min_i64(most, lt_max_i64(1, lt_ceil_div(lt_ceil_div(n, parts), unit)) * unit);
}

/* LT_FEW_ROWS: of a product that is small in all, in one tile. LT_PANELS: columns that are whole panels of any
 * instruction set */
enum { LT_FEW_ROWS = 128, LT_PANELS = 64 };

/* lt_product_columns - of a tile of a product of m rows with packed B: few rows have little else to be cut */
static inline int64_t lt_product_columns(int64_t m, int64_t n)
{
    return lt_tile_size(n, m <= LT_FEW_ROWS ? LT_PANELS : LT_TILE_N, LT_PANELS);
}

#endif
