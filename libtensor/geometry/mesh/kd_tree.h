/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: the nearest of many points, or the nearest few.
 *
 * Source: Bentley 1975, "Multidimensional binary search trees used for associative searching".
 */
#ifndef LT_GEOMETRY_MESH_KD_TREE_H
#define LT_GEOMETRY_MESH_KD_TREE_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

typedef struct { double lo[3], hi[3]; } lt_kd_box;

typedef struct {
    double at[3];
    int index;                  /* in the array that the tree was made of */
} lt_kd_point;

/* Halves of halves of the points. Box i is around all of a range; boxes 2 i + 1 and 2 i + 2 around its halves. */
typedef struct {
    int n;
    lt_kd_point *point;         /* the finite ones */
    lt_kd_box *box;
} lt_kd_tree;

/**
 * lt_kd_tree_new - of points (n, 3), of which those that are not finite are left out
 *
 * LT_ENOMEM when there is no memory. Free it with lt_kd_tree_free, which an empty one takes as well.
 */
lt_status lt_kd_tree_new(int n, const double *points, lt_kd_tree *out);
void lt_kd_tree_free(lt_kd_tree *t);

/* lt_kd_tree_distance - from p to the nearest point, to the last bit what going through all of them gives; infinite
 * when there is none, or p is not finite */
double lt_kd_tree_distance(const lt_kd_tree *t, const double p[3]);

typedef struct {
    double square;              /* of its distance */
    int index;
} lt_kd_neighbour;

/* lt_kd_tree_nearest - the k nearest points to p, nearest first, of equal ones the lower index first, into out (k);
 * returns how many there are: fewer than k of few points, 0 where p is not finite. A point of the tree is its own
 * neighbour. */
int lt_kd_tree_nearest(const lt_kd_tree *t, const double p[3], int k, lt_kd_neighbour *out);

#endif
