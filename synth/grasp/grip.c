/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where each object can be taken.
 */
#include "synth/grasp/internal.h"

#include "assets/ycb/objects.h"
#include "assets/ycb/shapes.h"
#include "libtensor/geometry/mat3.h"

/* A grip in the shape's own frame, millimetres and degrees; see assets/ycb/shapes.c. */
typedef struct {
    int id;
    const char *kind;
    double centre[3], half[3];
    unsigned approach, thumb;       /* where the palm and the thumb's side of the hand may face */
    double lean;                    /* of the box about z */
    double turn;                    /* either way, about z through pivot_x, 0 */
    double pivot_x, chance;
} design;

enum {
    XP = 1, XN = 2, YP = 4, YN = 8, ZP = 16, ZN = 32,
    SIDES = XP | XN | YP | YN, ANY = SIDES | ZN, ALL = ANY | ZP,
};

static const design designs[] = {
    { 1, "wrap", { 0, 0, 0 }, { 49, 49, 70 }, XP | ZN, ALL, 0, 180, 0, 1 },
    { 2, "wrap", { 0, 0, 0 }, { 35, 80, 106 }, ANY, ALL, 0, 0, 0, 1 },
    { 3, "wrap", { 0, 0, 0 }, { 23, 47, 88 }, ANY, ALL, 0, 0, 0, 1 },
    { 4, "wrap", { 0, 0, 0 }, { 34, 34, 51 }, XP | ZN, ALL, 0, 180, 0, 1 },
    { 5, "wrap", { 0, 0, -28 }, { 47, 29, 62 }, SIDES, ALL, 0, 0, 0, 1 },
    { 5, "wrap", { 0, 0, 52 }, { 24, 20, 30 }, SIDES | ZN, ALL, 0, 0, 0, 0.3 },
    { 6, "wrap", { 0, 0, 0 }, { 42, 42, 17 }, XP | ZN, ALL, 0, 180, 0, 1 },
    { 7, "wrap", { 0, 0, 0 }, { 56, 44, 19 }, ANY, ALL, 0, 0, 0, 1 },
    { 8, "wrap", { 0, 0, 0 }, { 36, 43, 15 }, ANY, ALL, 0, 0, 0, 1 },
    { 9, "wrap", { 0, 0, 0 }, { 50, 28, 42 }, ANY, ALL, 0, 0, 0, 1 },
    { 10, "wrap", { 128, 0, 0 }, { 18, 40, 18 }, XP | XN | ZN, ALL, 0, 0, 0, 1 },
    { 10, "wrap", { 115, 55, 0 }, { 16, 30, 16 }, XP | XN | ZN, ALL, 27, 0, 0, 0.5 },
    { 10, "wrap", { 115, -55, 0 }, { 16, 30, 16 }, XP | XN | ZN, ALL, -27, 0, 0, 0.5 },
    { 11, "hook", { 104, 0, 30 }, { 6, 10, 44 }, XN, ZP, 0, 0, 0, 1 },
    { 12, "wrap", { 0, 0, -50 }, { 51, 34, 70 }, SIDES, ALL, 0, 0, 0, 1 },
    { 12, "wrap", { -14, 0, 72 }, { 32, 25, 34 }, SIDES | ZN, ALL, 0, 0, 0, 0.3 },
    { 13, "rim", { 76, 0, 12 }, { 6, 30, 16 }, ZN, ALL, 0, 180, 0, 1 },
    { 14, "wrap", { 0, 0, 2 }, { 44, 44, 38 }, XP | ZN, ALL, 0, 85, 0, 1 },
    { 14, "rim", { -42, 0, 22 }, { 4, 25, 20 }, ZN, ALL, 0, 100, 0, 0.6 },
    { 14, "hook", { 70, 0, 3 }, { 4, 6, 24 }, XN, ZP, 0, 0, 0, 0.4 },
    { 15, "hook", { -54, -8, 0 }, { 21, 30, 18 }, XP, YP, -10, 0, 0, 1 },
    { 15, "wrap", { -30, 63, 0 }, { 55, 29, 28 }, YN | ZN, ALL, 0, 0, 0, 0.5 },
    { 16, "wrap", { 0, 0, 0 }, { 44, 44, 102 }, ANY, ALL, 0, 0, 0, 1 },
    { 17, "key", { 0, -62, 0 }, { 36, 28, 7.8 }, XP | XN | YP, ALL, 0, 0, 0, 1 },
    { 17, "key", { 0, -10, 0 }, { 12, 30, 6 }, XP | XN | ZN, ALL, 0, 0, 0, 0.6 },
    { 18, "tripod", { 0, 0, 0 }, { 9, 50, 9 }, ZN | XP | XN, ALL, 0, 0, 0, 1 },
    { 19, "key", { 0, -10, 0 }, { 30, 25, 18 }, XP | XN | YP | ZN, ALL, 0, 0, 0, 1 },
    { 19, "wrap", { 35, -45, 0 }, { 9, 35, 12 }, XP | XN | ZN, ALL, 32, 0, 0, 0.7 },
    { 19, "wrap", { -35, -45, 0 }, { 9, 35, 12 }, XP | XN | ZN, ALL, -32, 0, 0, 0.7 },
    { 20, "key", { 0, -8, 0 }, { 30, 22, 18 }, XP | XN | YP | ZN, ALL, 0, 0, 0, 0.7 },
    { 20, "wrap", { 58, -42, 0 }, { 9, 38, 12 }, XP | XN | ZN, ALL, 50, 0, 0, 0.8 },
    { 20, "wrap", { -58, -42, 0 }, { 9, 38, 12 }, XP | XN | ZN, ALL, -50, 0, 0, 0.8 },
    { 21, "wrap", { 0, 0, 0 }, { 26, 38, 25 }, ANY, ALL, 0, 0, 0, 1 },
    { SYNTH_JUG, "hook", { 91, 0, 25 }, { 6, 8, 40 }, XN, ZP, 0, 0, 0, 1 },
};

static void place_axis(const synth_placement *p, const double centre[3], double lean, int k, double out[3])
{
    double tip[3] = { centre[0], centre[1], centre[2] }, from[3];
    const double c = cos(lean), s = sin(lean);
    const double axis[3][3] = { { c, s, 0 }, { -s, c, 0 }, { 0, 0, 1 } };

    for (int i = 0; i < 3; i++)
        tip[i] += axis[k][i];
    synth_place_point(p, centre, from);
    synth_place_point(p, tip, out);
    lt_vec3_sub(out, from, out);
    lt_vec3_unit(out);
}

static grip placed(const design *d, const synth_placement *p)
{
    const double pivot[3] = { d->pivot_x, 0, 0 }, deg = M_PI / 180;
    grip g = {
        .kind = d->kind, .approach = d->approach, .thumb = d->thumb, .turn = d->turn * deg, .chance = d->chance,
    };

    synth_place_point(p, d->centre, g.centre);
    synth_place_point(p, pivot, g.pivot);
    for (int k = 0; k < 3; k++) {
        place_axis(p, d->centre, d->lean * deg, k, g.axis[k]);
        g.half[k] = 1e-3 * d->half[k];
    }
    return g;
}

lt_status grasp_grips(lt_arena *scratch, int id, grip out[MAX_GRIPS], int *n)
{
    synth_placement p;
    lt_mesh mesh;
    lt_status st = synth_object_build(scratch, id, &mesh, &p);

    *n = 0;
    for (size_t i = 0; i < LT_COUNT(designs) && !st; i++)
        if (designs[i].id == id && *n < MAX_GRIPS)
            out[(*n)++] = placed(&designs[i], &p);
    return st;
}
