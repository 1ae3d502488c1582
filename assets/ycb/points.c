/* SPDX-License-Identifier: Apache-2.0 */
/*
 * points.xyz of a stand-in: farthest-point samples of its surface.
 */
#include "assets/ycb/objects.h"

#include "libtensor/geometry/mesh/surface.h"

#include <string.h>

enum { DRAWS = 6 * SYNTH_POINTS };          /* of which the farthest are kept */

lt_status synth_object_points(lt_arena *arena, const lt_mesh *mesh, float (**point)[3])
{
    lt_rng rng = lt_rng_make(0, SYNTH_POINTS);
    lt_arena *scratch = lt_arena_new();
    float (*out)[3] = lt_arena_array(arena, SYNTH_POINTS, sizeof(*out));
    float (*from)[3] = scratch ? lt_arena_array(scratch, DRAWS, sizeof(*from)) : NULL;
    int *kept = scratch ? lt_arena_array(scratch, SYNTH_POINTS, sizeof(*kept)) : NULL;
    lt_status st = out && from && kept ? LT_OK : lt_error(LT_ENOMEM, "no memory for %d points", DRAWS);

    if (!st)
        st = lt_mesh_sample(mesh, &rng, DRAWS, from, NULL);
    if (!st)
        st = lt_farthest_points(DRAWS, (const float (*)[3])from, SYNTH_POINTS, 0, kept);
    for (int i = 0; !st && i < SYNTH_POINTS; i++)
        memcpy(out[i], from[kept[i]], sizeof(out[i]));
    if (!st)
        *point = out;
    lt_arena_free(scratch);
    return st;
}
