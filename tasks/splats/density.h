/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Density control: Gaussians whose places the images pull at are doubled or cut in two, those that hardly show are
 * taken out.
 *
 * Source: Kerbl et al. 2023, section 5.2; statistics, thresholds and intervals as the paper's code has them.
 */
#ifndef TASKS_HOGS_DENSITY_H
#define TASKS_HOGS_DENSITY_H

#include "libtensor/io/array/array.h"
#include "libtensor/optim/optim.h"
#include "models/hogs/hogs.h"

/* In iterations of stage 1 */
typedef struct {
    int64_t start, end, every, reset;
} density_schedule;

/* Of each row since the last control: the sum of slopes, in how many frames it was seen, its largest radius */
typedef struct {
    lt_row_array slope, seen, radius;
    int64_t densified, pruned;      /* by the last control, or 0: for the log */
    int64_t cap;                    /* Gaussians of a set at most */
    const hogs *m;
} density;

/* density_new - attach the statistics to the model's Gaussians; density_free, once those are gone */
lt_status density_new(density *d, const hogs *m);
void density_free(density *d);

/* density_add - of rows first .. first + n - 1, n numbers each: slopes and radii of a frame, radius 0: not seen */
void density_add(density *d, int64_t first, int64_t n, const lt_real *slope, const lt_real *radius);

/**
 * density_control - at an iteration, before the optimiser moves: clone, split, prune and reset as it is due
 *
 *   seed      of the places of split ones
 *   moved     true: rows are others than before
 *
 * Errors: LT_ENOMEM; a set that has nothing left.
 */
lt_status density_control(density *d, const density_schedule *s, int64_t iteration, uint64_t seed, lt_optim *o,
                          bool *moved);

/* density_total - Gaussians of all sets */
int64_t density_total(const hogs *m);

/* density_save, density_load - the statistics in a checkpoint: as hogs_lists_save and _load */
int density_save(const density *d, lt_named_array *out, int room);
lt_status density_load(density *d, const char *path, const lt_named_array *entry, size_t n);

#endif
