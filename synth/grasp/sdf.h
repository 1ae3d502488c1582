/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Signed distance to an object on a grid, for contact: two hundred thousand look-ups per grasp.
 */
#ifndef SYNTH_GRASP_SDF_H
#define SYNTH_GRASP_SDF_H

#include "libtensor/base/arena.h"
#include "libtensor/geometry/mesh/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Metres, negative inside. value[(k * n[1] + j) * n[0] + i] stands at origin + step * (i, j, k). */
typedef struct {
    double origin[3], step;
    int n[3];
    const float *value;
} synth_sdf;

/**
 * synth_sdf_new - sample the distance to a mesh on a grid of 2 mm that reaches 24 mm beyond its box
 *
 * The mesh is closed parts that may overlap, and stands for their union. Exact where the surface is within
 * 6 mm, interpolated between points 8 mm apart beyond. `value` lives in the arena. Runs on all threads.
 *
 * Errors: LT_EINVAL when the mesh is empty, names missing vertices, or is larger than half a metre; LT_ENOMEM.
 */
lt_status synth_sdf_new(lt_arena *arena, const lt_mesh *mesh, synth_sdf *out);

/* synth_sdf_mirror - the distance to the mirror image, x -> -x; lives in the arena. LT_ENOMEM. */
lt_status synth_sdf_mirror(lt_arena *arena, const synth_sdf *sdf, synth_sdf *out);

/* synth_sdf_at - trilinear distance at p and, unless it is NULL, its gradient. Outside the grid: the value at
 * the nearest point of the grid, plus the way there. */
double synth_sdf_at(const synth_sdf *sdf, const double p[3], double gradient[3]);

#ifdef __cplusplus
}
#endif
#endif
