/* SPDX-License-Identifier: Apache-2.0 */
/* Rotations: matrix, axis-angle, quaternion, 6D. */
#include "libtensor/geometry/rotation.h"

#include "libtensor/geometry/svd3.h"

/* R = I + a K + b K^2 with K x = aa x x, a = sin(angle)/angle, b = (1 - cos(angle))/angle^2 */
void lt_rot_from_axis_angle(const double aa[3], double R[9])
{
    const double sq = lt_vec3_dot(aa, aa), angle = sqrt(sq);
    const double x = aa[0], y = aa[1], z = aa[2];
    double a, b;

    if (sq < 1e-4) {            /* the next terms of the series are under 1e-15 */
        a = 1 - sq / 6 + sq * sq / 120;
        b = 0.5 - sq / 24 + sq * sq / 720;
    } else {
        const double half = sin(0.5 * angle);
        a = sin(angle) / angle;
        b = 2 * half * half / sq;
    }
    R[0] = 1 - b * (y * y + z * z);
    R[1] = b * x * y - a * z;
    R[2] = b * x * z + a * y;
    R[3] = b * x * y + a * z;
    R[4] = 1 - b * (x * x + z * z);
    R[5] = b * y * z - a * x;
    R[6] = b * x * z - a * y;
    R[7] = b * y * z + a * x;
    R[8] = 1 - b * (x * x + y * y);
}

/* At angle pi w is 0 and both signs of the axis are right: its largest component shall be positive. */
static bool turns_negative(const double q[4])
{
    int top = 1;

    if (q[0] != 0)
        return q[0] < 0;
    for (int i = 2; i < 4; i++)
        if (fabs(q[i]) > fabs(q[top]))
            top = i;
    return q[top] < 0;
}

/* Shepperd's method: start from the largest of the four squares, so that no root is of a small number. */
void lt_rot_to_quat(const double R[9], double q[4])
{
    const double square[4] = {
        1 + R[0] + R[4] + R[8], 1 + R[0] - R[4] - R[8], 1 - R[0] + R[4] - R[8], 1 - R[0] - R[4] + R[8],
    };
    const double wx = R[7] - R[5], wy = R[2] - R[6], wz = R[3] - R[1];
    const double xy = R[1] + R[3], xz = R[2] + R[6], yz = R[5] + R[7];
    const double row[4][4] = {          /* 4 q q^T, off the diagonal */
        { square[0], wx, wy, wz }, { wx, square[1], xy, xz },
        { wy, xy, square[2], yz }, { wz, xz, yz, square[3] },
    };
    double norm = 0;
    int top = 0;

    for (int i = 1; i < 4; i++)
        if (square[i] > square[top])
            top = i;
    for (int i = 0; i < 4; i++)
        norm += row[top][i] * row[top][i];
    norm = turns_negative(row[top]) ? -sqrt(norm) : sqrt(norm);
    for (int i = 0; i < 4; i++)
        q[i] = row[top][i] / norm;
}

void lt_rot_from_quat(const double q[4], double R[9])
{
    const double sq = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    const double s = sq == 0 ? 0 : 2 / sq;
    const double w = q[0], x = q[1], y = q[2], z = q[3];

    R[0] = 1 - s * (y * y + z * z);
    R[1] = s * (x * y - w * z);
    R[2] = s * (x * z + w * y);
    R[3] = s * (x * y + w * z);
    R[4] = 1 - s * (x * x + z * z);
    R[5] = s * (y * z - w * x);
    R[6] = s * (x * z - w * y);
    R[7] = s * (y * z + w * x);
    R[8] = 1 - s * (x * x + y * y);
}

void lt_quat_mul(const double a[4], const double b[4], double out[4])
{
    const double r[4] = {
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    };

    memcpy(out, r, sizeof(r));
}

void lt_quat_exp(const double v[3], double scale, double q[4])
{
    const double angle = scale * lt_vec3_norm(v);
    const double s = angle > 1e-8 ? sin(angle / 2) / angle * scale : scale / 2;

    q[0] = cos(angle / 2);
    for (int i = 0; i < 3; i++)
        q[1 + i] = s * v[i];
}

void lt_quat_difference(const double a[4], const double b[4], double v[3])
{
    const double inverse[4] = { b[0], -b[1], -b[2], -b[3] };
    double d[4], length, scale;

    lt_quat_mul(a, inverse, d);
    for (int i = 0; d[0] < 0 && i < 4; i++)
        d[i] = i ? -d[i] : d[i];
    d[0] = fabs(d[0]);
    length = lt_vec3_norm(d + 1);
    scale = length < 1e-8 ? 2 : 2 * atan2(length, d[0]) / length;
    for (int i = 0; i < 3; i++)
        v[i] = scale * d[1 + i];
}

bool lt_quat_unit(double q[4])
{
    const double n = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);

    for (int i = 0; i < 4; i++)
        q[i] /= n;
    return isfinite(n) && n > 0;
}

void lt_rot_to_axis_angle(const double R[9], double aa[3])
{
    double q[4], sine, factor;

    lt_rot_to_quat(R, q);
    sine = lt_vec3_norm(q + 1);                     /* of half the angle */
    factor = sine == 0 ? 2 : 2 * atan2(sine, q[0]) / sine;
    for (int i = 0; i < 3; i++)
        aa[i] = factor * q[1 + i];
}

static void normalise(double v[3])
{
    const double norm = fmax(lt_vec3_norm(v), 1e-12);

    for (int i = 0; i < 3; i++)
        v[i] /= norm;
}

void lt_rot_from_6d(const double d[6], double R[9])
{
    double b1[3] = { d[0], d[1], d[2] }, b2[3], b3[3], along;

    normalise(b1);
    along = lt_vec3_dot(b1, d + 3);
    for (int i = 0; i < 3; i++)
        b2[i] = d[3 + i] - along * b1[i];
    normalise(b2);
    lt_vec3_cross(b1, b2, b3);
    for (int i = 0; i < 3; i++) {
        R[3 * i] = b1[i];
        R[3 * i + 1] = b2[i];
        R[3 * i + 2] = b3[i];
    }
}

void lt_rot_to_6d(const double R[9], double d[6])
{
    for (int i = 0; i < 3; i++) {
        d[i] = R[3 * i];
        d[3 + i] = R[3 * i + 1];
    }
}

/* R = U diag(1, 1, det(U V^T)) V^T */
void lt_rot_nearest(const double M[9], double R[9])
{
    double U[9], s[3], V[9], Vt[9];

    lt_svd3(M, U, s, V);
    if (lt_mat3_det(U) * lt_mat3_det(V) < 0)
        for (int i = 0; i < 3; i++)
            U[3 * i + 2] = -U[3 * i + 2];
    lt_mat3_transpose(V, Vt);
    lt_mat3_mul(U, Vt, R);
    if (isnan(s[0]))
        for (int i = 0; i < 9; i++)
            R[i] = NAN;
}

bool lt_rot_is_near(const double M[9], double tolerance)
{
    double R[9];

    lt_rot_nearest(M, R);
    for (int i = 0; i < 9; i++)
        if (!(fabs(M[i] - R[i]) <= tolerance))
            return false;
    return true;
}

double lt_rot_angle(const double A[9], const double B[9])
{
    double At[9], M[9], twice_sine[3];

    lt_mat3_transpose(A, At);
    lt_mat3_mul(At, B, M);
    twice_sine[0] = M[7] - M[5];
    twice_sine[1] = M[2] - M[6];
    twice_sine[2] = M[3] - M[1];
    return atan2(lt_vec3_norm(twice_sine), M[0] + M[4] + M[8] - 1);
}
