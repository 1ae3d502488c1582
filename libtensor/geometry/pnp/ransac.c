/* SPDX-License-Identifier: Apache-2.0 */
/* Pose of points of which some are wrong: draw five, solve, count who agrees. */
#include "libtensor/geometry/pnp/pnp.h"

#include "libtensor/base/arena.h"
#include "libtensor/base/rng.h"
#include "libtensor/geometry/pnp/input.h"
#include "libtensor/geometry/principal.h"
#include "libtensor/geometry/rotation.h"

#include <float.h>

enum { DRAW = 5, LEAST_POINTS = 6, FEW_INLIERS = 256 };     /* few: without an allocation */

typedef lt_status solver(const lt_camera *cam, int n, const double *X, const double *uv, double R[9],
                         double t[3]);

typedef struct {
    const lt_camera *cam;
    int n;
    const double *X, *uv;
    const lt_pnp_opts *opts;
    bool thin;
} problem;

lt_pnp_opts lt_pnp_opencv(void)
{
    return (lt_pnp_opts){ .iterations = 100, .inlier_px = 8, .confidence = 0.99, .min_inliers = DRAW };
}

lt_pnp_opts lt_pnp_refined(void)
{
    lt_pnp_opts o = lt_pnp_opencv();

    o.min_inliers = 6;
    o.min_scatter = 1e-3;
    o.thin = 0.05;
    o.refine_iterations = 20;
    o.min_depth_m = 0.05;
    return o;
}

static bool is_thin(const problem *p)
{
    double lo[3] = { INFINITY, INFINITY, INFINITY }, hi[3] = { -INFINITY, -INFINITY, -INFINITY };
    double least = INFINITY, next = INFINITY;

    for (int i = 0; i < 3 * p->n; i++) {
        lo[i % 3] = fmin(lo[i % 3], p->X[i]);
        hi[i % 3] = fmax(hi[i % 3], p->X[i]);
    }
    for (int k = 0; k < 3; k++) {
        const double extent = hi[k] - lo[k];
        next = fmin(next, fmax(least, extent));
        least = fmin(least, extent);
    }
    return least < p->opts->thin * next;
}

static lt_status solve(const problem *p, int n, const double *X, const double *uv, double R[9], double t[3])
{
    solver *const fn = p->thin ? lt_pnp_planar : lt_epnp;

    return fn(p->cam, n, X, uv, R, t);
}

static void copy_pair(const problem *p, int from, double *X, double *uv, int to)
{
    memcpy(X + 3 * to, p->X + 3 * from, 3 * sizeof(*X));
    memcpy(uv + 2 * to, p->uv + 2 * from, 2 * sizeof(*uv));
}

static void draw_pairs(const problem *p, lt_rng *rng, double X[3 * DRAW], double uv[2 * DRAW])
{
    int chosen[DRAW];

    for (int i = 0; i < DRAW; i++) {
        bool fresh;
        do {
            chosen[i] = (int)lt_rng_below(rng, (uint32_t)p->n);
            fresh = true;
            for (int j = 0; j < i; j++)
                fresh = fresh && chosen[j] != chosen[i];
        } while (!fresh);
        copy_pair(p, chosen[i], X, uv, i);
    }
}

/* Five different object points with some depth to them. */
static bool well_spread(const problem *p, const double X[3 * DRAW])
{
    lt_principal s;

    if (p->opts->min_scatter <= 0)
        return true;
    for (int i = 1; i < DRAW; i++)
        for (int j = 0; j < i; j++)
            if (memcmp(X + 3 * i, X + 3 * j, 3 * sizeof(*X)) == 0)
                return false;
    if (p->thin)                                    /* as flat as they come */
        return true;
    lt_principal_of(DRAW, X, &s);
    return s.spread[2] * s.spread[2] >= p->opts->min_scatter * s.spread[1] * s.spread[1];
}

static bool is_inlier(const problem *p, int i, const double R[9], const double t[3])
{
    double x[3], q[2], du, dv;

    lt_rigid_apply(R, t, p->X + 3 * i, x);
    if (!lt_camera_project(p->cam, x, q))
        return false;
    du = q[0] - p->uv[2 * i];
    dv = q[1] - p->uv[2 * i + 1];
    return du * du + dv * dv <= p->opts->inlier_px * p->opts->inlier_px;
}

