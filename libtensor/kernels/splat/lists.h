/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which Gaussians each tile has, near to far by z's bits as a float, then by number.
 */
#ifndef LT_KERNELS_SPLAT_LISTS_H
#define LT_KERNELS_SPLAT_LISTS_H

#include "libtensor/kernels/kernels.h"

/* There is room for `capacity` instances: where there are more, the lists hold some of the Gaussians in the order of
 * depth, then the next ones. */
typedef struct {
    int64_t n, across, tiles, capacity;     /* Gaussians; tiles in a row, and in all */
    int64_t drawn, from, to;    /* order[from, to) of drawn ones are in the lists */
    int64_t instances;          /* of all drawn ones */
    uint32_t *covers;           /* (n) tiles of each Gaussian; 0: not drawn */
    uint32_t *instance;         /* (n) the first one of each in the lists */
    uint32_t *order;            /* (drawn) Gaussians by depth */
    uint32_t *start;            /* (tiles + 1) a tile's entries begin here */
    uint32_t *longest;          /* (tiles) the tiles, those with long lists first */
    uint32_t *tile_of;          /* (capacity) by instance */
    uint32_t *count;            /* (parts, tiles) */
    uint64_t *key, *other_key;  /* (n) depth and number, while they are sorted */
    lt_splat_entry *entry;      /* (capacity) */
} lt_splat_lists;

/* lt_splat_lists_bytes - memory for lists of n Gaussians on an image; lt_splat_lists_in - lists in it, which is aligned
 * to LT_ALIGN */
size_t lt_splat_lists_bytes(int64_t n, int64_t width, int64_t height);
lt_splat_lists lt_splat_lists_in(void *memory, int64_t n, int64_t width, int64_t height);

/* lt_splat_covers - how many tiles a Gaussian's ellipse meets */
uint32_t lt_splat_covers(const lt_splat_seen *g, const lt_splat_view *view);

/* lt_splat_sort - order, drawn and instances, from covers and depth; nothing is in the lists then */
void lt_splat_sort(lt_splat_lists *l, const lt_splat_seen *seen);

/* lt_splat_fill - fill the lists with what fits of the order from `to` on; the last ones when to is drawn then */
void lt_splat_fill(lt_splat_lists *l, const lt_splat_seen *seen, const lt_splat_view *view);

#endif
