/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The scene that splat rasterisers are timed on: a hand-sized shell beside a filled box of Gaussians, 0.6 m from the
 * camera. Its draws are those of NumPy's RandomState(7), so that peers in Python make the same bytes.
 */
#ifndef EVAL_BENCH_SPLAT_SCENE_H
#define EVAL_BENCH_SPLAT_SCENE_H

#include "libtensor/base/arena.h"

/* n Gaussians, the first n / 2 of them the shell */
typedef struct {
    int64_t n;
    float *centre, *scale, *quaternion, *opacity, *colour;      /* (n, 3), (n, 3), (n, 4) w x y z, (n), (n, 3) */
} splat_scene;

/* splat_scene_new - in the arena's memory. Errors: LT_ENOMEM. */
lt_status splat_scene_new(lt_arena *arena, int64_t n, splat_scene *out);

/* splat_scene_axes - R(q) diag(scale) of each, (n, 3, 3) */
void splat_scene_axes(const splat_scene *s, lt_real *axes);

/* splat_scene_focal - in pixels, of an image of so many: the scene fills it */
double splat_scene_focal(int size);

#endif
