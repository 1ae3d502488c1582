/* SPDX-License-Identifier: Apache-2.0 */
/* What is worn, for wear.c to make meshes of. Private to this folder. */
#ifndef SYNTH_BODY_CLOTHES_H
#define SYNTH_BODY_CLOTHES_H

#include "synth/body/appearance.h"

/* A point of the body at rest: x, height above the floor, z; the distance from the middle. Metres. */
typedef struct { double x, up, z, aside; } rest_place;

static inline rest_place rest_place_of(const double p[3])
{
    return (rest_place){ p[0], p[1] + 0.955, p[2], p[0] < 0 ? -p[0] : p[0] };
}

static const double CLOTHES_ARM = 0.2;          /* what is farther from the middle is an arm, at rest */

/* A piece of what is worn, or drawn on the skin. */
typedef struct {
    double (*there)(const synth_appearance *a, rest_place p);   /* above 0: it is; metres from its edge, nearly */
    double (*off)(const synth_appearance *a, rest_place p);     /* metres off the skin */
    int split;                                  /* each edge into so many, where the piece is finer than the skin */
    bool hides;                                 /* the skin under it is not seen */
} clothes_piece;

enum { CLOTHES_PIECES = 7 };
extern const clothes_piece clothes_pieces[CLOTHES_PIECES];

synth_material clothes_material(const synth_appearance *a, int piece);

/* clothes_skin - colour of the bare skin; clothes_eye - of an eye, `off` from its middle */
void clothes_skin(const synth_appearance *a, rest_place p, float out[3]);
void clothes_eye(const synth_appearance *a, const double off[3], float out[3]);

/* clothes_ramp - 0 at lo, 1 at hi, smooth between; lo may be above hi */
static inline double clothes_ramp(double lo, double hi, double x)
{
    double t = (x - lo) / (hi - lo);

    t = t < 0 ? 0 : t > 1 ? 1 : t;
    return t * t * (3 - 2 * t);
}

#endif
