/* SPDX-License-Identifier: Apache-2.0 */
/* Pose of a flat thing: the homography between its plane and the image holds two columns of R, and t. */
#include "libtensor/geometry/pnp/pnp.h"

#include "libtensor/geometry/eigen.h"
#include "libtensor/geometry/pnp/input.h"
#include "libtensor/geometry/principal.h"
#include "libtensor/geometry/rotation.h"

/* Each pair gives two rows of A h = 0; AtA is their sum of squares. */
static void add_pair(double AtA[81], const double plane[3], const double ray[2])
{
    for (int axis = 0; axis < 2; axis++) {
        double row[9] = { 0 };
        for (int k = 0; k < 3; k++) {
            row[3 * axis + k] = plane[k];
            row[6 + k] = -ray[axis] * plane[k];
        }
        for (int k = 0; k < 81; k++)
            AtA[k] += row[k / 9] * row[k % 9];
    }
}

/* The plane's frame is the two long principal axes, each in units of its spread. Image points are on z = 1,
 * about their own mean and in their own scale, which keeps A well conditioned. */
static bool homography(const lt_principal *s, const lt_camera *cam, int n, const double *X,
                       const double *uv, double H[9])
{
    double AtA[81] = { 0 }, w[9], mean[2] = { 0 }, size = 0;

    for (int i = 0; i < 2 * n; i++)
        mean[i % 2] += uv[i] / n;
    for (int i = 0; i < n; i++)
        size += hypot((uv[2 * i] - mean[0]) / cam->fx, (uv[2 * i + 1] - mean[1]) / cam->fy) / n;
    if (!(size > 0))
        return false;
    for (int i = 0; i < n; i++) {
        const double ray[2] = { (uv[2 * i] - mean[0]) / cam->fx / size,
                                (uv[2 * i + 1] - mean[1]) / cam->fy / size };
        double d[3], plane[3];
        lt_vec3_sub(X + 3 * i, s->centre, d);
        for (int k = 0; k < 2; k++)
            plane[k] = lt_vec3_dot(s->axis[k], d) / s->spread[k];
        plane[2] = 1;
        add_pair(AtA, plane, ray);
    }
    lt_eigen_small(9, AtA, w);
    if (!(w[1] > 1e-12 * w[8]))         /* two solutions: a line, or 3 points */
        return false;
    for (int k = 0; k < 3; k++) {
        const double *h = AtA;
        H[6 + k] = h[6 + k];
        H[k] = size * h[k] + (mean[0] - cam->cx) / cam->fx * h[6 + k];
        H[3 + k] = size * h[3 + k] + (mean[1] - cam->cy) / cam->fy * h[6 + k];
    }
    return true;
}

/* H = scale [r1 spread0, r2 spread1, t_plane] */
static bool pose_from_homography(const lt_principal *s, const double H[9], double R[9], double t[3])
{
    double columns[3][3], M[9], plane_R[9], axes[9], turned[3], scale;

    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++)
            columns[k][i] = H[3 * i + k] / (k < 2 ? s->spread[k] : 1);
    scale = copysign(2 / (lt_vec3_norm(columns[0]) + lt_vec3_norm(columns[1])), columns[2][2]);
    if (!isfinite(scale))
        return false;
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++)
            columns[k][i] *= scale;
    lt_vec3_cross(columns[0], columns[1], turned);
    for (int i = 0; i < 3; i++) {
        M[3 * i] = columns[0][i];
        M[3 * i + 1] = columns[1][i];
        M[3 * i + 2] = turned[i];
    }
    lt_rot_nearest(M, plane_R);
    memcpy(axes, s->axis, sizeof(axes));            /* rows: from the object to the plane's frame, */
    lt_vec3_cross(axes, axes + 3, axes + 6);        /* right-handed */
    lt_mat3_mul(plane_R, axes, R);
    lt_mat3_mulvec(R, s->centre, turned);
    lt_vec3_sub(columns[2], turned, t);
    return true;
}

lt_status lt_pnp_planar(const lt_camera *cam, int n, const double *X, const double *uv, double R[9],
                        double t[3])
{
    const lt_status st = lt_pnp_check("pnp_planar", cam, n, 4, X, uv);
    double H[9], Rn[9], tn[3];
    lt_principal s;

    if (st)
        return st;
    lt_principal_of(n, X, &s);
    if (s.spread[1] <= LT_PNP_FLAT * s.spread[0])
        return lt_error(LT_ENUMERIC, "pnp_planar: the %d points are all equal or on a line", n);
    if (!homography(&s, cam, n, X, uv, H) || !pose_from_homography(&s, H, Rn, tn))
        return lt_error(LT_ENUMERIC, "pnp_planar: no single homography fits the %d points", n);
    if (lt_pnp_error(cam, n, X, uv, Rn, tn) == INFINITY)
        return lt_error(LT_ENUMERIC, "pnp_planar: no pose has all %d points in front of the camera", n);
    memcpy(R, Rn, sizeof(Rn));
    memcpy(t, tn, sizeof(tn));
    return LT_OK;
}
