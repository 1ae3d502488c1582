/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An object's model, which both layouts have alike.
 */
#ifndef SYNTH_WRITE_MODEL_H
#define SYNTH_WRITE_MODEL_H

#include "libtensor/geometry/mesh/mesh.h"
#include "synth/write/file.h"

#ifdef __cplusplus
extern "C" {
#endif

/* synth_write_model - root/models/name: the mesh as textured_simple.obj with its texture (top row
 * first, side x side sRGB), and points.xyz; files gets 4 entries */
lt_status synth_write_model(const char *root, const char *name, const lt_mesh *mesh,
                            const uint8_t (*rgb)[3], int side, const float (*points)[3], int n_points,
                            synth_file *files);

#ifdef __cplusplus
}
#endif
#endif
