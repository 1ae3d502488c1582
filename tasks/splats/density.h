/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Density control: Gaussians whose places the images pull at are doubled or cut in two, those that hardly show are
 * taken out.
 *
 * Source: Kerbl et al. 2023, section 5.2; statistics, thresholds and intervals as the paper's code has them.
 */
#ifndef TASKS_SPLATS_DENSITY_H
#define TASKS_SPLATS_DENSITY_H

#include "libtensor/io/array/array.h"
#include "libtensor/optim/optim.h"
#include "models/splats/gaussians.h"

/* In iterations in which Gaussians are drawn */
typedef struct {
    int64_t start, end, every, reset;
} density_schedule;

/* What may stay and how much of it */
typedef struct {
    double extent;                  /* the scene's: sizes count in it */
    double least_opacity;           /* what is less opaque is taken out */
    double most_pixels;             /* what is larger on the screen is taken out, behind the first reset */
    int64_t cap;                    /* Gaussians of a set at most */
    bool reset_at_start;            /* opacities are reset, too, when density control begins: on white */
} density_limits;

/* Of each row since the last control: the sum of slopes, in how many frames it was seen, its largest radius */
typedef struct {
    lt_row_array slope, seen, radius;
    int64_t densified, pruned;      /* by the last control, or 0: for the log */
    density_limits limits;
    const gaussians *g;
} density;

/* density_new - attach the statistics to Gaussians, which stay where they are; density_free, once those are gone */
lt_status density_new(density *d, const gaussians *g, const density_limits *limits);
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
int64_t density_total(const gaussians *g);

/* density_save, density_load - the statistics in a checkpoint: as checkpoint_own has them */
int density_save(const density *d, lt_named_array *out, int room);
lt_status density_load(density *d, const char *path, const lt_named_array *entry, size_t n);

#endif
