/* SPDX-License-Identifier: Apache-2.0 */
/* A description as it grows, and the chunks of a file: what writers of meshes and of Gaussians share. */
#ifndef LT_IO_MESH_GLB_INTERNAL_H
#define LT_IO_MESH_GLB_INTERNAL_H

#include "libtensor/io/atomic_file.h"
#include "libtensor/io/mesh/glb.h"

#include <cjson/cJSON.h>
#include <stdio.h>

enum { GLB_FLOAT = 5126, GLB_UINT = 5125, GLB_VERTICES = 34962, GLB_INDICES = 34963 };

typedef struct {
    cJSON *root, *nodes, *views, *accessors;
    uint64_t bytes;                 /* of the binary chunk so far */
} glb_builder;

/* glb_begin - asset, one scene, empty lists; root is cJSON_Delete's. LT_ENOMEM without a line.
 * glb_add_object - one more in a list.  glb_add_array - count items of that many components of 4 bytes behind those
 * before: a view of the chunk and an accessor, whose number it returns; target 0: neither vertices nor indices.
 * glb_text - all of it, cJSON_free's */
lt_status glb_begin(glb_builder *b);
cJSON *glb_add_object(cJSON *list);
int glb_add_array(glb_builder *b, uint64_t count, int components, int type, int target);
char *glb_text(glb_builder *b);

/* glb_add_motion - a part's keys, of node i;  glb_put_motion - their bytes */
void glb_add_motion(glb_builder *b, const lt_glb_part *p, int node);
void glb_put_motion(FILE *f, const lt_glb_part *p);

/* glb_open - a file with everything before the bytes of the binary chunk; the caller puts these and commits */
lt_status glb_open(const char *path, const char *text, uint64_t binary, lt_atomic_file *f);
void glb_put_u32(FILE *f, uint32_t x);
void glb_put_float(FILE *f, float x);

#endif
