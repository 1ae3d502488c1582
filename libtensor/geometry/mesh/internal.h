/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: the tree of boxes over a mesh's triangles, for those who walk it.
 */
#ifndef LT_GEOMETRY_MESH_INTERNAL_H
#define LT_GEOMETRY_MESH_INTERNAL_H

#include "libtensor/geometry/mesh/surface.h"

enum { LT_MESH_STACK = 64 };    /* halving 2^31 faces takes 31 levels, and each leaves one node waiting */

typedef struct {
    double corner[3][3];
    int face;
} lt_mesh_triangle;

/* Children of an inner node are next to each other, from first on; a leaf has count > 0 triangles. */
typedef struct {
    double lo[3], hi[3];
    int first, count;
    double centre[3];           /* of the triangles, by area */
    double area[3];             /* sum of their areas, each along its normal */
    double moment[9];           /* sum of their middles from the centre, each times its area along its normal */
    double radius;              /* from the centre to the farthest corner */
} lt_mesh_node;

struct lt_mesh_index {
    lt_mesh_node *nodes;
    lt_mesh_triangle *triangles;
    int n_nodes;
};

/* lt_mesh_measure_node - centre, area, moment and radius of a node of n triangles; the rest stays */
void lt_mesh_measure_node(lt_mesh_node *node, const lt_mesh_triangle *t, int n);

#endif
