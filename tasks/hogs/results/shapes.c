/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/results/shapes.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/geometry/svd3.h"
#include "libtensor/io/mesh/splat.h"

#include <math.h>
#include <string.h>

static const double LEAST_ALPHA = 1.0 / 255;

/* ---- what was drawn -------------------------------------------------------------------------------------------- */

/* Rows of both sets, N of each, hand first */
typedef struct {
    const lt_real *centre, *axes, *alpha, *colour;
    int64_t rows;
} drawn;

static drawn drawn_of(const compiled *c)
{
    return (drawn){
        .centre = compiled_output(c, "centre"), .axes = compiled_output(c, "axes"),
        .alpha = compiled_output(c, "alpha"), .colour = compiled_output(c, "colour"),
        .rows = lt_numel(model_port_find(&c->record.outputs, "alpha")),
    };
}

/* In use, and to be seen */
static bool is_seen(const drawn *d, int64_t i)
{
    return (double)d->alpha[i] >= LEAST_ALPHA;
}

/* M = U S V^T: the rotation U, with determinant 1, and the scales S have the same covariance. */
static void factor(const lt_real *axes, lt_splat *out)
{
    double M[9], U[9], S[3], V[9], q[4];

    for (int k = 0; k < 9; k++)
        M[k] = (double)axes[k];
    lt_svd3(M, U, S, V);
    if (lt_mat3_det(U) < 0)
        for (int r = 0; r < 3; r++)
            U[3 * r + 2] = -U[3 * r + 2];
    lt_rot_to_quat(U, q);
    for (int k = 0; k < 4; k++)
        out->rotation[k] = (float)q[k];
    for (int k = 0; k < 3; k++)
        out->scale[k] = (float)log(fmax(S[k], 1e-9));
}

lt_status hogs_posed_splats(lt_arena *arena, const compiled *c, lt_splat **out, size_t n[2])
{
    const drawn d = drawn_of(c);
    lt_splat *all = lt_arena_array(arena, (size_t)d.rows, sizeof(*all));
    size_t seen = 0;

    if (!all)
        return lt_error(LT_ENOMEM, "no memory for %lld Gaussians", (long long)d.rows);
    n[0] = n[1] = 0;
    for (int64_t i = 0; i < d.rows; i++) {
        const double a = fmin((double)d.alpha[i], 1 - 1e-6);
        lt_splat *s = &all[seen];
        double rgb[3];

        if (!is_seen(&d, i))
            continue;
        *s = (lt_splat){ .opacity = (float)log(a / (1 - a)) };
        for (int k = 0; k < 3; k++) {
            s->x[k] = (float)d.centre[3 * i + k];
            rgb[k] = (double)d.colour[3 * i + k];
        }
        lt_splat_paint(s, rgb);
        factor(d.axes + 9 * i, s);
        seen++;
        n[i >= d.rows / 2]++;
    }
    *out = all;
    return LT_OK;
}

/* ---- sets ------------------------------------------------------------------------------------------------------ */

const char *hogs_set_name(lt_arena *arena, const hogs *m, int set)
{
    const bool object = set >= m->config.hands;
    const int id = (int)lround((double)m->id[object]->data[object ? set - m->config.hands : set]);

    return lt_arena_printf(arena, "%s-%02d", object ? "object" : "hand", id);
}

/* ---- surfaces -------------------------------------------------------------------------------------------------- */

lt_status hogs_posed_mesh(lt_arena *arena, const compiled *c, bool object, lt_opacity_rule rule, double iso,
                          lt_mesh *out)
{
    const drawn d = drawn_of(c);
    const int64_t N = d.rows / 2, first = object ? N : 0;
    lt_gaussian *g = lt_alloc((size_t)N * sizeof(*g));
    float (*color)[3] = lt_alloc((size_t)N * sizeof(*color));
    int64_t n = 0;
    lt_status st = g && color ? LT_OK : lt_error(LT_ENOMEM, "no memory for a surface of %lld Gaussians", (long long)N);

    for (int64_t i = first; i < first + N && !st; i++) {
        if (!is_seen(&d, i))
            continue;
        for (int k = 0; k < 3; k++) {
            g[n].centre[k] = (double)d.centre[3 * i + k];
            color[n][k] = rintf(255 * fminf(1, fmaxf(0, (float)d.colour[3 * i + k]))) / 255;
        }
        for (int k = 0; k < 9; k++)
            g[n].axes[k] = (double)d.axes[9 * i + k];
        g[n++].opacity = fmin(1, (double)d.alpha[i]);
    }
    if (!st)
        st = lt_opacity_mesh(arena, n, g, (const float (*)[3])color, rule, iso, out);
    lt_release(color);
    lt_release(g);
    return st;
}

void hogs_linear_colours(lt_mesh *m)
{
    for (int i = 0; i < 3 * m->n_vertices; i++) {
        float *x = &m->color[i / 3][i % 3];

        *x = *x <= 0.04045f ? *x / 12.92f : powf((*x + 0.055f) / 1.055f, 2.4f);
    }
}
