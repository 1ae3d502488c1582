/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A still scene as Gaussians, drawn from one camera at a time, for pictures of one size.
 *
 * Inputs of its graphs, N the rows that there is room for, W x H the canvas:
 *   "view" (1, 3, 4) the world to the camera        "camera" (4) fx, fy, cx, cy
 *   "row" (1) LT_I32 0        "alive" (N, 1) 1 where a row is in use, else 0        "degree" (1) LT_I32 0 to 3
 * with losses:
 *   "offset" (N, 2) zeros, whose gradient density control looks at
 *   "weight" (1, H, W) 1 where a pixel counts, else 0        "target" (3, H, W) zeros where it does not
 * Outputs: "picture" (3, H, W), "radius" (N) pixels; without losses also "centre" (N, 3) in the camera's frame, and
 * "colour" (N, 3) as it sees them.
 *
 * Source: Kerbl et al. 2023, "3D Gaussian splatting for real-time radiance field rendering".
 */
#ifndef MODELS_SPLATS_SPLATS_H
#define MODELS_SPLATS_SPLATS_H

#include "models/model.h"
#include "models/splats/gaussians.h"

typedef struct {
    int variant;
    int gaussians, cap;             /* at first, at most */
    int width, height;
    double extent;                  /* of the scene, in the world's unit: how far apart the cameras stand */
    int white;
} splats_config;

/* Where Gaussians begin. Borrowed. */
typedef struct {
    const float (*place)[3], (*colour)[3];      /* (config.gaussians) in the world; 0 .. 1, NULL: grey */
} splats_scene;

typedef struct {
    splats_config config;           /* first, as model_class wants it */
    gaussians gaussians;            /* of one set */
    const splats_scene *scene;      /* given before init; NULL: a ball, to measure with */
} splats;

extern const model_class splats_class;

static inline const splats *splats_of(const model *m) { return m->self; }

/* splats_near - nothing nearer to a camera than a twentieth of the scene's extent is drawn */
static inline double splats_near(const splats *m) { return 0.05 * m->config.extent; }

/* splats_give_scene - what init places Gaussians at; outlives it */
void splats_give_scene(model *m, const splats_scene *scene);

#endif
