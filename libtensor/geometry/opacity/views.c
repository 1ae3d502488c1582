/* SPDX-License-Identifier: Apache-2.0 */
/* What a view may meet in each of its tiles: the Gaussians whose outline reaches into it. */
#include "libtensor/geometry/opacity/internal.h"

#include "libtensor/geometry/mat3.h"

/* Half of the image is as wide as this at depth 1: half of 55 degrees. What is beyond goes to the tiles at the edge. */
static const double TAN_HALF = 0.52056705055174624;

/* Squared deviations at which opacity 1 is 1/255, and a little more, which is rounding's */
static double squared_reach(double opacity)
{
    return 2.002 * log(255 * opacity) + 1e-3;
}

static int tile_along(double at)
{
    const double cell = floor((at / TAN_HALF + 1) * (OPACITY_SIDE / 2));

    return (int)fmin(fmax(cell, 0), OPACITY_SIDE - 1);
}

static void to_view(const opacity_view *v, const double x[3], double out[3])
{
    double d[3];

    lt_vec3_sub(x, v->eye, d);
    lt_mat3_mulvec(v->axes, d, out);
}

int opacity_tile(const opacity_view *v, const double x[3])
{
    double p[3];

    to_view(v, x, p);
    return tile_along(p[1] / p[2]) * OPACITY_SIDE + tile_along(p[0] / p[2]);
}

/* Tiles [from, to] along one axis */
typedef struct { int from, to; } span;

/* Where planes through the eye touch the ellipsoid: (p - u pz)^2 = c (S - 2 u Sz + u^2 Szz) */
static span span_of(double p, double pz, double c, double S, double Sz, double Szz)
{
    const double a = pz * pz - c * Szz, b = p * pz - c * Sz, root = sqrt(fmax(0, b * b - a * (p * p - c * S)));

    if (!(a > 0) || pz <= 0)                    /* the eye is in it, or beside it */
        return (span){ 0, OPACITY_SIDE - 1 };
    return (span){ tile_along((b - root) / a), tile_along((b + root) / a) };
}

typedef struct { span x, y; } outline;

static outline outline_of(const opacity_view *v, const double centre[3], double opacity, const double covariance[9])
{
    const double c = squared_reach(opacity);
    double p[3], turned[9], across[9], S[9];

    to_view(v, centre, p);
    lt_mat3_transpose(v->axes, across);
    lt_mat3_mul(v->axes, covariance, turned);
    lt_mat3_mul(turned, across, S);
    return (outline){ span_of(p[0], p[2], c, S[0], S[2], S[8]), span_of(p[1], p[2], c, S[4], S[5], S[8]) };
}

/* Count first, then deal. Who is never seen is in no tile. */
static void deal(opacity_view *v, int64_t n, const outline *o, int64_t *next, bool count)
{
    for (int64_t i = 0; i < n; i++)
        for (int y = o[i].y.from; y <= o[i].y.to; y++)
            for (int x = o[i].x.from; x <= o[i].x.to; x++) {
                int64_t *to = &next[y * OPACITY_SIDE + x];

                if (!count)
                    v->number[*to] = (uint32_t)i;
                ++*to;
            }
}

lt_status opacity_look(lt_opacity_field *f, int k, const lt_gaussian *g, const double (*covariance)[9],
                       lt_arena *arena)
{
    opacity_view *v = &f->view[k];
    outline *o = lt_alloc((size_t)f->n * sizeof(*o));
    int64_t next[OPACITY_TILES] = { 0 };

    v->met = lt_arena_array(arena, (size_t)f->n, sizeof(*v->met));
    if (!o || !v->met) {
        lt_release(o);
        return lt_error(LT_ENOMEM, "no memory for the views of %lld Gaussians", (long long)f->n);
    }
    for (int64_t i = 0; i < f->n; i++) {
        double centre[3];

        lt_vec3_sub(g[i].centre, f->middle, centre);
        o[i] = 255 * g[i].opacity > 1 ? outline_of(v, centre, g[i].opacity, covariance[i])
                                      : (outline){ { 0, -1 }, { 0, -1 } };
        for (int a = 0; a < 3; a++) {
            const lt_real *row = f->gaussian[i].white + 3 * a;
            double sum = 0;

            for (int b = 0; b < 3; b++)
                sum += (double)row[b] * (v->eye[b] - (double)f->gaussian[i].centre[b]);
            v->met[i][a] = (lt_real)sum;
        }
    }
    deal(v, f->n, o, next, true);
    for (int t = 0; t < OPACITY_TILES; t++) {
        v->first[t + 1] = v->first[t] + next[t];
        next[t] = v->first[t];
    }
    v->number = lt_arena_array(arena, (size_t)v->first[OPACITY_TILES], sizeof(*v->number));
    if (v->number)
        deal(v, f->n, o, next, false);
    lt_release(o);
    return v->number ? LT_OK : lt_error(LT_ENOMEM, "no memory for the views of %lld Gaussians", (long long)f->n);
}
