/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/detect/internal.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>

static const double ON_TABLE = 0.5;             /* share of free objects that stand there; the rest are in the air */

static void draw_rotation(lt_rng *r, double R[9])
{
    double q[4];

    for (int k = 0; k < 4; k++)
        q[k] = lt_rng_normal(r);
    if (!lt_quat_unit(q))
        q[3] = 1;
    lt_rot_from_quat(q, R);
}

static void place_object(layout *l, const synth_prop *p, const double R[9], const double t[3])
{
    const int thing = l->out->world.n_things;

    synth_object_place(p, R, t, 0, &l->out->world);
    if (l->out->world.n_things > thing)
        layout_note(l, &(detect_put){ .thing = thing, .prop = p }, R, t);
}

static bool stand(layout *l, const synth_prop *p)
{
    synth_settled at;
    synth_ball b;

    for (int i = 0; i < LAYOUT_DRAWS; i++) {
        if (!synth_settle(&p->mesh, l->ball, l->n_balls, &l->r, &at))
            return false;
        b = synth_settled_ball(&p->mesh, &at);
        if (layout_where(l, &b) != LAYOUT_INSIDE && lt_rng_uniform(&l->r) >= LAYOUT_CUT)
            continue;
        layout_add_ball(l, b.centre, b.radius);
        place_object(l, p, at.R, at.t);
        return true;
    }
    return false;
}

/* Where an object hangs in the air: anywhere in the picture, or before something that is there. */
static void draw_spot(layout *l, double out[3])
{
    const synth_camera *c = &l->out->camera;
    double u = lt_rng_range(&l->r, -8, DETECT_SIDE + 8), v = lt_rng_range(&l->r, -8, DETECT_SIDE + 8);
    double z = exp(lt_rng_range(&l->r, log(0.17), log(2.6))), x[3];
    const double share = lt_rng_range(&l->r, 0.5, 0.85);
    const double du = lt_rng_normal(&l->r), dv = lt_rng_normal(&l->r);
    const uint32_t which = lt_rng_below(&l->r, (uint32_t)(2 * l->out->n_put + 1));

    if ((int)which < l->out->n_put) {
        layout_project(c, l->out->put[which].t, x);
        if (x[2] > 0.3) {
            u = x[0] + 0.05 * c->fx / x[2] * du;
            v = x[1] + 0.05 * c->fx / x[2] * dv;
            z = share * x[2];
        }
    }
    layout_unproject(c, u, v, z, out);
}

static void hang(layout *l, const synth_prop *p)
{
    for (int i = 0; i < LAYOUT_DRAWS; i++) {
        double R[9], spot[3], middle[3], t[3], lowest;
        synth_ball b;

        draw_rotation(&l->r, R);
        draw_spot(l, spot);
        for (int k = 0; k < 3; k++)
            middle[k] = (p->box.lo[k] + p->box.hi[k]) / 2;
        lt_mat3_mulvec(R, middle, t);
        lt_vec3_sub(spot, t, t);
        b = layout_ball(l, NULL, p, R, t, &lowest);
        b.radius *= 0.8;
        if (!layout_fits(l, &b, lowest))
            continue;
        layout_add_ball(l, b.centre, b.radius);
        place_object(l, p, R, t);
        return;
    }
}

void layout_add_objects(layout *l)
{
    const int n = 1 + (int)lt_rng_below(&l->r, 5);

    for (int i = 0; i < n; i++) {
        const synth_prop *p = &l->place->prop[lt_rng_below(&l->r, YCB_COUNT)].right;
        const bool on_table = lt_rng_uniform(&l->r) < ON_TABLE;

        if (!on_table || !stand(l, p))
            hang(l, p);
    }
}
