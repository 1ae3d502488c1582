/* SPDX-License-Identifier: Apache-2.0 */
/* What is where: no two things share a place. */
#include "synth/detect/internal.h"

#include "libtensor/geometry/mat3.h"

#include <math.h>
#include <string.h>

enum { ROD_BALLS = 6 };

void layout_add_ball(layout *l, const double centre[3], double radius)
{
    if (l->n_balls == LAYOUT_BALLS)
        return;
    l->ball[l->n_balls] = (synth_ball){ .radius = radius };
    memcpy(l->ball[l->n_balls++].centre, centre, 3 * sizeof(*centre));
}

void layout_add_rod(layout *l, const double a[3], const double b[3], double radius)
{
    for (int i = 0; i < ROD_BALLS; i++) {
        double c[3];
        for (int k = 0; k < 3; k++)
            c[k] = a[k] + (i + 1) * (b[k] - a[k]) / ROD_BALLS;
        layout_add_ball(l, c, radius);
    }
}

static bool is_free(const layout *l, const synth_ball *b)
{
    for (int i = 0; i < l->n_balls; i++)
        if (lt_vec3_distance(b->centre, l->ball[i].centre) < b->radius + l->ball[i].radius)
            return false;
    return true;
}

static void widen(synth_ball *b, double lo[3], double hi[3])
{
    for (int k = 0; k < 3; k++)
        b->centre[k] = (lo[k] + hi[k]) / 2;
    b->radius = lt_vec3_distance(lo, hi) / 2;
}

static void take_in(const double R[9], const double t[3], const double x[3], double lo[3], double hi[3])
{
    double p[3];

    lt_rigid_apply(R, t, x, p);
    for (int k = 0; k < 3; k++) {
        lo[k] = fmin(lo[k], p[k]);
        hi[k] = fmax(hi[k], p[k]);
    }
}

synth_ball layout_ball(const layout *l, const synth_grip *g, const synth_prop *prop, const double R[9],
                       const double t[3], double *lowest)
{
    double lo[3] = { INFINITY, INFINITY, INFINITY }, hi[3] = { -INFINITY, -INFINITY, -INFINITY };
    const double *table = l->out->room.table;
    synth_ball b;

    for (int i = 0; g && i < LT_HAND_VERTICES; i++)
        take_in(R, t, g->vertices[i], lo, hi);
    for (int i = 0; prop && i < prop->mesh.n_vertices; i++) {
        const float *v = prop->mesh.vertex[i];
        take_in(R, t, (const double[]){ v[0], v[1], v[2] }, lo, hi);
    }
    widen(&b, lo, hi);
    *lowest = lo[2];
    if (hi[0] < table[0] || lo[0] > table[2] || hi[1] < table[1] || lo[1] > table[3])
        *lowest -= LAYOUT_FLOOR;
    return b;
}

void layout_unproject(const synth_camera *c, double u, double v, double z, double out[3])
{
    const double p[3] = { (u - c->cx) / c->fx * z - c->t_cam_world[0], (v - c->cy) / c->fy * z - c->t_cam_world[1],
                          z - c->t_cam_world[2] };
    double back[9];

    lt_mat3_transpose(c->R_cam_world, back);
    lt_mat3_mulvec(back, p, out);
}

void layout_project(const synth_camera *c, const double p[3], double x[3])
{
    lt_rigid_apply(c->R_cam_world, c->t_cam_world, p, x);
    x[0] = c->fx * x[0] / x[2] + c->cx;
    x[1] = c->fy * x[1] / x[2] + c->cy;
}

layout_where_is layout_where(const layout *l, const synth_ball *b)
{
    const synth_camera *c = &l->out->camera;
    double x[3], r, in, gone;

    layout_project(c, b->centre, x);
    if (x[2] < 0.02)
        return LAYOUT_OUTSIDE;
    r = 0.75 * c->fx * b->radius / x[2];        /* balls are larger than what is in them */
    in = fmin(fmin(x[0], x[1]), fmin(DETECT_SIDE - 1 - x[0], DETECT_SIDE - 1 - x[1]));
    gone = fmax(fmax(-x[0], -x[1]), fmax(x[0], x[1]) - DETECT_SIDE);
    return in > r ? LAYOUT_INSIDE : gone > r ? LAYOUT_OUTSIDE : LAYOUT_ACROSS;
}

static bool in_room(const double p[3])
{
    return fabs(p[0]) < 1.25 && p[1] > -1.3 && p[1] < 1.25 && p[2] > LAYOUT_FLOOR + 0.05 && p[2] < 1.5;
}

bool layout_fits(layout *l, const synth_ball *b, double lowest)
{
    return lowest >= 0.004 && in_room(b->centre) && is_free(l, b) &&
           (layout_where(l, b) != LAYOUT_ACROSS || lt_rng_uniform(&l->r) < (l->near ? LAYOUT_CUT_NEAR : LAYOUT_CUT));
}

void layout_note(layout *l, const detect_put *what, const double R[9], const double t[3])
{
    detect_put *p = &l->out->put[l->out->n_put];

    if (l->out->n_put == SYNTH_THINGS)
        return;
    l->out->n_put++;
    *p = *what;
    memcpy(p->R, R, sizeof(p->R));
    memcpy(p->t, t, sizeof(p->t));
}
