/* SPDX-License-Identifier: Apache-2.0 */
/* A grasp whose skin presses into the object becomes one that lies on it. */
#include "synth/grasp/internal.h"

#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/rotation.h"

#include <math.h>
#include <string.h>

enum { ROUNDS = 120 };

static const double LOOSER = 0.985;             /* of a finger's angles, a round */
static const double GIVE = 0.5;                 /* of the deepest vertex's way out, a round */

static void pose_hand(const synth_grasp_ctx *ctx, const synth_grasp *g, double (*skin)[3])
{
    double R[LT_HAND_JOINTS][9], joints[LT_HAND_JOINTS][3];

    for (int j = 0; j < LT_HAND_JOINTS; j++)
        lt_rot_from_axis_angle(&g->pose[3 * j], R[j]);
    lt_hand_pose(ctx->hand.model, &R[0][0], ctx->hand.beta, g->trans, skin[0], joints[0]);
}

/* Fingers that are inside open a little; the whole hand gives way where it is deepest. Whether it is clear. */
static bool loosen(const synth_grasp_ctx *ctx, const double (*skin)[3], double margin, synth_grasp *g)
{
    bool inside[FINGERS] = { false };
    double deepest = 0, away[3] = { 0 };

    for (int v = 0; v < LT_HAND_VERTICES; v++) {
        double out[3];
        const double depth = margin - synth_sdf_at(&ctx->sdf, skin[v], out);
        if (depth <= 0)
            continue;
        if (ctx->hand.finger[v] >= 0)
            inside[ctx->hand.finger[v]] = true;
        if (depth > deepest) {
            deepest = depth;
            memcpy(away, out, sizeof(away));
        }
    }
    if (deepest <= 0)
        return true;
    lt_vec3_unit(away);
    for (int k = 0; k < 3; k++)
        g->trans[k] += GIVE * deepest * away[k];
    for (int f = 0; f < FINGERS; f++)
        for (int i = 0; i < 9 && inside[f]; i++)
            g->pose[3 + 9 * f + i] *= LOOSER;
    return false;
}

bool synth_grasp_clear(const synth_grasp_ctx *ctx, double margin, synth_grasp *g)
{
    double skin[LT_HAND_VERTICES][3];

    for (int round = 0; round < ROUNDS; round++) {
        pose_hand(ctx, g, skin);
        if (loosen(ctx, (const double (*)[3])skin, margin, g)) {
            g->penetration = g->mean_penetration = g->volume = 0;
            return true;
        }
    }
    return false;
}
