/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Drawing over pictures: what predictions and reports show. Everything is antialiased and cut at the
 * picture's edge; what has a coordinate that is not finite is left out.
 *
 * Coordinates are pixels, with pixel centres at whole numbers. Colours are sRGB bytes.
 */
#ifndef VISION_DRAWING_DRAW_H
#define VISION_DRAWING_DRAW_H

#include "libtensor/base/arena.h"
#include "libtensor/base/common.h"
#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/mesh/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    uint8_t (*rgb)[3];              /* (height, width) */
    int width, height;
} draw_canvas;

typedef struct { uint8_t r, g, b; } draw_color;

enum {
    DRAW_GLYPH_WIDTH = 6, DRAW_GLYPH_HEIGHT = 9,        /* a letter's cell at scale 1 */
    DRAW_MAX_SIDE = 32768,                              /* pixels; a larger canvas is refused */
};

/* draw_canvas_new - filled with one colour, in the arena; rgb NULL when there is no memory */
draw_canvas draw_canvas_new(lt_arena *arena, int width, int height, draw_color fill);

/* draw_line - with round ends; width in pixels, opacity 0..1 */
void draw_line(draw_canvas *c, const float a[2], const float b[2], float width, draw_color color,
               float opacity);

/* draw_disc - a filled circle */
void draw_disc(draw_canvas *c, const float center[2], float radius, draw_color color, float opacity);

/* draw_rect - fill x0 <= x < x1, y0 <= y < y1 */
void draw_rect(draw_canvas *c, int x0, int y0, int x1, int y1, draw_color color, float opacity);

/**
 * draw_skeleton - the bones and joints of a hand
 *
 *   joint    (21, 2)     simple order: wrist, then thumb to little finger from base to tip
 *   size     of the joints' discs in pixels; bones are half as wide
 *
 * Each digit has a colour of its own: thumb red, index yellow, middle green, ring blue, little violet.
 */
void draw_skeleton(draw_canvas *c, const float (*joint)[2], float size);

/* draw_box - the edges of a box from its corners (8, 2) in the order of lt_box21: x fastest, then y, z */
void draw_box(draw_canvas *c, const float (*corner)[2], float width, draw_color color);

/* draw_wire - every edge of a mesh from its projected vertices (n_vertices, 2); faces that name other
 * vertices are left out */
void draw_wire(draw_canvas *c, const float (*vertex)[2], int n_vertices, const int32_t (*face)[3],
               int n_faces, draw_color color, float opacity);

/* draw_mesh - its triangles in the colours of their corners (grey without), lit from the camera, where they are nearer
 * than what was drawn before: nearness (height, width) is 1 / z, 0 before the first mesh. Vertices are in the camera's
 * frame; faces with one behind it are left out. */
void draw_mesh(draw_canvas *c, float *nearness, const lt_camera *camera, const lt_mesh *m);

/* draw_mask - tint the pixels where mask (height, width) is not 0; draw_outline - a line of this width
 * just inside the mask's border */
void draw_mask(draw_canvas *c, const uint8_t *mask, draw_color color, float opacity);
void draw_outline(draw_canvas *c, const uint8_t *mask, int width, draw_color color);

/* draw_text - one line whose top left corner is (x, y), ASCII, in letters of 5 x 7 times scale; other
 * bytes show as '?'. Returns the x where the next letter would stand. */
int draw_text(draw_canvas *c, int x, int y, int scale, draw_color color, const char *text);

/* draw_picture - copy an image, shrunk by averaging or enlarged by repeating to w x h, to (x, y) */
void draw_picture(draw_canvas *c, int x, int y, int w, int h, const draw_canvas *picture);

/**
 * draw_sheet - pictures in a grid with a title above each
 *
 *   picture  n of them, each shown w x h
 *   title    n lines, or NULL; a NULL line is empty
 *   returns  in the arena; rgb NULL when there is no memory or n, columns, w or h is below 1
 */
draw_canvas draw_sheet(lt_arena *arena, const draw_canvas *picture, const char *const *title, int n,
                       int columns, int w, int h);

#ifdef __cplusplus
}
#endif
#endif
