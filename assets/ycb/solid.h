/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the objects' shapes are put together from: solids of levels and sweeps along a path, in millimetres.
 */
#ifndef ASSETS_YCB_SOLID_H
#define ASSETS_YCB_SOLID_H

#include "assets/ycb/loft.h"

/* Where the parts of an object find their colours in the texture; flat ones are set to size by a shape. */
typedef enum { CHART_SIDE, CHART_TOP, CHART_BOTTOM, CHART_SECOND, CHART_THIRD, CHART_COUNT } synth_chart;

extern const loft_chart synth_charts[CHART_COUNT];

/* A level of a solid: the outline at height z. Consecutive levels are joined by straight walls. */
typedef struct {
    synth_chart chart;
    double z, a, b;
    double cx;                      /* shift of the outline along x */
    double power;                   /* of the superellipse; 0: an ellipse */
} solid_level;

/* Where a solid stands and how it is cut. */
typedef struct {
    double origin[3], x[3], y[3], z[3];
    int columns;
    double corner;                  /* of a rectangular outline; below 0: superellipses */
    double bulge, bulge_height;     /* of the sides, fading out at +-bulge_height */
    double step;                    /* longest wall between two rings */
} solid_cut;

/* solid_build - one closed part of n levels, from the lowest to the last */
void solid_build(loft_builder *b, const solid_cut *c, const solid_level *l, int n);

#define SOLID(b, c, ...) \
    solid_build(b, c, (const solid_level[]){ __VA_ARGS__ }, (int)LT_COUNT(((const solid_level[]){ __VA_ARGS__ })))

/* A point of a sweep's path with the half sizes of its section: a in the plane of the path, b across. */
typedef struct { double x, y, z, a, b; } sweep_knot;

/* How a section is moved along a path. */
typedef struct {
    synth_chart chart;
    double up[3];                   /* across the path's plane */
    int columns, rings;
    double power;
    bool closed;
} sweep_pipe;

/* sweep_build - one closed part along a smooth path through n knots */
void sweep_build(loft_builder *b, const sweep_pipe *s, const sweep_knot *k, int n);

#define SWEEP(b, s, ...) \
    sweep_build(b, s, (const sweep_knot[]){ __VA_ARGS__ }, (int)LT_COUNT(((const sweep_knot[]){ __VA_ARGS__ })))

#endif
