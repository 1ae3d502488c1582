/* SPDX-License-Identifier: Apache-2.0 */
#include "data/synth/objects.h"

#include "data/synth/shapes.h"

#include <math.h>

enum { MAX_VERTICES = 3000, MUG = 14 };

#define SLACK 1.5e-3
#define JUG_SCALE 1.8

/* Angle of a shape's own x axis in the model frame. Where the table's rectangle says nothing about a
 * handle, the angle is the one whose bounding box comes closest to the table's. */
static double shape_yaw(const ycb_object *o)
{
    switch (o->id) {
    case 11: return -2.4;           /* the handle lies between -x and -y, where the box is off centre */
    case MUG: return 0.30;
    default: return o->yaw;
    }
}

lt_status synth_stand_in(int id, ycb_object *out)
{
    const bool jug = id == SYNTH_JUG;
    const ycb_object *o = ycb_find(jug ? MUG : id);

    if (!o)
        return lt_error(LT_EINVAL, "object %d: stand-ins are 1 to %d", id, SYNTH_STAND_INS);
    *out = *o;
    if (!jug)
        return LT_OK;
    out->name = "jug";
    out->diameter *= JUG_SCALE;
    for (int k = 0; k < 3; k++) {
        out->size[k] *= JUG_SCALE;
        out->centre[k] *= JUG_SCALE;
    }
    return LT_OK;
}

/* Around the real centre, stretched by the percent or two that bring every side of the box to within SLACK
 * of the real one. */
static synth_placement place(const lt_mesh *m, const ycb_object *o)
{
    synth_placement p = { .cos_yaw = cos(shape_yaw(o)), .sin_yaw = sin(shape_yaw(o)) };
    double lo[3], hi[3];

    for (int k = 0; k < 3; k++)
        p.scale[k] = 1;
    for (int i = 0; i < m->n_vertices; i++) {
        double at[3] = { m->vertex[i][0], m->vertex[i][1], m->vertex[i][2] };
        synth_place_point(&p, at, at);
        for (int k = 0; k < 3; k++) {
            lo[k] = i ? fmin(lo[k], at[k]) : at[k];
            hi[k] = i ? fmax(hi[k], at[k]) : at[k];
        }
    }
    for (int k = 0; k < 3; k++) {
        const double own = 1e-3 * (hi[k] - lo[k]);
        const double size = fmax(o->size[k] - SLACK, fmin(o->size[k] + SLACK, own));
        p.scale[k] = size / (hi[k] - lo[k]);
        p.offset[k] = o->centre[k] - p.scale[k] * (hi[k] + lo[k]) / 2;
    }
    return p;
}

void synth_place_point(const synth_placement *p, const double local[3], double out[3])
{
    const double x = local[0], y = local[1];

    out[0] = p->scale[0] * (p->cos_yaw * x - p->sin_yaw * y) + p->offset[0];
    out[1] = p->scale[1] * (p->sin_yaw * x + p->cos_yaw * y) + p->offset[1];
    out[2] = p->scale[2] * local[2] + p->offset[2];
}

lt_status synth_object_build(lt_arena *arena, int id, lt_mesh *mesh, synth_placement *placement)
{
    loft_builder b;
    ycb_object o;
    lt_status st = synth_stand_in(id, &o);

    if (!st)
        st = loft_builder_init(&b, arena, MAX_VERTICES);
    if (st)
        return st;
    synth_shape_build(&b, o.id);
    if (!b.ok)
        return lt_error(LT_EINVAL, "object %s: more than %d vertices", o.name, MAX_VERTICES);
    *placement = place(&b.mesh, &o);
    for (int i = 0; i < b.mesh.n_vertices; i++) {
        float *v = b.mesh.vertex[i];
        double at[3] = { v[0], v[1], v[2] };
        synth_place_point(placement, at, at);
        for (int k = 0; k < 3; k++)
            v[k] = (float)at[k];
    }
    *mesh = b.mesh;
    return LT_OK;
}

lt_status synth_object_new(lt_arena *arena, int id, lt_mesh *mesh)
{
    synth_placement placement;

    return synth_object_build(arena, id, mesh, &placement);
}
