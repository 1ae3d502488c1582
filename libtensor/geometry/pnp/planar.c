/* SPDX-License-Identifier: Apache-2.0 */
/* Pose of a flat thing: from the homography between its plane and the image, one of two rotations. */
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

/* From metres along the plane's two long principal axes to z = 1. The equations are made in units of the spreads, and
 * of image points about their own mean and in their own scale, which keeps A well conditioned. */
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
        const double *h = AtA, unit = k < 2 ? 1 / s->spread[k] : 1;
        H[6 + k] = unit * h[6 + k];
        H[k] = unit * (size * h[k] + (mean[0] - cam->cx) / cam->fx * h[6 + k]);
        H[3 + k] = unit * (size * h[3 + k] + (mean[1] - cam->cy) / cam->fy * h[6 + k]);
    }
    return true;
}

/* ---- two rotations ------------------------------------------------------------------------------------ */

/* The shortest turn that brings the z axis to the ray (p, q, 1) */
static void turn_to_ray(double p, double q, double R[9])
{
    const double z = 1 / sqrt(p * p + q * q + 1), x = p * z, y = q * z;
    const double turn[9] = { 1 - x * x / (1 + z), -x * y / (1 + z), x,
                             -x * y / (1 + z), 1 - y * y / (1 + z), y,
                             -x, -y, z };

    memcpy(R, turn, sizeof(turn));
}

/* out = B^-1 J, of 2 x 2 */
static void divide(const double B[4], const double J[4], double out[4])
{
    const double det = B[0] * B[3] - B[1] * B[2];

    for (int k = 0; k < 2; k++) {
        out[k] = (B[3] * J[k] - B[1] * J[2 + k]) / det;
        out[2 + k] = (B[0] * J[2 + k] - B[2] * J[k]) / det;
    }
}

/* The larger singular value of a 2 x 2 matrix */
static double norm_of(const double A[4])
{
    const double a = A[0] * A[0] + A[1] * A[1], b = A[2] * A[2] + A[3] * A[3], c = A[0] * A[2] + A[1] * A[3];

    return sqrt((a + b + hypot(a - b, 2 * c)) / 2);
}

/*
 * Infinitesimal plane-based pose. The homography's derivative at the plane's centre, against the ray there, is the
 * upper left of the rotation over the depth, of which the larger singular value is 1; what is missing of its last row
 * is known but for a sign. False for a homography that is no picture of a plane.
 *
 * Source: Collins and Bartoli 2014, "Infinitesimal plane-based pose estimation", sections 4.2 to 4.4.
 */
static bool two_rotations(const double H[9], double R[2][9])
{
    const double p = H[2] / H[8], q = H[5] / H[8];
    double V[9], J[4], B[4], A[4], largest, b[2];

    turn_to_ray(p, q, V);
    for (int k = 0; k < 2; k++) {
        J[k] = (H[k] - p * H[6 + k]) / H[8];
        J[2 + k] = (H[3 + k] - q * H[6 + k]) / H[8];
        B[k] = V[k] - p * V[6 + k];
        B[2 + k] = V[3 + k] - q * V[6 + k];
    }
    divide(B, J, A);
    largest = norm_of(A);
    if (!(largest > 0 && isfinite(largest)))
        return false;
    for (int k = 0; k < 4; k++)
        A[k] /= largest;
    b[0] = sqrt(fmax(0, 1 - A[0] * A[0] - A[2] * A[2]));
    b[1] = copysign(sqrt(fmax(0, 1 - A[1] * A[1] - A[3] * A[3])), -A[0] * A[1] - A[2] * A[3]);
    for (int i = 0; i < 2; i++) {
        const double sign = i ? -1 : 1;
        const double first[3] = { A[0], A[2], sign * b[0] }, second[3] = { A[1], A[3], sign * b[1] };
        double third[3];

        lt_vec3_cross(first, second, third);
        lt_mat3_mul(V, (double[9]){ first[0], second[0], third[0], first[1], second[1], third[1],
                                    first[2], second[2], third[2] }, R[i]);
    }
    return true;
}

/* The t for which R x + t is seen at uv, by least squares on the rays */
static void translation(const lt_camera *cam, int n, const double *X, const double *uv, const double R[9], double t[3])
{
    double ray[2] = { 0 }, off[2] = { 0 }, spread = 0, pull = 0;

    for (int i = 0; i < n; i++) {
        const double r[2] = { (uv[2 * i] - cam->cx) / cam->fx, (uv[2 * i + 1] - cam->cy) / cam->fy };
        double x[3];

        lt_mat3_mulvec(R, X + 3 * i, x);
        for (int k = 0; k < 2; k++) {
            const double miss = r[k] * x[2] - x[k];

            ray[k] += r[k] / n;
            off[k] += miss / n;
            spread += r[k] * r[k] / n;
            pull += r[k] * miss / n;
        }
    }
    t[2] = (ray[0] * off[0] + ray[1] * off[1] - pull) / (spread - ray[0] * ray[0] - ray[1] * ray[1]);
    t[0] = off[0] + ray[0] * t[2];
    t[1] = off[1] + ray[1] * t[2];
}

/* Three points are seen as they are from up to four places, and many votes for each of them make no fourth. */
static bool four_differ(int n, const double *X)
{
    const double *known[3];
    int n_known = 0;

    for (int i = 0; i < n; i++) {
        int k = 0;

        while (k < n_known && memcmp(known[k], X + 3 * i, 3 * sizeof(*X)) != 0)
            k++;
        if (k < n_known)
            continue;
        if (n_known == 3)
            return true;
        known[n_known++] = X + 3 * i;
    }
    return false;
}

/* ---- the pose ----------------------------------------------------------------------------------------- */

lt_status lt_pnp_planar(const lt_camera *cam, int n, const double *X, const double *uv, double R[9],
                        double t[3])
{
    const lt_status st = lt_pnp_check("pnp_planar", cam, n, 4, X, uv);
    double H[9], plane_R[2][9], axes[9], best = INFINITY;
    lt_principal s;

    if (st)
        return st;
    lt_principal_of(n, X, &s);
    if (s.spread[1] <= LT_PNP_FLAT * s.spread[0])
        return lt_error(LT_ENUMERIC, "pnp_planar: the %d points are all equal or on a line", n);
    if (!four_differ(n, X))
        return lt_error(LT_ENUMERIC, "pnp_planar: fewer than four of the %d points differ", n);
    if (!homography(&s, cam, n, X, uv, H) || !two_rotations(H, plane_R))
        return lt_error(LT_ENUMERIC, "pnp_planar: no single homography fits the %d points", n);
    memcpy(axes, s.axis, sizeof(axes));             /* rows: from the object to the plane's frame, */
    lt_vec3_cross(axes, axes + 3, axes + 6);        /* right-handed */
    for (int i = 0; i < 2; i++) {
        double Ri[9], ti[3], err;

        lt_mat3_mul(plane_R[i], axes, Ri);
        translation(cam, n, X, uv, Ri, ti);
        err = lt_pnp_error(cam, n, X, uv, Ri, ti);
        if (err < best) {
            best = err;
            memcpy(R, Ri, sizeof(Ri));
            memcpy(t, ti, sizeof(ti));
        }
    }
    return best < INFINITY ? LT_OK
        : lt_error(LT_ENUMERIC, "pnp_planar: no pose has all %d points in front of the camera", n);
}
