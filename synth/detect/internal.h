/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A picture that is being laid out. Every draw in this folder stands in a statement of its own, as C leaves the order
 * of arguments open.
 */
#ifndef SYNTH_DETECT_INTERNAL_H
#define SYNTH_DETECT_INTERNAL_H

#include "synth/detect/layout.h"
#include "synth/take/settle.h"

enum { LAYOUT_BALLS = 160, LAYOUT_DRAWS = 12 };

static const double LAYOUT_FLOOR = -0.75;       /* metres */
static const double LAYOUT_CUT = 0.08;          /* share of things that the border may cut; of hands from near by: */
static const double LAYOUT_CUT_NEAR = 0.3;

typedef struct {
    lt_arena *arena;
    const detect_place *place;
    detect_picture *out;
    lt_rng r;
    int64_t number;
    bool near;                                  /* what is put down now is a hand from near by */
    int n_grasps;                               /* drawn so far, each from a stream of its own */
    synth_ball ball[LAYOUT_BALLS];              /* where something is */
    int n_balls;
} layout;

/* ---- space.c ---- */

/* layout_add_ball - no other thing may be here; layout_add_rod - nor from a (not included) to b */
void layout_add_ball(layout *l, const double centre[3], double radius);
void layout_add_rod(layout *l, const double a[3], const double b[3], double radius);

/* layout_ball - around a hand, if any, and an object, if any, in their common frame; *lowest: of all their points above
 * the table, or the floor beside it */
synth_ball layout_ball(const layout *l, const synth_grip *g, const synth_prop *prop, const double R[9],
                       const double t[3], double *lowest);

/* layout_fits - whether there is room for a ball, in the picture too: but for few, things are in it or outside */
bool layout_fits(layout *l, const synth_ball *b, double lowest);

/* Where a ball is in the picture. */
typedef enum { LAYOUT_INSIDE, LAYOUT_ACROSS, LAYOUT_OUTSIDE } layout_where_is;
layout_where_is layout_where(const layout *l, const synth_ball *b);

/* layout_unproject - the point of the world at depth z behind a pixel; layout_project - x = (u, v, z) of a point */
void layout_unproject(const synth_camera *c, double u, double v, double z, double out[3]);
void layout_project(const synth_camera *c, const double p[3], double x[3]);

/* layout_note - that it is there, turned by R and moved by t */
void layout_note(layout *l, const detect_put *what, const double R[9], const double t[3]);

/* ---- people.c, objects.c ---- */

/* layout_add_person - with both arms, unless there is no place; layout_add_arm - of somebody outside the picture */
lt_status layout_add_person(layout *l, const synth_person *p);
lt_status layout_add_arm(layout *l);

/* layout_add_objects - that nobody holds: on the table, in the air, some of them before something else */
void layout_add_objects(layout *l);

#endif
