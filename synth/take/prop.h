/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Objects as takes need them: mesh, texture, points, and what answers questions of distance; mirrored for left hands.
 */
#ifndef SYNTH_TAKE_PROP_H
#define SYNTH_TAKE_PROP_H

#include "libtensor/geometry/box21.h"
#include "libtensor/geometry/mesh/surface.h"
#include "synth/grasp/sdf.h"
#include "synth/render/render.h"

#ifdef __cplusplus
extern "C" {
#endif

/* An object that can be handed to takes. */
typedef struct {
    int id;                                     /* 1 .. SYNTH_OBJECTS */
    const char *name;                           /* the model's folder */
    lt_mesh mesh;
    const float (*points)[3];                   /* of points.xyz, SYNTH_POINTS of them; NULL: it has none */
    uint8_t (*rgb)[3];                          /* its texture, SYNTH_TEXTURE a side, top row first */
    synth_texture *texture;
    lt_box box;                                 /* of points */
    lt_mesh_index *index;
    synth_sdf sdf;
    bool mirrored;                              /* mesh, points, box, index and sdf are mirror images, x -> -x */
} synth_prop;

/* synth_prop_new - an object as it is handled; alias: under its real name */
lt_status synth_prop_new(lt_arena *arena, int id, bool alias, synth_prop *out);

/* synth_prop_new_bare - without points, and with the box of the mesh: for pictures alone, and twice as fast */
lt_status synth_prop_new_bare(lt_arena *arena, int id, synth_prop *out);

/* synth_prop_mirror - p in the mirror: what a left hand holds, where the take is filmed as a right hand's */
lt_status synth_prop_mirror(lt_arena *arena, const synth_prop *p, synth_prop *out);

#ifdef __cplusplus
}
#endif
#endif
