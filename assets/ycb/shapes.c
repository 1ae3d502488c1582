/* SPDX-License-Identifier: Apache-2.0 */
#include "assets/ycb/shapes.h"

#include "assets/ycb/objects.h"
#include "assets/ycb/solid.h"

#include <assert.h>
#include <math.h>

static const solid_cut upright = {
    .x = { 1, 0, 0 }, .y = { 0, 1, 0 }, .z = { 0, 0, 1 }, .columns = 48, .corner = -1, .step = 8,
};

/* ---- cans and boxes ------------------------------------------------------------------------------- */

/* A can with a recessed lid and a bead round both rims. */
static void can(loft_builder *b, double r, double h, double power, double depth)
{
    const double f = depth / r;
    solid_cut c = upright;
#define AT(chart, z, a) { chart, z, a, (a) * f, 0, power }
    SOLID(b, &c,
          AT(CHART_BOTTOM, 1.5 - h, 0.3 * r), AT(CHART_BOTTOM, 1.5 - h, r - 5), AT(CHART_BOTTOM, -h, r - 3),
          AT(CHART_BOTTOM, -h, r - 1.2), AT(CHART_SIDE, 0.4 - h, r - 0.4), AT(CHART_SIDE, 1.4 - h, r),
          AT(CHART_SIDE, 3.2 - h, r), AT(CHART_SIDE, 4.2 - h, r - 0.9), AT(CHART_SIDE, h - 4.2, r - 0.9),
          AT(CHART_SIDE, h - 3.2, r), AT(CHART_SIDE, h - 1.4, r), AT(CHART_TOP, h - 0.4, r - 0.4),
          AT(CHART_TOP, h, r - 1.2), AT(CHART_TOP, h, r - 3), AT(CHART_TOP, h - 2.5, r - 4),
          AT(CHART_TOP, h - 2.5, 0.3 * r));
#undef AT
}

/* A box with half sizes a, b, h at the edges, bulging by `bulge` in the middle of its sides. */
static void box(loft_builder *b, double a, double d, double h, double edge, double bulge)
{
    solid_cut c = upright;
    const double e = edge * 0.293;              /* 1 - cos 45 degrees */

    c.columns = 60;
    c.corner = edge;
    c.bulge = bulge;
    c.bulge_height = h;
    c.step = fmax(8, h / 12);
    SOLID(b, &c,
          { CHART_BOTTOM, -h, 0.1 * a, 0.1 * d, 0, 0 }, { CHART_BOTTOM, -h, 0.6 * a, 0.6 * d, 0, 0 },
          { CHART_BOTTOM, -h, a - edge, d - edge, 0, 0 }, { CHART_SIDE, e - h, a - e, d - e, 0, 0 },
          { CHART_SIDE, edge - h, a, d, 0, 0 }, { CHART_SIDE, h - edge, a, d, 0, 0 },
          { CHART_SIDE, h - e, a - e, d - e, 0, 0 },
          { CHART_TOP, h, a - edge, d - edge, 0, 0 }, { CHART_TOP, h, 0.6 * a, 0.6 * d, 0, 0 },
          { CHART_TOP, h, 0.1 * a, 0.1 * d, 0, 0 });
}

/* ---- bottles -------------------------------------------------------------------------------------- */

