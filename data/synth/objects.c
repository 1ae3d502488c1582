/* SPDX-License-Identifier: Apache-2.0 */
#include "data/synth/objects.h"

#include "data/synth/shapes.h"
#include "data/ycb.h"

#include <math.h>

enum { MAX_VERTICES = 3000 };

#define SLACK 1.5e-3

/* Angle of a shape's own x axis in the model frame. Where the table's rectangle says nothing about a
 * handle, the angle is the one whose bounding box comes closest to the table's. */
static double shape_yaw(const ycb_object *o)
{
    switch (o->id) {
    case 11: return -2.4;           /* the handle lies between -x and -y, where the box is off centre */
    case 14: return 0.30;
    default: return o->yaw;
    }
}

static void bounds(const lt_mesh *m, double lo[3], double hi[3])
{
    for (int k = 0; k < 3; k++) {
        lo[k] = INFINITY;
        hi[k] = -INFINITY;
    }
    for (int i = 0; i < m->n_vertices; i++)
        for (int k = 0; k < 3; k++) {
            lo[k] = fmin(lo[k], m->vertex[i][k]);
            hi[k] = fmax(hi[k], m->vertex[i][k]);
        }
}

static void turn(lt_mesh *m, double yaw)
{
    const double c = cos(yaw), s = sin(yaw);

    for (int i = 0; i < m->n_vertices; i++) {
        float *p = m->vertex[i];
        const double x = p[0], y = p[1];
        p[0] = (float)(c * x - s * y);
        p[1] = (float)(s * x + c * y);
    }
}

/* To metres, around the real centre, stretched by the percent or two that bring every side of the box to
 * within SLACK of the real one. */
static void fit(lt_mesh *m, const ycb_object *o)
{
    double lo[3], hi[3];

    bounds(m, lo, hi);
    for (int k = 0; k < 3; k++) {
        const double own = 1e-3 * (hi[k] - lo[k]);
        const double size = fmax(o->size[k] - SLACK, fmin(o->size[k] + SLACK, own));
        for (int i = 0; i < m->n_vertices; i++)
            m->vertex[i][k] = (float)(o->centre[k] + size * ((m->vertex[i][k] - lo[k]) / (hi[k] - lo[k]) - 0.5));
    }
}

lt_status synth_object_new(lt_arena *arena, int ycb_id, lt_mesh *mesh)
{
    const ycb_object *o = ycb_find(ycb_id);
    loft_builder b;
    lt_status st;

    if (!o)
        return lt_error(LT_EINVAL, "object %d: YCB ids are 1 to %d", ycb_id, YCB_COUNT);
    st = loft_builder_init(&b, arena, MAX_VERTICES);
    if (st)
        return st;
    synth_shape_build(&b, ycb_id);
    if (!b.ok)
        return lt_error(LT_EINVAL, "object %s: more than %d vertices", o->name, MAX_VERTICES);
    turn(&b.mesh, shape_yaw(o));
    fit(&b.mesh, o);
    *mesh = b.mesh;
    return LT_OK;
}
