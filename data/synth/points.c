/* SPDX-License-Identifier: Apache-2.0 */
/*
 * points.xyz of a stand-in: farthest-point samples of its surface.
 */
#include "data/synth/objects.h"

#include "libtensor/geometry/mesh_ops.h"

enum { DRAWS = 6 * SYNTH_POINTS };          /* of which the farthest are kept */

lt_status synth_object_points(lt_arena *arena, const lt_mesh *mesh, float (**point)[3])
{
    lt_rng rng = lt_rng_make(0, SYNTH_POINTS);
    lt_arena *scratch = lt_arena_new();
    float (*out)[3] = lt_arena_array(arena, SYNTH_POINTS, sizeof(*out)), (*from)[3] = NULL;
    int *chosen = NULL;
    lt_status st;

    if (scratch) {
        from = lt_arena_array(scratch, DRAWS, sizeof(*from));
        chosen = lt_arena_array(scratch, SYNTH_POINTS, sizeof(*chosen));
    }
    st = out && from && chosen ? LT_OK : lt_error(LT_ENOMEM, "no memory for %d points", DRAWS);
    if (!st)
        st = lt_mesh_sample(mesh, &rng, DRAWS, from, NULL);
    if (!st)
        st = lt_farthest_points(DRAWS, (const float (*)[3])from, SYNTH_POINTS, 0, chosen);
    for (int i = 0; i < SYNTH_POINTS && !st; i++)
        for (int k = 0; k < 3; k++)
            out[i][k] = from[chosen[i]][k];
    if (!st)
        *point = out;
    lt_arena_free(scratch);
    return st;
}