static void mustard(loft_builder *b)
{
    solid_cut c = upright;

    c.columns = 52;
    SOLID(b, &c,
          { CHART_BOTTOM, -94, 8, 6, 0, 2.6 }, { CHART_BOTTOM, -94, 25, 15, 0, 2.6 },
          { CHART_BOTTOM, -95.5, 42, 23, 0, 2.6 }, { CHART_SIDE, -93, 45.5, 26.5, 0, 2.6 },
          { CHART_SIDE, -88, 47.5, 28.5, 0, 2.6 }, { CHART_SIDE, -30, 47.9, 28.8, 0, 2.6 },
          { CHART_SIDE, 8, 46.5, 28.8, 0, 2.6 }, { CHART_SIDE, 26, 43.5, 28, 0, 2.5 },
          { CHART_SIDE, 38, 38, 26, 0, 2.3 }, { CHART_SIDE, 47, 30, 22.5, 0, 2.1 },
          { CHART_SIDE, 52, 23, 19.5, 0, 2 }, { CHART_SIDE, 55, 16, 16, 0, 0 },
          { CHART_SECOND, 57, 15, 15, 0, 0 }, { CHART_SECOND, 58, 17, 17, 0, 0 },
          { CHART_SECOND, 72, 16.5, 16.5, 0, 0 },
          { CHART_SECOND, 74, 14.5, 14.5, 0, 0 }, { CHART_SECOND, 75, 9, 9, 0, 0 },
          { CHART_SECOND, 90, 4.5, 4.5, 0, 0 },
          { CHART_SECOND, 95.5, 3.2, 3.2, 0, 0 }, { CHART_SECOND, 95.9, 1.5, 1.5, 0, 0 });
}

/* The finger hole of the bleach bottle: both broad faces are pressed in beside the neck. */
static void press_grip(lt_mesh *m)
{
    for (int i = 0; i < m->n_vertices; i++) {
        const double x = (m->vertex[i][0] - 24) / 13, z = (m->vertex[i][2] - 38) / 34;
        const double r2 = x * x + z * z;
        if (r2 < 1)
            m->vertex[i][1] *= (float)(1 - 0.72 * (1 - r2) * (1 - r2));
    }
}

static void bleach(loft_builder *b)
{
    solid_cut c = upright;

    c.columns = 52;
    c.step = 7;
    SOLID(b, &c,
          { CHART_BOTTOM, -123, 8, 6, 0, 3 }, { CHART_BOTTOM, -123, 28, 18, 0, 3 },
          { CHART_BOTTOM, -125, 44, 27, 0, 3 }, { CHART_SIDE, -122, 48.5, 31.5, 0, 3 },
          { CHART_SIDE, -116, 51, 33.8, 0, 3 }, { CHART_SIDE, 5, 51, 33.8, 0, 3 },
          { CHART_SIDE, 30, 49.5, 33, -1, 2.8 }, { CHART_SIDE, 55, 45, 31, -4, 2.6 },
          { CHART_SIDE, 72, 38, 28, -8, 2.4 }, { CHART_SIDE, 83, 29, 23, -12, 2.2 },
          { CHART_SIDE, 90, 20, 18, -15, 2 }, { CHART_SIDE, 93, 16, 16, -16, 0 },
          { CHART_SECOND, 96, 15.5, 15.5, -16, 0 }, { CHART_SECOND, 97, 18.5, 18.5, -16, 0 },
          { CHART_SECOND, 122, 17.5, 17.5, -16, 0 }, { CHART_SECOND, 124.6, 15.5, 15.5, -16, 0 },
          { CHART_SECOND, 125.3, 6, 6, -16, 0 });
    press_grip(&b->mesh);
}

/* ---- vessels -------------------------------------------------------------------------------------- */

static void mug(loft_builder *b)
{
    const sweep_pipe handle = { CHART_SECOND, { 0, 1, 0 }, 16, 30, 2.6, false };

    SOLID(b, &upright,
          { CHART_BOTTOM, -39, 8, 8, 0, 0 }, { CHART_BOTTOM, -39, 33, 33, 0, 0 }, { CHART_BOTTOM, -40.5, 35, 35, 0, 0 },
          { CHART_SIDE, -40.2, 38, 38, 0, 0 }, { CHART_SIDE, -38, 41.5, 41.5, 0, 0 },
          { CHART_SIDE, -34, 43.5, 43.5, 0, 0 },
          { CHART_SIDE, 39.5, 44, 44, 0, 0 }, { CHART_SECOND, 40.6, 43.2, 43.2, 0, 0 },
          { CHART_SECOND, 40.6, 42, 42, 0, 0 },
          { CHART_THIRD, 39.5, 41.2, 41.2, 0, 0 }, { CHART_THIRD, -32, 40.5, 40.5, 0, 0 },
          { CHART_THIRD, -35.5, 37, 37, 0, 0 }, { CHART_THIRD, -36.2, 30, 30, 0, 0 },
          { CHART_THIRD, -36.2, 8, 8, 0, 0 });
    SWEEP(b, &handle, { 42.2, 0, 25, 3.5, 6.5 }, { 52, 0, 26.5, 4, 6 }, { 65, 0, 20, 4, 6 },
          { 71, 0, 4, 4, 6 }, { 65, 0, -13, 4, 6 }, { 54, 0, -22, 4, 6 }, { 42.2, 0, -24, 3.5, 6.5 });
}

