/* SPDX-License-Identifier: Apache-2.0 */
#include "estimate/posed/turntable.h"

#include "libtensor/geometry/rotation.h"
#include "libtensor/graph/plan.h"
#include "libtensor/io/mesh/splat.h"
#include "libtensor/ops/ops.h"

#include <math.h>

typedef struct {
    lt_graph *g;
    lt_plan *plan;
    lt_tensor *centre, *axes, *opacity, *colour, *camera, *image;
    int64_t n;
    double middle[3];
} table;

static lt_tensor *input(table *t, const char *name, lt_shape shape)
{
    return lt_input(t->g, name, LT_F32, shape.rank, shape.dim);
}

static lt_status record(table *t, const posed_frame *f)
{
    lt_splat_in in;

    t->n = (int64_t)(f->n[POSED_HAND] + f->n[POSED_OBJECT]);
    t->g = lt_graph_new();
    if (!t->g)
        return lt_error(LT_ENOMEM, "no memory for a turntable");
    in = (lt_splat_in){
        .centre = t->centre = input(t, "centre", LT_SHAPE(t->n, 3)),
        .axes = t->axes = input(t, "axes", LT_SHAPE(t->n, 3, 3)),
        .opacity = t->opacity = input(t, "opacity", LT_SHAPE(t->n)),
        .colour = t->colour = input(t, "colour", LT_SHAPE(t->n, 3)),
        .camera = t->camera = input(t, "camera", LT_SHAPE(4)),
    };
    t->image = lt_output(lt_splat_raster(&in, &(lt_splat_opts){ .width = f->width, .height = f->height,
                                                                .near_z = f->near, .white = f->white }), "image");
    t->plan = lt_compile(t->g, &(lt_compile_opts){ 0 });
    return t->plan ? LT_OK : lt_graph_status(t->g) ? lt_graph_status(t->g) : LT_ENOMEM;
}

/* What does not turn */
static void feed(table *t, const posed_frame *f)
{
    lt_real *opacity = lt_plan_data(t->plan, t->opacity), *colour = lt_plan_data(t->plan, t->colour);
    lt_real *camera = lt_plan_data(t->plan, t->camera);

    camera[0] = (lt_real)f->camera.fx, camera[1] = (lt_real)f->camera.fy;
    camera[2] = (lt_real)f->camera.cx, camera[3] = (lt_real)f->camera.cy;
    for (int64_t i = 0; i < t->n; i++) {
        double rgb[3];

        opacity[i] = (lt_real)(1 / (1 + exp(-(double)f->splat[i].opacity)));
        lt_splat_rgb(&f->splat[i], rgb);
        for (int k = 0; k < 3; k++) {
            colour[3 * i + k] = (lt_real)rgb[k];
            t->middle[k] += (double)f->splat[i].x[k] / (double)t->n;
        }
    }
}

/* x = T (x - middle) + middle, and the axes T R diag(scale) */
static void turn(table *t, const posed_frame *f, double angle)
{
    const double T[9] = { cos(angle), 0, sin(angle), 0, 1, 0, -sin(angle), 0, cos(angle) };
    lt_real *centre = lt_plan_data(t->plan, t->centre), *axes = lt_plan_data(t->plan, t->axes);

    for (int64_t i = 0; i < t->n; i++) {
        const lt_splat *s = &f->splat[i];
        const double q[4] = { (double)s->rotation[0], (double)s->rotation[1], (double)s->rotation[2],
                              (double)s->rotation[3] };
        double R[9];

        lt_rot_from_quat(q, R);
        for (int r = 0; r < 3; r++) {
            double x = t->middle[r];

            for (int k = 0; k < 3; k++)
                x += T[3 * r + k] * ((double)s->x[k] - t->middle[k]);
            centre[3 * i + r] = (lt_real)x;
            for (int c = 0; c < 3; c++)
                axes[9 * i + 3 * r + c] = (lt_real)(exp((double)s->scale[c]) *
                    (T[3 * r] * R[c] + T[3 * r + 1] * R[3 + c] + T[3 * r + 2] * R[6 + c]));
        }
    }
}

lt_status turntable_draw(const posed_frame *f, int views, lt_status (*visit)(void *ctx, const uint8_t *rgb), void *ctx)
{
    const int64_t pixels = (int64_t)f->width * f->height;
    uint8_t *rgb = lt_alloc(3 * (size_t)pixels);
    table t = { 0 };
    lt_status st = rgb ? record(&t, f) : lt_error(LT_ENOMEM, "no memory for a turntable");

    if (!st)
        feed(&t, f);
    for (int i = 0; i < views && !st; i++) {
        const lt_real *image = lt_plan_data(t.plan, t.image);

        turn(&t, f, 2 * acos(-1) * i / views);
        st = lt_run(t.plan);
        for (int64_t k = 0; k < 3 * pixels && !st; k++)
            rgb[k] = (uint8_t)lround(255 * fmin(1, fmax(0, (double)image[k % 3 * pixels + k / 3])));
        if (!st)
            st = visit(ctx, rgb);
    }
    lt_plan_free(t.plan);
    lt_graph_free(t.g);
    lt_release(rgb);
    return st;
}
