/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A triangle mesh as plain arrays: what the hand layer makes, the renderer draws and the writers save.
 */
#ifndef LT_GEOMETRY_MESH_MESH_H
#define LT_GEOMETRY_MESH_MESH_H

#include "libtensor/base/common.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Metres; triangles are counter-clockwise seen from outside. Optional arrays are NULL when absent.
 * The arrays belong to whoever made them, mostly an arena. */
typedef struct {
    int n_vertices, n_faces;
    float (*vertex)[3];             /* n_vertices */
    int32_t (*face)[3];             /* n_faces */
    float (*normal)[3];             /* n_vertices, unit length; optional */
    float (*uv)[2];                 /* n_vertices, 0..1; optional */
    float (*color)[3];              /* n_vertices, linear RGB 0..1; optional */
} lt_mesh;

#ifdef __cplusplus
}
#endif
#endif
