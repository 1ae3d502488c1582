/* SPDX-License-Identifier: Apache-2.0 */
/* Reprojection error, and Levenberg-Marquardt on it. */
#include "libtensor/geometry/pnp/pnp.h"

#include "libtensor/geometry/pnp/input.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/geometry/solve6.h"

lt_status lt_pnp_check(const char *who, const lt_camera *cam, int n, int least, const double *X,
                       const double *uv)
{
    const double k[4] = { cam->fx, cam->fy, cam->cx, cam->cy };

    if (n < least)
        return lt_error(LT_EINVAL, "%s: %d points, want at least %d", who, n, least);
    if (!lt_all_finite(4, k) || k[0] == 0 || k[1] == 0)
        return lt_error(LT_EINVAL, "%s: camera fx %g, fy %g, cx %g, cy %g, want finite numbers and no "
                        "focal length 0", who, k[0], k[1], k[2], k[3]);
    if (!lt_all_finite(3 * (int64_t)n, X))
        return lt_error(LT_EINVAL, "%s: an object point is not finite", who);
    if (!lt_all_finite(2 * (int64_t)n, uv))
        return lt_error(LT_EINVAL, "%s: an image point is not finite", who);
    return LT_OK;
}

double lt_pnp_error(const lt_camera *cam, int n, const double *X, const double *uv, const double R[9],
                    const double t[3])
{
    double sum = 0;

    for (int i = 0; i < n; i++) {
        double p[3], q[2];
        lt_rigid_apply(R, t, X + 3 * i, p);
        if (!lt_camera_project(cam, p, q))
            return INFINITY;
        sum += hypot(q[0] - uv[2 * i], q[1] - uv[2 * i + 1]);
    }
    return n > 0 ? sum / n : 0;
}

/* The sum of squared errors at a pose, with what a step from there needs. */
typedef struct {
    double R[9], t[3];
    double cost;                /* infinite when a point is not in front */
    double JtJ[6][6], Jtr[6];   /* over a rotation vector in camera axes, then t */
} linearised;

static void add_row(linearised *l, const double row[6], double residual)
{
    for (int i = 0; i < 6; i++) {
        l->Jtr[i] += row[i] * residual;
        for (int j = 0; j < 6; j++)
            l->JtJ[i][j] += row[i] * row[j];
    }
}

/* Derivatives of f x/z (and of f y/z, with axis 1): towards p first, then p = exp(w) q + t. */
static void add_pixel(linearised *l, double f, int axis, const double p[3], const double q[3],
                      double residual)
{
    double dp[3] = { 0, 0, -f * p[axis] / (p[2] * p[2]) }, row[6];

    dp[axis] = f / p[2];
    lt_vec3_cross(q, dp, row);                      /* d(w x q).dp / dw = q x dp */
    memcpy(row + 3, dp, sizeof(dp));
    add_row(l, row, residual);
}

static void linearise(const lt_camera *cam, int n, const double *X, const double *uv, linearised *l)
{
    l->cost = 0;
    memset(l->JtJ, 0, sizeof(l->JtJ));
    memset(l->Jtr, 0, sizeof(l->Jtr));
    for (int i = 0; i < n; i++) {
        double q[3], p[3], seen[2];
        lt_mat3_mulvec(l->R, X + 3 * i, q);
        for (int k = 0; k < 3; k++)
            p[k] = q[k] + l->t[k];
        if (!lt_camera_project(cam, p, seen)) {
            l->cost = INFINITY;
            return;
        }
        seen[0] -= uv[2 * i];
        seen[1] -= uv[2 * i + 1];
        l->cost += seen[0] * seen[0] + seen[1] * seen[1];
        add_pixel(l, cam->fx, 0, p, q, seen[0]);
        add_pixel(l, cam->fy, 1, p, q, seen[1]);
    }
}

/* step = -(JtJ + damping diag(JtJ))^-1 Jtr; false when that is not positive definite. */
static bool solve_step(const linearised *l, double damping, double step[6])
{
    double S[6][6];

    memcpy(S, l->JtJ, sizeof(S));
    for (int i = 0; i < 6; i++) {
        S[i][i] *= 1 + damping;
        step[i] = -l->Jtr[i];
    }
    if (!lt_cholesky6(S))
        return false;
    lt_solve6(S, step);
    return true;
}

static void move(const linearised *from, const double step[6], linearised *to)
{
    double turn[9];

    lt_rot_from_axis_angle(step, turn);
    lt_mat3_mul(turn, from->R, to->R);
    for (int k = 0; k < 3; k++)
        to->t[k] = from->t[k] + step[3 + k];
}

lt_status lt_pnp_refine(const lt_camera *cam, int n, const double *X, const double *uv, int iterations,
                        double R[9], double t[3])
{
    const lt_status st = lt_pnp_check("pnp_refine", cam, n, 3, X, uv);
    double damping = 1e-3;
    linearised here, there;

    if (st)
        return st;
    memcpy(here.R, R, sizeof(here.R));
    memcpy(here.t, t, sizeof(here.t));
    linearise(cam, n, X, uv, &here);
    if (!isfinite(here.cost))
        return lt_error(LT_ENUMERIC, "pnp_refine: the pose to start from has a point behind the camera");
    for (int i = 0; i < iterations; i++) {
        double step[6];
        if (!solve_step(&here, damping, step)) {
            damping *= 10;
            continue;
        }
        move(&here, step, &there);
        linearise(cam, n, X, uv, &there);
        if (there.cost < here.cost) {
            here = there;
            damping = fmax(damping / 10, 1e-12);
        } else {
            damping *= 10;
        }
    }
    lt_rot_nearest(here.R, R);                      /* products of rotations drift */
    memcpy(t, here.t, sizeof(here.t));
    return LT_OK;
}
