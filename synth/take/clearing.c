/* SPDX-License-Identifier: Apache-2.0 */
/* A thing on the table counts as the upright cylinder around each of its parts. */
#include "synth/take/clearing.h"

#include "libtensor/geometry/mat3.h"

typedef struct { double x, y, radius, top; bool gone; } pillar;

static pillar pillar_around(const synth_instance *in)
{
    double lo[2] = { INFINITY, INFINITY }, hi[2] = { -INFINITY, -INFINITY }, top = -INFINITY;

    for (int i = 0; i < in->mesh->n_vertices; i++) {
        const float *v = in->mesh->vertex[i];
        const double x[3] = { v[0], v[1], v[2] };
        double p[3];
        lt_rigid_apply(in->R_world_obj, in->t_world_obj, x, p);
        for (int k = 0; k < 2; k++) {
            lo[k] = fmin(lo[k], p[k]);
            hi[k] = fmax(hi[k], p[k]);
        }
        top = fmax(top, p[2]);
    }
    return (pillar){ (lo[0] + hi[0]) / 2, (lo[1] + hi[1]) / 2, hypot(hi[0] - lo[0], hi[1] - lo[1]) / 2, top,
                     false };
}

bool synth_in_way(double x, double y, double radius, double top, const synth_ball *ball, int n)
{
    for (int i = 0; i < n; i++) {
        const synth_ball *b = &ball[i];
        if (b->centre[2] - b->radius < top && hypot(b->centre[0] - x, b->centre[1] - y) < radius + b->radius)
            return true;
    }
    return false;
}

/* Parts of one thing stand on or in each other; things stand apart. */
static bool one_thing(const pillar *a, const pillar *b)
{
    return hypot(a->x - b->x, a->y - b->y) < fmax(a->radius, b->radius);
}

/* With a part that is gone goes the rest of its thing. */
static void spread(pillar *p, const bool *movable, int n)
{
    for (bool again = true; again;) {
        again = false;
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n && movable[i] && !p[i].gone; j++)
                if (p[j].gone && one_thing(&p[i], &p[j]))
                    again = p[i].gone = true;
    }
}

void synth_clear_way(synth_room *room, const synth_ball *ball, int n)
{
    pillar p[SYNTH_ROOM_INSTANCES];
    bool movable[SYNTH_ROOM_INSTANCES];
    int kept = 0;

    for (int i = 0; i < room->n_instances; i++) {
        p[i] = pillar_around(&room->instance[i]);
        movable[i] = !room->instance[i].no_shadow;
        p[i].gone = movable[i] && synth_in_way(p[i].x, p[i].y, p[i].radius, p[i].top, ball, n);
    }
    spread(p, movable, room->n_instances);
    for (int i = 0; i < room->n_instances; i++)
        if (!p[i].gone)
            room->instance[kept++] = room->instance[i];
    room->n_instances = kept;
}
