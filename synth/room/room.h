/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where the synthetic hands live: a room with a table, things standing on it, lamps, and the arm that
 * a hand belongs to. All of it is drawn from a seed.
 *
 * The room's own axes: x to the right, y away from the viewer, z up; the table's top is z = 0 and
 * the action takes place over the origin. Metres, linear RGB.
 */
#ifndef SYNTH_ROOM_ROOM_H
#define SYNTH_ROOM_ROOM_H

#include "synth/render/render.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    SYNTH_ROOM_INSTANCES = 96,
    SYNTH_WRIST_LOOP = 16,          /* vertices around a hand's wrist */
};

typedef struct {
    synth_instance instance[SYNTH_ROOM_INSTANCES];      /* label 0; in the room's axes */
    int n_instances;
    synth_light light[SYNTH_MAX_LIGHTS];
    int n_lights;
    float sky[3], ground[3], up[3];
    double focus[3], focus_radius;  /* for synth_scene: holds the action and the things near it */
    double table[4];                /* x0 y0 x1 y1 of its top */
} synth_room;

/**
 * synth_room_new - a room with 3 to 12 things on its table
 *
 *   clear        radius around the origin in which nothing stands, e.g. 0.15
 *   returns      lives in the arena; NULL when there is no memory
 *
 * The walls are at least 1.3 m from the origin, so cameras within 1.2 m are inside. The table reaches
 * at least 0.5 m to the right and left, 0.35 m to the front.
 */
synth_room *synth_room_new(lt_arena *arena, uint64_t seed, uint64_t stream, double clear);

/* A room by its measures. */
typedef struct {
    double table[4];                /* x0 y0 x1 y1 of its top */
    double walls[2];                /* least and greatest distance of a wall from the origin; at most 4.5 */
    double clear;                   /* radius around the origin in which nothing stands */
    double lamps;                   /* least height of a lamp over the table */
} synth_room_measures;

/* synth_room_new_of - a room as synth_room_new's, of these measures; as many things as its random draws find a free
 * place for, at most `things` */
synth_room *synth_room_new_of(lt_arena *arena, uint64_t seed, uint64_t stream, const synth_room_measures *measures,
                              int things);

/* synth_room_paint - the textures of what n cameras may see, without which the room is not to be drawn; false
 * without memory */
bool synth_room_paint(synth_room *room, const synth_camera *camera, int n);

/* What joins a hand to the edge of the picture. */
typedef struct {
    const float (*loop)[3];         /* (16, 3) the wrist's boundary, in order around it */
    const float (*loop_normal)[3];  /* (16, 3) the hand's normals there; NULL: found from the arm */
    const float (*loop_color)[3];   /* (16, 3) the hand's colours there; NULL: skin */
    float skin[3];                  /* albedo of the bare forearm */
    double elbow[3];                /* where the arm goes, from the wrist: a direction */
    double bare;                    /* metres of skin before the sleeve; length or more: no sleeve */
    double length;                  /* metres from wrist to the open end, out of the picture: 0.6 */
    synth_texture *cloth;           /* of the sleeve: synth_arm_cloth; NULL: none */
    bool far;                       /* a few pixels wide: fewer rings, no fine folds */
    uint64_t seed, stream;          /* of the sleeve's folds */
} synth_arm_spec;

/* An arm as two meshes in the axes of the loop. The skin's first ring is the loop itself, so no hole
 * shows; the sleeve overlaps the skin. */
typedef struct {
    lt_mesh skin, sleeve;           /* sleeve.n_faces = 0: none */
    synth_material skin_material, sleeve_material;
} synth_arm;

/* synth_arm_cloth - what a sleeve may be made of; lives in the arena, NULL without memory */
synth_texture *synth_arm_cloth(lt_arena *arena, uint64_t seed, uint64_t stream);

/* synth_arm_new - build it in the arena; LT_EINVAL for a loop or direction that is not finite or has
 * no size, LT_ENOMEM */
lt_status synth_arm_new(lt_arena *arena, const synth_arm_spec *spec, synth_arm *out);

#ifdef __cplusplus
}
#endif
#endif
