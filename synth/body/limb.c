/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/body/limb.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>

void synth_limb_aim(int side, const double collar[9], const double shoulder[3], const double elbow[3],
                    const double wrist[3], double R_shoulder[9], double R_elbow[9])
{
    const double out = side ? -1 : 1;
    double x[3], y[3], z[3], fore[3], back[9], bend;

    lt_vec3_sub(elbow, shoulder, x);
    lt_vec3_sub(wrist, elbow, fore);
    lt_vec3_unit(x);
    lt_vec3_unit(fore);
    bend = acos(fmax(-1, fmin(1, lt_vec3_dot(x, fore))));
    lt_vec3_cross(x, fore, y);
    lt_vec3_unit(y);
    for (int k = 0; k < 3; k++) {
        y[k] *= -out;
        x[k] *= out;
    }
    lt_vec3_cross(x, y, z);
    const double world[9] = { x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2] };
    lt_mat3_transpose(collar, back);
    lt_mat3_mul(back, world, R_shoulder);
    synth_body_rotation((double[]){ 0, -out * bend, 0 }, R_elbow);
}

/* The axis-angle of a right hand's joint as the side's hand has it */
static void own_rotation(int side, const double a[3], double R[9])
{
    lt_rot_from_axis_angle((double[]){ a[0], side ? a[1] : -a[1], side ? a[2] : -a[2] }, R);
}

void synth_limb_fingers(int side, const double pose[3 * LT_HAND_JOINTS], double (*R)[9])
{
    for (int k = 0; k < BODY_HAND_JOINTS; k++)
        own_rotation(side, pose + 3 * (k + 1), R[BODY_FINGERS + side * BODY_HAND_JOINTS + k]);
}

void synth_limb_object(int side, const synth_grip *g, const double wrist_R[9], const double wrist[3], double R[9],
                       double t[3])
{
    double root[9], back[9], way[3];

    own_rotation(side, g->pose, root);
    lt_mat3_transpose(root, back);
    lt_mat3_mul(wrist_R, back, R);
    lt_mat3_mulvec(R, g->wrist, way);
    lt_vec3_sub(wrist, way, t);
}