static int count_inliers(const problem *p, const double R[9], const double t[3])
{
    int count = 0;

    for (int i = 0; i < p->n; i++)
        count += is_inlier(p, i, R, t);
    return count;
}

/* Draws after which one of inliers only has come up with the wanted confidence. */
static int draws_needed(const problem *p, int inliers, int most)
{
    const double all_good = pow((double)inliers / p->n, DRAW);
    const double num = log(fmax(1 - p->opts->confidence, DBL_MIN));
    const double denom = log(fmax(1 - all_good, DBL_MIN));

    return denom >= 0 || num <= most * denom ? most : (int)nearbyint(num / denom);
}

/* Leaves the best draw's pose and how many agree with it; 0 when no draw gave a pose. */
static int search(const problem *p, double R[9], double t[3])
{
    lt_rng rng = lt_rng_make(p->opts->seed, 0);
    int best = 0, limit = p->opts->iterations;

    for (int draw = 0; draw < limit; draw++) {
        double X[3 * DRAW], uv[2 * DRAW], Rd[9], td[3];
        int count;
        draw_pairs(p, &rng, X, uv);
        if (!well_spread(p, X) || solve(p, DRAW, X, uv, Rd, td))
            continue;
        count = count_inliers(p, Rd, td);
        if (count <= best || count < DRAW)
            continue;
        best = count;
        memcpy(R, Rd, sizeof(Rd));
        memcpy(t, td, sizeof(td));
        limit = draws_needed(p, best, limit);
    }
    return best;
}

/* Solves on the inliers of pose->R, pose->t, which holds the answer afterwards. Of points of which many are the same
 * that may explain less than the draw did: where its mean error is no inlier's, the draw's pose stays. */
static lt_status solve_inliers(const problem *p, lt_pnp_pose *pose, double *X, double *uv)
{
    lt_pnp_pose all = *pose;
    lt_status st = LT_OK;
    int n = 0;

    for (int i = 0; i < p->n; i++)
        if (is_inlier(p, i, pose->R, pose->t))
            copy_pair(p, i, X, uv, n++);
    if (!solve(p, n, X, uv, all.R, all.t) && lt_pnp_error(p->cam, n, X, uv, all.R, all.t) <= p->opts->inlier_px)
        *pose = all;
    if (p->opts->refine_iterations > 0)
        st = lt_pnp_refine(p->cam, n, X, uv, p->opts->refine_iterations, pose->R, pose->t);
    if (st)
        return st;
    pose->mean_err_px = lt_pnp_error(p->cam, n, X, uv, pose->R, pose->t);
    if (!isfinite(pose->mean_err_px) || pose->t[2] < p->opts->min_depth_m)
        return lt_error(LT_ENUMERIC, "pnp: the best pose is %g m in front of the camera, want %g or more",
                        pose->t[2], p->opts->min_depth_m);
    return LT_OK;
}

lt_status lt_pnp_ransac(const lt_camera *cam, int n, const double *X, const double *uv,
                        const lt_pnp_opts *opts, lt_pnp_pose *pose, unsigned char *inlier)
{
    const lt_pnp_opts usual = lt_pnp_opencv();
    problem p = { .cam = cam, .n = n, .X = X, .uv = uv, .opts = opts ? opts : &usual };
    lt_status st = lt_pnp_check("pnp", cam, n, LEAST_POINTS, X, uv);
    lt_pnp_pose draw = { .n_inliers = 0 }, found;
    double few[5 * FEW_INLIERS], *room = few;

    if (st)
        return st;
    p.thin = is_thin(&p);
    draw.n_inliers = search(&p, draw.R, draw.t);
    if (draw.n_inliers < p.opts->min_inliers || draw.n_inliers == 0)
        return lt_error(LT_ENUMERIC, "pnp: %d of %d points agree on a pose, want %d", draw.n_inliers, n,
                        p.opts->min_inliers);
    if (draw.n_inliers > FEW_INLIERS)
        room = lt_alloc(5 * (size_t)draw.n_inliers * sizeof(*room));
    if (!room)
        return lt_error(LT_ENOMEM, "pnp: no memory for %d points", draw.n_inliers);
    found = draw;
    st = solve_inliers(&p, &found, room, room + 3 * (size_t)draw.n_inliers);
    if (room != few)
        lt_release(room);
    if (st)
        return st;
    *pose = found;
    for (int i = 0; inlier && i < n; i++)
        inlier[i] = is_inlier(&p, i, draw.R, draw.t);
    return LT_OK;
}
