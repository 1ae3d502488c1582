/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How a mesh hangs together: whether it is closed, and which parts it has.
 */
#ifndef LT_GEOMETRY_MESH_PARTS_H
#define LT_GEOMETRY_MESH_PARTS_H

#include "libtensor/base/arena.h"
#include "libtensor/geometry/mesh/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    bool watertight;                /* each edge belongs to two faces, which go along it in opposite directions */
    int components;                 /* parts with faces that share no vertex */
} lt_mesh_topology;

/* lt_mesh_topology_of - LT_EINVAL for a face that names no vertex; LT_ENOMEM */
LT_API lt_status lt_mesh_topology_of(const lt_mesh *mesh, lt_mesh_topology *out);

/* lt_mesh_without_small_parts - positions and faces of the parts that have at least that share of the whole area, in
 * arena memory, in their order; vertices that no face names are left out. Errors: as above. */
LT_API lt_status lt_mesh_without_small_parts(lt_arena *arena, const lt_mesh *mesh, double share, lt_mesh *out);

#ifdef __cplusplus
}
#endif
#endif
