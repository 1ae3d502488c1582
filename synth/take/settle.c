/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/take/settle.h"

#include "libtensor/geometry/mat3.h"

#include <math.h>

enum { DRAWS = 300 };

static const double NEAREST = 0.15, FARTHEST = 0.45, FRONT = -0.30;     /* metres */

typedef struct { double lo[3], hi[3], radius; } extent;

/* Of the model; the radius is that of the upright cylinder around its middle. */
static extent extent_of(const lt_mesh *m)
{
    extent e = { { INFINITY, INFINITY, INFINITY }, { -INFINITY, -INFINITY, -INFINITY }, 0 };

    for (int i = 0; i < m->n_vertices; i++)
        for (int k = 0; k < 3; k++) {
            e.lo[k] = fmin(e.lo[k], m->vertex[i][k]);
            e.hi[k] = fmax(e.hi[k], m->vertex[i][k]);
        }
    e.radius = hypot(e.hi[0] - e.lo[0], e.hi[1] - e.lo[1]) / 2;
    return e;
}

/* Turned by `turn` about its middle, which comes to stand over x, y. */
static void put(const extent *e, double x, double y, double turn, synth_settled *out)
{
    const double c = cos(turn), s = sin(turn), mx = (e->lo[0] + e->hi[0]) / 2, my = (e->lo[1] + e->hi[1]) / 2;

    *out = (synth_settled){ .R = { c, -s, 0, s, c, 0, 0, 0, 1 },
                            .t = { x - (c * mx - s * my), y - (s * mx + c * my), -e->lo[2] } };
}

bool synth_settle(const lt_mesh *mesh, const synth_ball *ball, int n, lt_rng *rng, synth_settled *out)
{
    const extent e = extent_of(mesh);

    for (int i = 0; i < DRAWS; i++) {
        const double away = sqrt(lt_rng_range(rng, NEAREST * NEAREST, FARTHEST * FARTHEST));
        const double around = lt_rng_range(rng, -M_PI, M_PI), turn = lt_rng_range(rng, -M_PI, M_PI);
        const double x = away * cos(around), y = away * sin(around);
        if (y - e.radius < FRONT || synth_in_way(x, y, e.radius, e.hi[2] - e.lo[2], ball, n))
            continue;
        put(&e, x, y, turn, out);
        return true;
    }
    put(&e, 0, FARTHEST, 0, out);
    return false;
}

synth_ball synth_settled_ball(const lt_mesh *mesh, const synth_settled *at)
{
    const extent e = extent_of(mesh);
    const double middle[3] = { (e.lo[0] + e.hi[0]) / 2, (e.lo[1] + e.hi[1]) / 2, (e.lo[2] + e.hi[2]) / 2 };
    synth_ball b = { .radius = hypot(e.radius, (e.hi[2] - e.lo[2]) / 2) };

    lt_rigid_apply(at->R, at->t, middle, b.centre);
    return b;
}
