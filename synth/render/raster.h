/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Triangles to samples, in homogeneous coordinates: nothing is ever clipped, a triangle that crosses
 * the camera's plane simply has a larger box.
 *
 * Source: Olano, Greer 1997, "Triangle scan conversion using 2D homogeneous coordinates".
 */
#ifndef SYNTH_RENDER_RASTER_H
#define SYNTH_RENDER_RASTER_H

#include "synth/render/render.h"
#include "synth/render/small.h"

enum { TILE = 128 };                /* samples, both ways */

/* A camera over a grid of samples, sample (i, j) at i, j. */
typedef struct {
    double fx, fy, cx, cy;
    int width, height;
    double R[9], t[3];              /* x_view = R x_world + t */
} raster_view;

/* e[0] (x - x0) + e[1] (y - y0) + e[2] holds the corners' barycentric coordinates over z, so that the three
 * add to 1/z. */
typedef struct {
    v4 e[3];
    int32_t x0, y0, x1, y1;         /* the samples it may cover, both ends included */
    int32_t instance, face;
    bool back;                      /* seen from behind */
} raster_triangle;

typedef struct {
    raster_triangle *triangle;
    size_t n, capacity;
    int tiles_x, tiles_y;
    uint32_t *tile_start;           /* (tiles + 1) into tile_item */
    size_t tiles_capacity;
    uint32_t *tile_item;            /* triangles of each tile, in the scene's order */
    size_t items_capacity;
    double (*corner)[3];            /* one mesh's vertices in homogeneous sample coordinates */
    size_t corners_capacity;
} raster_list;

void raster_list_fini(raster_list *list);

/* raster_collect - the triangles of the scene seen by view, sorted into tiles; casters: only instances
 * that cast shadows. LT_ENOMEM. */
lt_status raster_collect(raster_list *list, const synth_scene *scene, const raster_view *view,
                         bool casters);

/* raster_draw - write the samples of one triangle inside tile (tx, ty) where it is nearest so far
 *
 *   inv_z    (TILE, TILE)            1/z so far; start with 0
 *   id       (TILE, TILE)            becomes name; NULL: not wanted
 */
void raster_draw(const raster_triangle *t, int tx, int ty, uint32_t name, float *inv_z, uint32_t *id);

/* raster_corner - the barycentric coordinates over z at a sample position, and their sum 1/z */
static inline float raster_corner(const raster_triangle *t, float x, float y, v4 *b)
{
    *b = t->e[0] * v4_all(x - (float)t->x0) + t->e[1] * v4_all(y - (float)t->y0) + t->e[2];
    return v4_sum3(*b);
}

/* grow - room for n items of size bytes, contents lost when it moves; false without memory */
bool raster_grow(void *block, size_t *capacity, size_t n, size_t size);

#endif
