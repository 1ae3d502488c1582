/* SPDX-License-Identifier: Apache-2.0 */
/* From a world whose z is up to the axes of clips: x right, y down, z forward of somebody who looks forward. */
#ifndef DATA_ACTION_AXES_H
#define DATA_ACTION_AXES_H

#include "libtensor/geometry/mat3.h"

/* action_axes - R so that x_clip = R x_world, for a direction that he looks along, of which the level part counts;
 * without one, along the world's y */
static inline void action_axes(const double forward[3], double R[9])
{
    static const double down[3] = { 0, 0, -1 };
    double z[3] = { forward[0], forward[1], 0 };

    if (!(lt_vec3_unit(z) > 0))
        z[1] = 1;
    lt_vec3_cross(down, z, R);
    memcpy(R + 3, down, sizeof(down));
    memcpy(R + 6, z, sizeof(z));
}

#endif
