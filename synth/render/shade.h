/* SPDX-License-Identifier: Apache-2.0 */
/* Light on surfaces. */
#ifndef SYNTH_RENDER_SHADE_H
#define SYNTH_RENDER_SHADE_H

#include "synth/render/raster.h"
#include "synth/render/shadow.h"
#include "synth/render/small.h"

/* The scene as the shader reads it: all vertices in the world, in single precision. */
typedef struct {
    const synth_scene *scene;
    const shadow_map *shadow;       /* one for each light */
    v4 *position;
    v4 *normal;                     /* zero: the mesh has none */
    size_t positions_capacity, normals_capacity;
    size_t *first;                  /* each instance's first vertex */
    size_t first_capacity;
    v4 eye;                         /* the camera in the world */
    v4 up, sky, ground;             /* the scene's */
    v4 lamp[SYNTH_MAX_LIGHTS], color[SYNTH_MAX_LIGHTS];
    float distance2[SYNTH_MAX_LIGHTS];      /* lamp to focus, squared */
} shade_scene;

/* What a surface sends to the eye, kept apart because only the first is dimmed in crevices. */
typedef struct { v4 ambient, direct; } shade_sent;

/* A pixel's shadows, looked up once and used by all fragments of one instance. */
typedef struct {
    int instance;                   /* -1: not yet */
    float lit[SYNTH_MAX_LIGHTS];    /* below 0: not yet */
} shade_shadow;

bool shade_prepare(shade_scene *s, const synth_scene *scene, const shadow_map *shadow);
void shade_fini(shade_scene *s);

/* shade - triangle t at sample (x, y); step is the distance between pixels in samples */
shade_sent shade(const shade_scene *s, const raster_triangle *t, float x, float y, float step,
                 float spin, shade_shadow *shadow);

/* shade_square - triangle t at two by two pixels, the first at sample (x, y), the next two beside and below it: the
 * colour of each, and one light for all of them. False where that would show: in a penumbra, and on skin, whose grain
 * bends the light. */
bool shade_square(const shade_scene *s, const raster_triangle *t, float x, float y, float step, float spin,
                  shade_sent out[4]);

#endif