/* The rim is drawn out over the spout, on the side away from the handle. */
static void pull_lip(lt_mesh *m)
{
    for (int i = 0; i < m->n_vertices; i++) {
        float *p = m->vertex[i];
        const double up = fmax(0, (p[2] - 72) / 48), side = fmax(0, 1 - pow(atan2(p[1], -p[0]) / 0.42, 2));
        p[0] -= (float)(6 * up * up * side * side);
    }
}

static void pitcher(loft_builder *b)
{
    const sweep_pipe handle = { CHART_SECOND, { 0, 1, 0 }, 16, 32, 3, false };
    solid_cut c = upright;

    c.columns = 40;
    c.step = 15;
    SOLID(b, &c,
          { CHART_BOTTOM, -117.5, 10, 10, 0, 0 }, { CHART_BOTTOM, -117.5, 36, 36, 0, 0 },
          { CHART_BOTTOM, -120.5, 39, 39, 0, 0 }, { CHART_SIDE, -119, 44, 44, 0, 0 },
          { CHART_SIDE, -114, 49, 49, 0, 0 }, { CHART_SIDE, 60, 57, 57, 0, 0 },
          { CHART_SIDE, 90, 58, 58, 0, 0 }, { CHART_SIDE, 92, 60, 60, 0, 0 },
          { CHART_SIDE, 120, 60.5, 60.5, 0, 0 }, { CHART_SECOND, 121.5, 59.5, 59.5, 0, 0 },
          { CHART_SECOND, 121.5, 58, 58, 0, 0 }, { CHART_THIRD, 120, 57.5, 57.5, 0, 0 },
          { CHART_THIRD, 92, 57, 57, 0, 0 }, { CHART_THIRD, 60, 54.5, 54.5, 0, 0 },
          { CHART_THIRD, -110, 46.5, 46.5, 0, 0 }, { CHART_THIRD, -114, 40, 40, 0, 0 },
          { CHART_THIRD, -114, 10, 10, 0, 0 });
    pull_lip(&b->mesh);
    SWEEP(b, &handle, { 56.6, 0, 78, 5, 11 }, { 76, 0, 83, 5, 10 }, { 99, 0, 76, 5.5, 10 },
          { 107, 0, 54, 5.5, 10 }, { 104, 0, 15, 5.5, 10 }, { 91, 0, -16, 5.5, 10 },
          { 71, 0, -30, 5, 10 }, { 51.8, 0, -36, 3.5, 10 });
}

