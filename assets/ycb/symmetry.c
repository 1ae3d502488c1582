/* SPDX-License-Identifier: Apache-2.0 */
#include "assets/ycb/symmetry.h"

#include <math.h>

/* The i-th of n steps around an axis, for all but the first, which is none */
static int turns(const ycb_object *o, const double axis[3], int n, lt_pose *out)
{
    for (int i = 1; i < n; i++)
        out[i - 1] = lt_pose_turn(o->centre, axis, 2 * M_PI * i / n);
    return n - 1;
}

/* Quarter turns about z; and half turns about what lies between the sides' axes and on them */
static int quarter_turns_and_flips(const ycb_object *o, lt_pose *out)
{
    const double z[3] = { 0, 0, 1 };
    int n = turns(o, z, 4, out);

    for (int i = 0; i < 4; i++) {
        const double at = o->yaw + i * M_PI / 4, axis[3] = { cos(at), sin(at), 0 };
        out[n++] = lt_pose_turn(o->centre, axis, M_PI);
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

bool ycb_turns_about(const ycb_object *object, double axis[3])
{
    const bool about_y = object->symmetry == YCB_SYM_CYLINDER_Y;

    axis[0] = 0;
    axis[1] = about_y;
    axis[2] = !about_y;
    return object->adds & YCB_ADDS_BOP && (about_y || object->symmetry == YCB_SYM_CYLINDER_Z ||
                                           object->symmetry == YCB_SYM_CONTINUOUS_Z);
}

int ycb_symmetries(const ycb_object *object, lt_pose *out)
{
    const double z[3] = { 0, 0, 1 };
    double axis[3];

    if (!(object->adds & YCB_ADDS_BOP))
        return 0;
    if (ycb_turns_about(object, axis))
        return turns(object, axis, YCB_TURNS, out);
    switch (object->symmetry) {
    case YCB_SYM_C2:
        long_axis(object, axis);
        return turns(object, axis, 2, out);
    case YCB_SYM_C2_Z:
        return turns(object, z, 2, out);
    case YCB_SYM_C4_Z:
        return quarter_turns_and_flips(object, out);
    default:
        return 0;
    }
}
