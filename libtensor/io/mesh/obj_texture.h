/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finding the image that an OBJ file's material library names.
 */
#ifndef LT_IO_MESH_OBJ_TEXTURE_H
#define LT_IO_MESH_OBJ_TEXTURE_H

#include "libtensor/base/arena.h"
#include "libtensor/base/status.h"

/**
 * lt_obj_texture - the path of material's map_Kd, in the arena; NULL where lt_obj_read says so
 *
 *   library   the name after mtllib, material the one after usemtl; each may be NULL
 *
 * Errors: LT_ENOMEM only; a library that is missing or makes no sense has no texture.
 */
lt_status lt_obj_texture(lt_arena *arena, lt_arena *scratch, const char *obj_path, const char *library,
                         const char *material, const char **texture);

#endif
