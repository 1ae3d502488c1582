/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Linear blend skinning that networks learn through: from a rotation of each joint and some shape numbers to a posed
 * mesh and points on it, in lt_real with unit-stride arrays, relative to the root joint, with gradient.
 *
 * Source: Loper et al. 2015, "SMPL"; Romero, Tzionas, Black 2017, "Embodied Hands".
 */
#ifndef LT_GEOMETRY_SKIN_SKIN_H
#define LT_GEOMETRY_SKIN_SKIN_H

#include "libtensor/base/arena.h"
#include "libtensor/geometry/skin/rig.h"
#include "libtensor/kernels/kernels.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A rig laid out for speed. Read-only once made: any number of threads may use it. */
typedef struct lt_skin_layer lt_skin_layer;

/**
 * lt_skin_layer_new - lays out `rig` (copied) in the arena
 *
 *   points      (n_points) what the second result has: p < J is a joint, others vertex p - J
 *
 * Errors: LT_ENOMEM; LT_EINVAL when the rig has no vertex, no joint or more than LT_RIG_JOINTS, when a joint comes
 * before its parent, when a point is neither joint nor vertex, and as lt_kernels_init.
 */
LT_API lt_status lt_skin_layer_new(lt_arena *arena, const lt_rig *rig, const int *points, int n_points,
                                   lt_skin_layer **out);

/* The arrays of a layer, borrowed from it, for those who write it down elsewhere. Coordinate a of vertex i, of `groups`
 * of LT_SKIN_GROUP that hold V vertices and then zeros, is [i / LT_SKIN_GROUP][a][i % LT_SKIN_GROUP]. */
typedef struct {
    int V, J, S, P;                     /* P: pose directions, 9 (J - 1) or 0 */
    int64_t groups, padded;             /* padded = groups * LT_SKIN_GROUP */
    const int *parents;                 /* (J) */
    const int *points;                  /* (n_points) */
    int n_points;
    const lt_real *blend;               /* (1 + S + P, groups, 3, LT_SKIN_GROUP) template, shape, pose directions */
    const lt_real *weight;              /* (J, padded) */
    const double (*rest)[3];            /* (J, 3) joints of the mean shape, */
    const double (*rest_shape)[3];      /* (S, J, 3) and how they follow the shape */
} lt_skin_tables;

LT_API lt_skin_tables lt_skin_layer_tables(const lt_skin_layer *layer);

/* lt_skin_scratch_bytes - what forward leaves for backward, of n samples; the caller's memory, aligned to LT_ALIGN */
LT_API size_t lt_skin_scratch_bytes(const lt_skin_layer *layer, int64_t n);

/**
 * lt_skin_forward - n samples, on all threads
 *
 *   R          (n, J, 3, 3); any matrices, the formula does not ask for rotations
 *   shape      (n, S)
 *   vertices   (n, V, 3) relative to the root
 *   points     (n, n_points, 3), relative to the root
 *   scratch    of lt_skin_scratch_bytes
 */
LT_API void lt_skin_forward(const lt_skin_layer *layer, int64_t n, const lt_real *R, const lt_real *shape,
                            lt_real *vertices, lt_real *points, void *scratch);

/**
 * lt_skin_backward - the gradient of lt_skin_forward, added to d_R and d_shape
 *
 *   d_vertices (n, V, 3), d_points (n, n_points, 3), d_R, d_shape may each be NULL. R is forward's; scratch as forward
 *   left it: used up here, so backward runs once.
 */
LT_API void lt_skin_backward(const lt_skin_layer *layer, int64_t n, const lt_real *R, const lt_real *d_vertices,
                             const lt_real *d_points, lt_real *d_R, lt_real *d_shape, void *scratch);

#ifdef __cplusplus
}
#endif
#endif
