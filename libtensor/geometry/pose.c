/* SPDX-License-Identifier: Apache-2.0 */
/* Rigid motions: applied, composed, made of a turn. */
#include "libtensor/geometry/pose.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"

void lt_pose_apply(const lt_pose *pose, int n, const double *x, double *out)
{
    for (int i = 0; i < n; i++)
        lt_rigid_apply(pose->R, pose->t, x + 3 * i, out + 3 * i);
}

lt_pose lt_pose_of(const float R[9], const float t[3])
{
    lt_pose p;

    for (int i = 0; i < 9; i++)
        p.R[i] = R[i];
    for (int i = 0; i < 3; i++)
        p.t[i] = t[i];
    return p;
}

lt_pose lt_pose_compose(const lt_pose *a, const lt_pose *b)
{
    lt_pose c;

    lt_mat3_mul(a->R, b->R, c.R);
    lt_rigid_apply(a->R, a->t, b->t, c.t);
    return c;
}

lt_pose lt_pose_turn(const double point[3], const double axis[3], double angle)
{
    const double aa[3] = { axis[0] * angle, axis[1] * angle, axis[2] * angle };
    lt_pose s;
    double moved[3];

    lt_rot_from_axis_angle(aa, s.R);
    lt_mat3_mulvec(s.R, point, moved);
    lt_vec3_sub(point, moved, s.t);
    return s;
}

bool lt_pose_finite(const lt_pose *pose)
{
    return lt_all_finite(9, pose->R) && lt_all_finite(3, pose->t);
}
