/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Binary glTF 2.0 (.glb): several meshes in one file that every viewer opens.
 *
 * Source: KhronosGroup/glTF specification 2.0.
 */
#ifndef LT_IO_MESH_GLB_H
#define LT_IO_MESH_GLB_H

#include "libtensor/base/status.h"
#include "libtensor/geometry/mesh/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* From a moment on a part stands there, until its next key: x_scene = R x + t; or it is not shown. */
typedef struct {
    float seconds;
    float rotation[4], translation[3];      /* unit quaternion w x y z; metres */
    bool shown;
} lt_glb_key;

typedef struct {
    const char *name;               /* UTF-8 */
    const lt_mesh *mesh;
    float color[4];                 /* linear RGBA that colours of vertices are multiplied with */
    const lt_glb_key *key;          /* (n_keys) their seconds rise from 0; of a part that stands still NULL, 0 */
    int n_keys;
} lt_glb_part;

/**
 * lt_glb_write - n parts, each a node with a mesh of its own, atomically
 *
 * Positions, normals, uv and colours where there are any, triangles; metres. Axes are turned from ours to
 * glTF's (x right, y up, z backward), uv from its lower left origin to the upper left one. Numbers are the
 * floats given, to the bit but for signs and 1 - v. Keys are one animation of the nodes, which jumps from key to
 * key; a part that is not shown has scale 0, by which all viewers that animate hide it.
 *
 * Errors: LT_EINVAL: no part, a part without vertices or triangles, a position that is not finite, an index
 * of a vertex that is not there, keys whose seconds do not rise, more than 4 GB; those of lt_atomic_commit.
 */
LT_API lt_status lt_glb_write(const char *path, const lt_glb_part *part, int n);

#ifdef __cplusplus
}
#endif
#endif
