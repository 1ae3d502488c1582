/* SPDX-License-Identifier: Apache-2.0 */
/* The pinhole camera, the axes of datasets, affine maps of the image. */
#include "libtensor/geometry/camera.h"

#include "libtensor/geometry/rotation.h"

static const double NEAREST_Z = 1e-9;

bool lt_camera_project(const lt_camera *cam, const double p[3], double uv[2])
{
    const double inv = fabs(p[2]) > NEAREST_Z ? 1 / p[2] : 0;

    uv[0] = cam->fx * (p[0] * inv) + cam->cx;
    uv[1] = cam->fy * (p[1] * inv) + cam->cy;
    return p[2] > NEAREST_Z;
}

void lt_camera_backproject(const lt_camera *cam, const double uv[2], double z, double p[3])
{
    p[0] = (uv[0] - cam->cx) / cam->fx * z;
    p[1] = (uv[1] - cam->cy) / cam->fy * z;
    p[2] = z;
}

lt_camera lt_camera_crop(const lt_camera *cam, const double A[6])
{
    return (lt_camera){
        .fx = A[0] * cam->fx, .cx = A[0] * cam->cx + A[2],
        .fy = A[4] * cam->fy, .cy = A[4] * cam->cy + A[5],
    };
}

void lt_flip_yz(double p[3])
{
    p[1] = -p[1];
    p[2] = -p[2];
}

void lt_flip_yz_pose(double R[9], double t[3])
{
    for (int i = 3; i < 9; i++)
        R[i] = -R[i];
    lt_flip_yz(t);
}

void lt_flip_yz_mano(double root[3], double t[3], const double J0[3])
{
    double R[9];

    for (int i = 0; i < 3; i++)
        t[i] += J0[i];
    lt_rot_from_axis_angle(root, R);
    lt_flip_yz_pose(R, t);
    lt_rot_to_axis_angle(R, root);
    lt_vec3_sub(t, J0, t);
}

void lt_mirror_axis_angle(double aa[3])
{
    lt_flip_yz(aa);
}

/* A = T R: R turns about the origin; T scales by size/side and moves the turned centre to the middle. */
void lt_affine_crop(double cx, double cy, double side, double phi, double size, double A[6])
{
    const double k = size / side, c = cos(phi), s = sin(phi);
    const double x = c * cx - s * cy, y = s * cx + c * cy;

    A[0] = k * c;
    A[1] = k * -s;
    A[2] = size * (0.5 - x / side);
    A[3] = k * s;
    A[4] = k * c;
    A[5] = size * (0.5 - y / side);
}

lt_status lt_affine_inverse(const double A[6], double out[6])
{
    const double det = A[0] * A[4] - A[1] * A[3];
    const double a = A[4] / det, b = -A[1] / det, c = -A[3] / det, d = A[0] / det;
    const double x = A[2], y = A[5];

    if (!isfinite(a + b + c + d) || !isfinite(x + y))
        return lt_error(LT_EINVAL, "affine: [%g %g; %g %g] has no inverse", A[0], A[1], A[3], A[4]);
    out[0] = a;
    out[1] = b;
    out[2] = -(a * x + b * y);
    out[3] = c;
    out[4] = d;
    out[5] = -(c * x + d * y);
    return LT_OK;
}

void lt_affine_apply(const double A[6], const double p[2], double q[2])
{
    const double x = p[0], y = p[1];

    q[0] = A[0] * x + A[1] * y + A[2];
    q[1] = A[3] * x + A[4] * y + A[5];
}
