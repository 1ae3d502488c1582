/* SPDX-License-Identifier: Apache-2.0 */
#include "assets/ycb/symmetry.h"

#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>

eval_pose eval_turn(const double point[3], const double axis[3], double angle)
{
    const double aa[3] = { axis[0] * angle, axis[1] * angle, axis[2] * angle };
    eval_pose s;
    double moved[3];

    lt_rot_from_axis_angle(aa, s.R);
    lt_mat3_mulvec(s.R, point, moved);
    lt_vec3_sub(point, moved, s.t);
    return s;
}

/* The i-th of n steps around an axis, for all but the first, which is none */
static int turns(const ycb_object *o, const double axis[3], int n, eval_pose *out)
{
    for (int i = 1; i < n; i++)
        out[i - 1] = eval_turn(o->centre, axis, 2 * M_PI * i / n);
    return n - 1;
}

/* Quarter turns about z; and half turns about what lies between the sides' axes and on them */
static int quarter_turns_and_flips(const ycb_object *o, eval_pose *out)
{
    const double z[3] = { 0, 0, 1 };
    int n = turns(o, z, 4, out);

    for (int i = 0; i < 4; i++) {
        const double at = o->yaw + i * M_PI / 4, axis[3] = { cos(at), sin(at), 0 };
        out[n++] = eval_turn(o->centre, axis, M_PI);
    }
    return n;
}

/* The longer side of the rectangle around the model, seen along z */
static void long_axis(const ycb_object *o, double axis[3])
{
    const double at = o->yaw + (o->rect[1] > o->rect[0] ? M_PI / 2 : 0);

    axis[0] = cos(at);
    axis[1] = sin(at);
    axis[2] = 0;
}

int eval_symmetries(const ycb_object *object, eval_pose *out)
{
    const double y[3] = { 0, 1, 0 }, z[3] = { 0, 0, 1 };
    double axis[3];

    if (!eval_is_symmetric(EVAL_SYM_BOP, object->id))
        return 0;
    switch (object->symmetry) {
    case YCB_SYM_CYLINDER_Z:
    case YCB_SYM_CONTINUOUS_Z:
        return turns(object, z, EVAL_TURNS, out);
    case YCB_SYM_CYLINDER_Y:
        return turns(object, y, EVAL_TURNS, out);
    case YCB_SYM_C2:
        long_axis(object, axis);
        return turns(object, axis, 2, out);
    case YCB_SYM_C2_Z:
        return turns(object, z, 2, out);
    case YCB_SYM_C4_Z:
        return quarter_turns_and_flips(object, out);
    case YCB_SYM_BOX:
    case YCB_SYM_NONE:
        break;
    }
    return 0;
}
