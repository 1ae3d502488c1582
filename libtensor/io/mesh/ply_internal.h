/* SPDX-License-Identifier: Apache-2.0 */
/* What the parts of the PLY reader share: the header as it was read, before any row. */
#ifndef LT_IO_MESH_PLY_INTERNAL_H
#define LT_IO_MESH_PLY_INTERNAL_H

#include "libtensor/io/mesh/ply.h"

typedef enum { LT_PLY_TEXT, LT_PLY_LITTLE, LT_PLY_BIG } lt_ply_format;

/* lt_ply_header - elements and properties, without values but with their types; of a list, count_type says
 * how its lengths are stored (by element and property). *body is where the rows begin. */
typedef struct {
    lt_ply ply;
    lt_ply_format format;
    lt_elem **count_type;
    size_t body;
} lt_ply_head;

lt_status lt_ply_header(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_ply_head *out);

#endif
