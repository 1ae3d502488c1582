/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The Gaussians of all sets, a set being what is drawn or posed as one: a scene, a subject's hand, an object. One
 * parameter for each kind of number, in which every set has as many rows, and uses the first of them. Which set a graph
 * reads is data.
 *
 * Source: Kerbl et al. 2023, "3D Gaussian splatting for real-time radiance field rendering".
 */
#ifndef MODELS_SPLATS_GAUSSIANS_H
#define MODELS_SPLATS_GAUSSIANS_H

#include "libtensor/base/arena.h"
#include "libtensor/graph/rows.h"
#include "libtensor/io/mesh/ply.h"
#include "libtensor/ops/ops.h"

enum { GAUSSIANS_SH = 16, GAUSSIANS_KINDS = 7 };

typedef struct {
    int sets;
    lt_param *centre;               /* (rows, 3) metres */
    lt_param *log_scale;            /* (rows, 3) */
    lt_param *quaternion;           /* (rows, 4) w x y z, of any length */
    lt_param *opacity;              /* (rows, 1) its logit */
    lt_param *dc, *rest;            /* (rows, 1, 3), (rows, 15, 3): spherical harmonics */
    lt_param *feature;              /* (rows, F) that another network makes colours of; NULL: none */
    lt_param *count;                /* (sets) how many rows are in use; moved by density control alone */
} gaussians;

/* gaussians_new - parameters PREFIX.centre, .. with room for `each` Gaussians a set, and so many features of one */
void gaussians_new(gaussians *g, lt_params *set, const char *prefix, int sets, int64_t each, int features);

/* gaussians_kinds - those that have rows, how many there are */
int gaussians_kinds(const gaussians *g, lt_param *out[GAUSSIANS_KINDS]);

/* gaussians_capacity - rows of a set;  gaussians_first - its first one;  gaussians_count - rows in use */
int64_t gaussians_capacity(const gaussians *g);
int64_t gaussians_first(const gaussians *g, int set);
int64_t gaussians_count(const gaussians *g, int set);

/* gaussians_place - the set's Gaussians at n places (n, 3): white, hardly opaque, as large as their neighbours are far.
 * Errors: LT_ENOMEM; LT_EINVAL for more than there is room for. */
lt_status gaussians_place(const gaussians *g, int set, const float (*place)[3], int64_t n);

/* gaussians_scale - exp of a row's largest log scale: a deviation along its longest axis, metres */
double gaussians_scale(const gaussians *g, int64_t row);

/* gaussians_splats - of a set, in arena memory, as files have them. LT_ENOMEM */
lt_status gaussians_splats(const gaussians *g, int set, lt_arena *arena, lt_splat **out, size_t *n);

/* A set as graphs read it, N the capacity. A row that is not in use holds zeros and has no opacity. */
typedef struct {
    lt_tensor *centre, *log_scale, *quaternion;     /* (N, 3), (N, 3), (N, 4) */
    lt_tensor *opacity;             /* (N, 1) in 0 .. 1 */
    lt_tensor *sh;                  /* (N, 16, 3) */
    lt_tensor *feature;             /* (N, F), or NULL */
} gaussian_rows;

/* gaussians_rows - of the set whose first row is `first`, (1) LT_I32; alive (N, 1): 1 where a row is in use, else 0 */
gaussian_rows gaussians_rows(const gaussians *g, lt_tensor *first, lt_tensor *alive);

#endif
