/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: laying a posed surface on what a depth camera measured of it.
 */
#ifndef LT_GEOMETRY_DEPTH_FIT_H
#define LT_GEOMETRY_DEPTH_FIT_H

#include "libtensor/base/arena.h"
#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/mesh/mesh.h"
#include "libtensor/geometry/pose.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    lt_camera camera;
    int width, height;
    const float *metres;            /* (height, width) along the optical axis; 0 where nothing was measured */
} lt_depth_map;

/* Points of a surface with their normals: outwards, unit length, in the model's axes, metres */
typedef struct {
    int n;
    float (*point)[3], (*normal)[3];
} lt_surface;

/* lt_surface_of - 800 vertices of the mesh at most, spread over their order, and in *mirrored the same in the mirror
 * x -> -x; in the arena. LT_ENOMEM */
lt_status lt_surface_of(lt_arena *arena, const lt_mesh *mesh, lt_surface *out, lt_surface *mirrored);

/**
 * lt_depth_fit - a pose that is about right, made right by the depth
 *
 * Seven starts: the guess, and the guess turned about each of the model's axes by 25 degrees either way. Each is put
 * first where it agrees best along the line of sight, of steps of a centimetre to 15 cm on both sides. Then iterated
 * closest points from the camera's view: each point that faces it is paired with what its pixel measures, distances
 * count along the normal, and pairs farther apart than a bound that shrinks from 4 cm to 8 mm have no say. What hides
 * the surface (a hand) and what is behind it so falls out. The fit that agrees best is taken: most points within 1 cm
 * of what is measured, fewest before what the camera sees behind them.
 *
 *   pose     in: the guess; out: the fit, or the guess where it meets fewer than 30 measured pixels, or no start does
 *            after it was moved
 *
 * Returns whether there was a fit. Nothing fails: with a pose or a camera that is not finite there is none.
 *
 * Source: Chen and Medioni 1992 (distances along normals); Newcombe et al. 2011, KinectFusion, 3.5 (pairs by
 * projection).
 */
bool lt_depth_fit(const lt_depth_map *depth, const lt_surface *surface, lt_pose *pose);

#ifdef __cplusplus
}
#endif
#endif