/* Of stoneware: a belly, a neck, and a handle that takes a whole hand. */
static void jug(loft_builder *b)
{
    const sweep_pipe handle = { CHART_SECOND, { 0, 1, 0 }, 16, 30, 2, false };
    solid_cut c = upright;

    c.columns = 40;
    c.step = 12;
    SOLID(b, &c,
          { CHART_BOTTOM, -93, 9, 9, 0, 0 }, { CHART_BOTTOM, -93, 34, 34, 0, 0 }, { CHART_BOTTOM, -95, 36, 36, 0, 0 },
          { CHART_SIDE, -94, 39, 39, 0, 0 }, { CHART_SIDE, -70, 46, 46, 0, 0 }, { CHART_SIDE, -35, 51.5, 51.5, 0, 0 },
          { CHART_SIDE, -20, 52, 52, 0, 0 }, { CHART_SIDE, 5, 50.5, 50.5, 0, 0 }, { CHART_SIDE, 40, 43, 43, 0, 0 },
          { CHART_SIDE, 62, 39.5, 39.5, 0, 0 }, { CHART_SIDE, 80, 41, 41, 0, 0 }, { CHART_SIDE, 94, 46, 46, 0, 0 },
          { CHART_SECOND, 95, 45, 45, 0, 0 }, { CHART_SECOND, 94.5, 43.5, 43.5, 0, 0 },
          { CHART_THIRD, 80, 37.5, 37.5, 0, 0 }, { CHART_THIRD, 62, 36, 36, 0, 0 },
          { CHART_THIRD, 40, 39.5, 39.5, 0, 0 }, { CHART_THIRD, 5, 47, 47, 0, 0 },
          { CHART_THIRD, -20, 48.5, 48.5, 0, 0 }, { CHART_THIRD, -70, 42, 42, 0, 0 },
          { CHART_THIRD, -88, 35, 35, 0, 0 }, { CHART_THIRD, -89, 9, 9, 0, 0 });
    SWEEP(b, &handle, { 39.5, 0, 72, 5, 9 }, { 62, 0, 78, 6, 8.5 }, { 84, 0, 70, 6.5, 8.5 },
          { 93.5, 0, 44, 6.5, 8.5 }, { 91, 0, 10, 6.5, 8.5 }, { 78, 0, -20, 6, 8.5 },
          { 64, 0, -34, 5.5, 8.5 }, { 48.5, 0, -42, 4, 9 });
}

static void bowl(loft_builder *b)
{
    solid_cut c = upright;

    c.columns = 64;
    c.step = 9;
    SOLID(b, &c,
          { CHART_BOTTOM, -25.5, 8, 8, 0, 0 }, { CHART_BOTTOM, -25.5, 36, 36, 0, 0 },
          { CHART_BOTTOM, -27.5, 37, 37, 0, 0 },
          { CHART_SIDE, -27.5, 40, 40, 0, 0 }, { CHART_SIDE, -23, 42, 42, 0, 0 }, { CHART_SIDE, -17, 54, 54, 0, 0 },
          { CHART_SIDE, -8, 64.5, 64.5, 0, 0 }, { CHART_SIDE, 3, 72, 72, 0, 0 }, { CHART_SIDE, 15, 77.5, 77.5, 0, 0 },
          { CHART_SIDE, 26.5, 80.6, 80.6, 0, 0 }, { CHART_SIDE, 27.5, 79.6, 79.6, 0, 0 },
          { CHART_THIRD, 26.8, 78.2, 78.2, 0, 0 }, { CHART_THIRD, 15, 75, 75, 0, 0 },
          { CHART_THIRD, 3, 69.5, 69.5, 0, 0 },
          { CHART_THIRD, -8, 62, 62, 0, 0 }, { CHART_THIRD, -17, 51.5, 51.5, 0, 0 },
          { CHART_THIRD, -22.5, 38, 38, 0, 0 },
          { CHART_THIRD, -23, 8, 8, 0, 0 });
}

/* ---- the rest ------------------------------------------------------------------------------------- */

static void banana(loft_builder *b)
{
    enum { N = 13 };
    static const double radius[N] = { 4.6, 5.2, 8.5, 13.5, 16.6, 18, 18.4, 18.2, 17.2, 14.6, 10, 5.2, 3.6 };
    static const double at[N] = { 0, .06, .11, .19, .29, .4, .51, .62, .73, .83, .91, .965, 1 };
    const sweep_pipe p = { CHART_SIDE, { 0, 0, 1 }, 40, 44, 2.15, false };
    const double bend = 98 * M_PI / 180, r = 219 / bend;
    sweep_knot k[N];

    for (int i = 0; i < N; i++) {
        const double w = bend * (at[i] - 0.5);
        k[i] = (sweep_knot){ r * cos(w), r * sin(w), 0, radius[i], radius[i] };
    }
    sweep_build(b, &p, k, N);
}

