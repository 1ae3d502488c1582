/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the Winograd convolutions of maps in blocks have in common: maps and windows are transformed, and then there is
 * a product of its own in each place of a tile. For winograd.c and tall.c only.
 */
#ifndef LT_KERNELS_BLOCKS_PLACES_H
#define LT_KERNELS_BLOCKS_PLACES_H

#include "libtensor/kernels/kernels.h"

enum {
    LT_PLACES_SEGMENTS = 256,       /* the most of them */
    LT_PLACES_APART = 16,           /* between places, or all of them would fall into one set of each cache */
    LT_PLACES_BYTES = 3 << 20,      /* of transformed maps at a time: they should stay in the cache */
};

typedef struct {
    int places;
    int64_t segments, tiles;
    int64_t o;                      /* channels of out, a multiple of LT_BLOCK */
    const lt_real *in;              /* [place][segment][tile][LT_BLOCK] */
    const lt_real *windows;         /* [place][panel of nr][segment][LT_BLOCK][nr] */
    lt_real *out;                   /* [place][block][tile][LT_BLOCK] */
    int64_t in_place, out_place, window;    /* elements from place to place */
} lt_places;

/* lt_places_window - elements of windows for a place, with what lies between places */
int64_t lt_places_window(int64_t o, int64_t segments);

/* lt_places_multiply - out = in times windows, place by place */
void lt_places_multiply(const lt_places *j);

#endif
