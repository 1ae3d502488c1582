/* SPDX-License-Identifier: Apache-2.0 */
/* What G-PM and the contact terms read of a frame. */
#include "tasks/hogs/feed.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <string.h>

#define DEGREES (M_PI / 180)

/* The crop's colour at a place of it, between pixels */
static void colour_at(const hogs *m, const float *image, const double uv[2], lt_real out[3])
{
    const int S = m->sizes.crop;
    const double x = fmin(fmax(uv[0] - 0.5, 0), S - 1), y = fmin(fmax(uv[1] - 0.5, 0), S - 1);
    const int x0 = (int)x, y0 = (int)y, x1 = x0 + 1 < S ? x0 + 1 : x0, y1 = y0 + 1 < S ? y0 + 1 : y0;
    const double a = x - x0, b = y - y0;

    for (int c = 0; c < 3; c++) {
        const float *p = image + (int64_t)c * S * S;

        out[c] = (lt_real)((1 - b) * ((1 - a) * (double)p[y0 * S + x0] + a * (double)p[y0 * S + x1])
                           + b * ((1 - a) * (double)p[y1 * S + x0] + a * (double)p[y1 * S + x1]));
    }
}

/* Which Gaussians G-PM looks at: all of them, or so many drawn */
static void draw_points(feed_job *j, int32_t *drawn, int64_t P, int64_t n)
{
    const bool training = j->by->stage != HOGS_RENDER, subset = training && j->m->config.subset && P <= n;
    uint32_t *order = subset ? lt_alloc((size_t)n * sizeof(*order)) : NULL;

    if (order)
        lt_rng_permute(&j->rng, order, (uint32_t)n);
    for (int64_t i = 0; i < P; i++)
        drawn[i] = order ? (int32_t)order[i] : training ? (int32_t)lt_rng_below(&j->rng, (uint32_t)n)
                   : (int32_t)(i < n ? i : 0);
    lt_release(order);
}

void feed_points(feed_job *j)
{
    const lt_tensor *t = model_port_find(&j->r->inputs, "points");
    const int64_t P = t ? lt_dim(t, 1) : 0, n = feed_count(&j->placer, true);
    int32_t *drawn = feed_integers(j, "drawn"), *count = feed_at(j, "count"), *start = feed_at(j, "start");
    lt_real *points = feed_at(j, "points"), *rgb = feed_at(j, "rgb");

    if (!points)
        return;
    draw_points(j, drawn, P, n);
    *count = (int32_t)(j->by->stage == HOGS_RENDER ? lt_min_i64(n, P) : P);
    *start = j->by->stage == HOGS_RENDER ? 0 : (int32_t)lt_rng_below(&j->rng, (uint32_t)P);
    for (int64_t i = 0; i < P; i++) {
        double x[3], uv[2] = { 0, 0 };

        hogs_posed_at(&j->placer, true, drawn[i], x);
        feed_in_crop(j->f, x, uv);
        colour_at(j->m, j->f->image, uv, rgb + 3 * i);
        for (int k = 0; k < 3; k++)
            points[3 * i + k] = (lt_real)x[k];
    }
    feed_floats(j, "root", j->f->initial.root, 3);
}

void feed_contact(feed_job *j)
{
    const hogs_lists *l = &j->run->lists;
    const int64_t n = feed_count(&j->placer, false), first = feed_first_row(&j->placer, false);
    const int64_t object = feed_first_row(&j->placer, true);
    const occupancy *grid = &l->grid[j->f->object];
    lt_real *hand = feed_at(j, "hand_points"), *surface = feed_at(j, "surface"), *box = feed_at(j, "grid");
    int32_t *zone = feed_at(j, "zones");

    if (!hand)
        return;
    for (int i = 0; i < HOGS_CONTACT_POINTS; i++) {
        const int64_t row = n > HOGS_CONTACT_POINTS ? lt_rng_below(&j->rng, (uint32_t)n) : i % n;
        const int vertex = l->vertex[first + row];
        double x[3];

        hogs_posed_at(&j->placer, false, row, x);
        zone[i] = vertex < 0 ? CONTACT_NOWHERE : j->placer.rig->zone[vertex];
        for (int k = 0; k < 3; k++)
            hand[3 * i + k] = (lt_real)x[k];
    }
    for (int i = 0; i < HOGS_SURFACE_POINTS; i++) {
        const int32_t row = l->surface[j->f->object][i];

        memcpy(surface + 3 * i, j->m->gaussians.centre->data + 3 * (object + (row < 0 ? 0 : row)),
               3 * sizeof(*surface));
    }
    memcpy(box, grid->lo, sizeof(grid->lo));
    memcpy(box + 3, grid->per_metre, sizeof(grid->per_metre));
    memcpy(feed_at(j, "inside"), grid->inside, sizeof(grid->inside));
}

/* In stage 2 half of the frames begin further off than their initial poses: one half of these much, the other less. */
void feed_shake(feed_job *j, hogs_frame *f)
{
    const bool coarse = lt_rng_uniform(&j->rng) < 0.5, at_all = lt_rng_uniform(&j->rng) < 0.5;
    const double hand = (coarse ? 8 : 4) * DEGREES, R = coarse ? 0.175 : 0.105, t = coarse ? 0.010 : 0.006;

    if (!at_all)
        return;
    for (int i = 0; i < LT_HAND_JOINTS; i++) {
        double by[3], turn[9], own[9];

        for (int k = 0; k < 3; k++)
            by[k] = hand * lt_rng_normal(&j->rng);
        for (int k = 0; k < 9; k++)
            own[k] = (double)f->initial.rotation[i][k];
        lt_rot_from_axis_angle(by, turn);
        lt_mat3_mul(turn, own, own);
        for (int k = 0; k < 9; k++)
            f->initial.rotation[i][k] = (float)own[k];
    }
    for (int k = 0; k < 9; k++)
        f->initial.R[k] += (float)(R * lt_rng_normal(&j->rng));
    for (int k = 0; k < 3; k++)
        f->initial.t[k] += (float)(t * lt_rng_normal(&j->rng));
}