static const solid_cut along_x = {
    .x = { 0, 1, 0 }, .y = { 0, 0, 1 }, .z = { 1, 0, 0 }, .columns = 28, .corner = -1, .step = 11,
};

/* Barrel and chuck lie along x, the handle leans back to a battery block at -y. */
static void drill(loft_builder *b)
{
    const double lean = 10 * M_PI / 180;
    solid_cut barrel = along_x, handle = upright, battery = upright;

    barrel.origin[1] = 63;
    SOLID(b, &barrel,
          { CHART_SECOND, -92, 6, 6, 0, 0 }, { CHART_SECOND, -91, 20, 19, 0, 2.6 },
          { CHART_SECOND, -85, 27, 25, 0, 2.6 }, { CHART_SIDE, -70, 30, 28.6, 0, 2.6 },
          { CHART_SIDE, 5, 30, 28.6, 0, 2.6 }, { CHART_SIDE, 20, 25, 25, 0, 0 }, { CHART_SECOND, 38, 22, 22, 0, 0 },
          { CHART_SECOND, 41, 19, 19, 0, 0 }, { CHART_SECOND, 60, 17.5, 17.5, 0, 0 }, { CHART_SECOND, 72, 8, 8, 0, 0 },
          { CHART_THIRD, 73, 3, 3, 0, 0 }, { CHART_THIRD, 91, 3, 3, 0, 0 }, { CHART_THIRD, 92, 1, 1, 0, 0 });

    handle.columns = 28;
    handle.step = 10;
    handle.origin[0] = -44;
    handle.origin[1] = 50;
    handle.z[0] = -sin(lean), handle.z[1] = -cos(lean), handle.z[2] = 0;
    handle.x[0] = cos(lean), handle.x[1] = -sin(lean), handle.x[2] = 0;
    handle.y[1] = 0, handle.y[2] = 1;
    SOLID(b, &handle,
          { CHART_SECOND, 0, 5, 4, 0, 2.4 }, { CHART_SECOND, 0.3, 22, 18, 0, 2.4 },
          { CHART_SECOND, 25, 21, 17.2, 0, 2.4 }, { CHART_SIDE, 45, 20.5, 17.2, 0, 2.4 },
          { CHART_SIDE, 70, 21, 17.5, 0, 2.4 }, { CHART_SIDE, 95, 23, 19, 0, 2.4 },
          { CHART_SECOND, 112, 26, 21, 0, 2.4 }, { CHART_SECOND, 112.4, 5, 4, 0, 2.4 });

    battery.columns = 32;
    battery.corner = 6;
    battery.step = 12;
    battery.origin[0] = -38;
    battery.z[1] = -1, battery.z[2] = 0;
    battery.y[1] = 0, battery.y[2] = -1;
    battery.x[0] = -1;
    SOLID(b, &battery,
          { CHART_SECOND, 51, 4, 3, 0, 0 }, { CHART_SECOND, 51, 30, 19, 0, 0 }, { CHART_SECOND, 53, 36, 23, 0, 0 },
          { CHART_SECOND, 60, 37.5, 25, 0, 0 }, { CHART_SECOND, 86, 37.5, 25, 0, 0 },
          { CHART_SECOND, 92, 35, 23, 0, 0 },
          { CHART_SECOND, 93.4, 30, 19, 0, 0 }, { CHART_SECOND, 93.4, 4, 3, 0, 0 });
}

