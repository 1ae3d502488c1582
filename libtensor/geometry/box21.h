/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The 21 control points of a bounding box: 8 corners, 12 midpoints of edges, the centre.
 */
#ifndef LT_GEOMETRY_BOX21_H
#define LT_GEOMETRY_BOX21_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { LT_BOX_CORNERS = 8, LT_BOX_EDGES = 12, LT_BOX_POINTS = 21 };

/* Axis-aligned, in the frame of the points it was made from; metres. */
typedef struct {
    double lo[3], hi[3];
} lt_box;

/* The corners (below 8) that the edges of the box join, for drawing: edge e has midpoint 8 + e. */
static const int lt_box_edge[LT_BOX_EDGES][2] = {
    { 0, 2 }, { 1, 3 }, { 2, 3 }, { 0, 1 }, { 4, 6 }, { 5, 7 },
    { 6, 7 }, { 4, 5 }, { 6, 2 }, { 4, 0 }, { 7, 3 }, { 5, 1 },
};

/* lt_box_from_points - the smallest box around n points (n, 3). LT_EINVAL when n < 1 or a coordinate is
 * not finite; out is then untouched. */
LT_API lt_status lt_box_from_points(int n, const float *points, lt_box *out);

/* lt_box_diagonal - the "diameter" of ADD-0.1D in the HOCAT, HFL-Net and Semi-Hand-Object tables */
LT_API double lt_box_diagonal(const lt_box *box);

/**
 * lt_box21 - the control points, (21, 3)
 *
 * Corner i takes hi along x, y, z where bit 0, 1, 2 of i is set. Then the midpoints in the order of
 * lt_box_edge, then the centre.
 *
 * Source: stevenlsw/Semi-Hand-Object dataset/dataset_util.py.
 */
LT_API void lt_box21(const lt_box *box, double points[LT_BOX_POINTS][3]);

#ifdef __cplusplus
}
#endif
#endif
