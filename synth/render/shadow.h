/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shadow maps with penumbrae that widen with the distance between what casts and what receives.
 *
 * Source: Fernando 2005, "Percentage-closer soft shadows".
 */
#ifndef SYNTH_RENDER_SHADOW_H
#define SYNTH_RENDER_SHADOW_H

#include "synth/render/raster.h"
#include "synth/render/small.h"

enum { SHADOW_SIDE = 1024, SHADOW_BLOCK = 16, SHADOW_BLOCKS = SHADOW_SIDE / SHADOW_BLOCK };

typedef struct {
    raster_view view;
    v4 R[3], t;                     /* the view in single precision: R's columns */
    float focal;
    float lamp_radius;
    float texel;                    /* size of a texel at the focus, m */
    float (*inv_z)[SHADOW_SIDE];    /* nearest caster; 0: none */
    float (*coarse)[SHADOW_BLOCKS]; /* nearest within two blocks of each block */
} shadow_map;

bool shadow_init(shadow_map *map);
void shadow_fini(shadow_map *map);

/* shadow_draw - fill the map for one lamp; LT_ENOMEM */
lt_status shadow_draw(shadow_map *map, raster_list *list, const synth_scene *scene,
                      const synth_light *light);

/* shadow_at - how much of the lamp is seen from p, 0..1; n is the surface's normal, spin in 0..1
 * turns the sampling pattern */
float shadow_at(const shadow_map *map, v4 p, v4 n, float spin);

#endif