/* One half: blade up and to the side s, finger loop down and to the other. */
static void scissor_half(loft_builder *b, double s)
{
    const double z = 1.4 * s;
    const double tilt = s * 6 * M_PI / 180;
    const sweep_pipe arm = { CHART_SIDE, { 0, 0, 1 }, 16, 10, 2.6, false };
    const sweep_pipe ring = { CHART_SIDE, { 0, 0, 1 }, 20, 32, 2.3, true };
    solid_cut blade = upright;

    blade.columns = 16;
    blade.corner = 0.4;
    blade.step = 11;
    blade.origin[1] = -4;
    blade.origin[2] = z;
    blade.z[0] = sin(tilt), blade.z[1] = cos(tilt), blade.z[2] = 0;
    blade.x[0] = cos(tilt), blade.x[1] = -sin(tilt), blade.x[2] = 0;
    blade.y[1] = 0, blade.y[2] = -1;
    SOLID(b, &blade,
          { CHART_THIRD, -20, 1, 0.5, 0, 0 }, { CHART_THIRD, -20, 6, 1.25, 0, 0 }, { CHART_THIRD, 0, 9, 1.25, 0, 0 },
          { CHART_THIRD, 30, 8, 1.25, -s, 0 }, { CHART_THIRD, 70, 5, 1.2, -2.5 * s, 0 },
          { CHART_THIRD, 100, 1.8, 1, -4.5 * s, 0 }, { CHART_THIRD, 102, 0.8, 0.6, -4.7 * s, 0 });
    SWEEP(b, &arm, { -s, -12, z, 5, 3 }, { -4 * s, -26, z, 7, 5.5 }, { -9 * s, -38, 0, 6, 7 },
          { -14 * s, -47, 0, 4.5, 6.5 });
    SWEEP(b, &ring, { -25 * s, -42, 0, 4.2, 7.2 }, { -37 * s, -50, 0, 4.2, 7.8 },
          { -40 * s, -68, 0, 4.2, 7.8 }, { -33 * s, -88, 0, 4.2, 7.8 }, { -20 * s, -92, 0, 4.2, 7.8 },
          { -9 * s, -80, 0, 4.2, 7.8 }, { -7 * s, -62, 0, 4.2, 7.8 }, { -13 * s, -46, 0, 4.2, 7.2 });
}

static void scissors(loft_builder *b)
{
    solid_cut pivot = upright;

    scissor_half(b, 1);
    scissor_half(b, -1);
    pivot.columns = 20;
    pivot.step = 3;
    SOLID(b, &pivot,
          { CHART_SECOND, -4, 1, 1, 0, 0 }, { CHART_SECOND, -4, 3, 3, 0, 0 }, { CHART_SECOND, -3.4, 4, 4, 0, 0 },
          { CHART_SECOND, 3.4, 4, 4, 0, 0 }, { CHART_SECOND, 4, 3, 3, 0, 0 }, { CHART_SECOND, 4, 1, 1, 0, 0 });
}

/* Barrel ⌀16 with a cap over the last 35 %, a clip on it and a nib; along +y. */
static void marker(loft_builder *b)
{
    solid_cut c = upright;
    solid_cut clip = upright;

    c.columns = 40;
    c.step = 4;
    c.z[1] = 1, c.z[2] = 0;
    c.y[1] = 0, c.y[2] = -1;
    SOLID(b, &c,
          { CHART_SIDE, -60.4, 2, 2, 0, 0 }, { CHART_SIDE, -60.4, 7, 7, 0, 0 }, { CHART_SIDE, -59, 8.6, 8.6, 0, 0 },
          { CHART_SIDE, -55, 9, 9, 0, 0 }, { CHART_SIDE, 12, 9, 9, 0, 0 }, { CHART_SECOND, 13, 9.45, 9.45, 0, 0 },
          { CHART_SECOND, 18, 9.45, 9.45, 0, 0 }, { CHART_SECOND, 50, 8.7, 8.7, 0, 0 },
          { CHART_SECOND, 54, 7.4, 7.4, 0, 0 },
          { CHART_SECOND, 55.4, 4, 4, 0, 0 }, { CHART_SECOND, 60.2, 2.2, 2.2, 0, 0 },
          { CHART_SECOND, 60.4, 1, 1, 0, 0 });
    clip = c;
    clip.columns = 16;
    clip.step = 6;
    clip.origin[0] = 9.6;
    SOLID(b, &clip,
          { CHART_SECOND, 16, 0.4, 0.6, 0, 0 }, { CHART_SECOND, 16.2, 1.4, 2.2, 0, 0 },
          { CHART_SECOND, 44, 1.2, 2.2, 0, 0 },
          { CHART_SECOND, 45, 0.4, 0.6, 0, 0 });
}

