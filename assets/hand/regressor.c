/* SPDX-License-Identifier: Apache-2.0 */
/* Joints as weighted means of the skin around them. */
#include "assets/hand/internal.h"

#include <string.h>

void hand_regressor(const hand_skeleton *s, const hand_rig *rig,
                    const hand_motion motion[LT_HAND_BETAS],
                    float out[LT_HAND_JOINTS][LT_HAND_VERTICES])
{
    const vec3 *skin[LT_HAND_BETAS];

    for (int k = 0; k < LT_HAND_BETAS; k++)
        skin[k] = motion[k].vertex;
    memset(out, 0, sizeof(float[LT_HAND_JOINTS][LT_HAND_VERTICES]));
    for (int j = 0; j < LT_HAND_JOINTS; j++) {
        const vec3 joint = j ? s->joint[(j - 1) / 3][(j - 1) % 3] : s->wrist;
        vec3 moves[LT_HAND_BETAS];
        surface_ring r;

        for (int k = 0; k < LT_HAND_BETAS; k++)
            moves[k] = motion[k].joint[j];
        surface_ring_near(rig->vertex, NULL, LT_HAND_VERTICES, joint, &r);
        surface_regress(rig->vertex, skin, joint, moves, LT_HAND_BETAS, 1, &r);
        for (int i = 0; i < r.n; i++)
            out[j][r.id[i]] = (float)r.w[i];
    }
}
