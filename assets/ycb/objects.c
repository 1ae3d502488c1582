/* SPDX-License-Identifier: Apache-2.0 */
#include "assets/ycb/objects.h"

#include "assets/ycb/shapes.h"

#include <math.h>

enum { MAX_VERTICES = 3000 };

#define SLACK 1.5e-3

static const ycb_object jug = {
    .id = SYNTH_JUG, .name = "jug", .size = { 0.152, 0.104, 0.190 }, .centre = { 0.024, 0, 0 }, .diameter = 0.212,
    .diagonal = 0.265, .symmetry = YCB_SYM_NONE, .rect = { 0.152, 0.104 },
};

const ycb_object *synth_object_find(int id)
{
    return id == SYNTH_JUG ? &jug : ycb_find(id);
}

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
    const ycb_object *o = synth_object_find(id);
    loft_builder b;
    lt_status st;

    if (!o)
        return lt_error(LT_EINVAL, "object %d: ids are 1 to %d", id, SYNTH_OBJECTS);
    st = loft_builder_init(&b, arena, MAX_VERTICES);
    if (st)
        return st;
    synth_shape_build(&b, id);
    if (!b.ok)
        return lt_error(LT_EINVAL, "object %s: more than %d vertices", o->name, MAX_VERTICES);
    *placement = place(&b.mesh, o);
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
