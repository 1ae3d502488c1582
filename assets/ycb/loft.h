/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Closed meshes with texture coordinates out of stacks of sections: boxes, bottles, vessels, tubes.
 *
 * A loft runs along its sections, each an outline in its own plane, and ends in a pole at either end, or
 * in its own beginning. Where the texture breaks - down the seam, or between two charts - the mesh has a
 * strip SEAM wide, so one uv per vertex is enough and the mesh stays closed.
 */
#ifndef ASSETS_YCB_LOFT_H
#define ASSETS_YCB_LOFT_H

#include "libtensor/base/arena.h"
#include "libtensor/geometry/mesh/mesh.h"

/* A part of the texture: wrapped round the loft, or laid flat on sections up to `half` from the centre. */
typedef struct {
    bool flat;
    double half;
    double u0, v0, u1, v1;
} loft_chart;

typedef struct {
    double centre[3], x[3], y[3];   /* x cross y points along the loft */
    double a, b;                    /* half sizes along x and y */
    double corner;                  /* radius of a rectangle's corners; below 0: a superellipse */
    double power;                   /* of the superellipse: 2 is an ellipse, more is squarer */
    double bulge;                   /* how far the middle of each side stands out */
    const loft_chart *chart;        /* outlives the build */
} loft_section;

enum { LOFT_SECTIONS = 96 };

typedef struct {
    int columns;                    /* points of an outline: a multiple of 4 */
    bool closed;                    /* the last section joins the first */
    int n;
    loft_section section[LOFT_SECTIONS];
} loft;

/* The mesh under construction; a build that does not fit clears ok. */
typedef struct {
    lt_mesh mesh;
    int max_vertices, max_faces;
    bool ok;
} loft_builder;

lt_status loft_builder_init(loft_builder *b, lt_arena *arena, int max_vertices);

/* loft_build - add the loft to the mesh */
void loft_build(loft_builder *b, const loft *l);

/* loft_push - add a section, and before a new chart a copy of the last one that already belongs to it */
void loft_push(loft *l, const loft_section *s);

/* loft_level - a section parallel to the xy plane around (cx, cy, z) */
loft_section loft_level(double cx, double cy, double z, double a, double b, const loft_chart *chart);

/* loft_across - a section across the direction `along`; its y is the part of `up` square to that */
loft_section loft_across(const double centre[3], const double along[3], const double up[3],
                         double a, double b, const loft_chart *chart);

#endif