typedef struct { double width, jaw, grip; } clamp_size;

/* One half of a spring clamp: jaw tip near the axis, out, in to the pivot, and out along the grip. */
static void clamp_half(loft_builder *b, const clamp_size *c, double s)
{
    const sweep_pipe arm = { CHART_SIDE, { 0, 0, 1 }, 24, 30, 3, false };
    const sweep_pipe pad = { CHART_SECOND, { 0, 0, 1 }, 20, 8, 4, false };
    const double w = c->width;

    SWEEP(b, &arm, { -0.10 * w * s, c->jaw, 0, 5, 10 }, { -0.21 * w * s, 0.86 * c->jaw, 0, 6.5, 12 },
          { -0.28 * w * s, 0.55 * c->jaw, 0, 8, 14 }, { -0.2 * w * s, 0.2 * c->jaw, 0, 8.5, 16 },
          { 0.03 * w * s, -2, 0, 8.5, 16 }, { 0.22 * w * s, -0.28 * c->grip, 0, 7.5, 13 },
          { 0.36 * w * s, -0.6 * c->grip, 0, 7, 12.5 }, { 0.46 * w * s, -0.97 * c->grip, 0, 5, 11 });
    SWEEP(b, &pad, { -0.12 * w * s, c->jaw - 6, 0, 5, 9 }, { -0.08 * w * s, c->jaw - 6, 0, 6, 10 },
          { -0.035 * w * s, c->jaw - 7, 0, 7, 11 }, { -0.012 * w * s, c->jaw - 8, 0, 7, 11 });
}

static void clamp(loft_builder *b, const clamp_size *c)
{
    solid_cut pivot = upright;

    clamp_half(b, c, 1);
    clamp_half(b, c, -1);
    pivot.columns = 28;
    pivot.step = 8;
    SOLID(b, &pivot,
          { CHART_THIRD, -18.5, 3, 3, 0, 0 }, { CHART_THIRD, -18.5, 9, 9, 0, 0 }, { CHART_THIRD, -17.5, 11, 11, 0, 0 },
          { CHART_THIRD, 17.5, 11, 11, 0, 0 }, { CHART_THIRD, 18.5, 9, 9, 0, 0 }, { CHART_THIRD, 18.5, 3, 3, 0, 0 });
}

void synth_shape_build(loft_builder *b, int id)
{
    switch (id) {
    case 1: can(b, 51.1, 70, 2, 51.1); break;
    case 2: box(b, 31.5, 79.5, 106.2, 1, 3.5); break;
    case 3: box(b, 20.5, 45, 88, 1, 2.8); break;
    case 4: can(b, 33.9, 51, 2, 33.9); break;
    case 5: mustard(b); break;
    case 6: can(b, 42.8, 16.7, 2, 42.8); break;
    case 7: box(b, 55, 43.3, 18.2, 1, 1.2); break;
    case 8: box(b, 34.5, 41.5, 14.5, 1, 1); break;
    case 9: can(b, 50.5, 41.8, 3.3, 28.5); break;
    case 10: banana(b); break;
    case 11: pitcher(b); break;
    case 12: bleach(b); break;
    case 13: bowl(b); break;
    case 14: mug(b); break;
    case 15: drill(b); break;
    case 16: box(b, 43.5, 43, 102, 3, 1); break;
    case 17: scissors(b); break;
    case 18: marker(b); break;
    case 19: clamp(b, &(clamp_size){ 118, 80, 80 }); break;
    case 20: clamp(b, &(clamp_size){ 207, 80, 80 }); break;
    case 21: box(b, 25.8, 38.6, 25.4, 3, 0); break;
    case SYNTH_JUG: jug(b); break;
    default: assert(!"an object's id");
    }
}
