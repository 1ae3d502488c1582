/* SPDX-License-Identifier: Apache-2.0 */
/* A place, the people who are there, and what their hands do. */
#include "synth/body/crop.h"

#include "libtensor/geometry/hand/layer.h"

#include <math.h>

enum { PLACE = 0x42504c43 };

/* Every other grip is around an object, where a grasp of it is found. */
static lt_status draw_grips(synth_crop_place *p, lt_rng *r)
{
    synth_subject who = { .bare = 1 };

    lt_hand_rest_wrist(p->hand, who.beta, who.rest_wrist);
    for (int i = 0; i < 2 * SYNTH_BODY_GRIPS; i++) {
        const int side = i % 2;
        synth_grip *g = &p->grip[side][p->n_grips[side]++];
        const synth_prop_pair *what = &p->prop[lt_rng_below(r, YCB_COUNT)];
        const uint64_t seed = lt_rng_mix(p->seed, lt_rng_mix(lt_rng_u32(r), (uint64_t)p->number));
        lt_status st = LT_ENUMERIC;

        if (i / 2 % 2 == 0)
            st = synth_grip_hold(p->hand, &who, what, side == 0, seed, g);
        if (st == LT_ENUMERIC)
            synth_grip_bare(p->hand, &who, side == 0, r, g);
        else if (st)
            return st;
    }
    return LT_OK;
}

lt_status synth_crop_place_new(lt_arena *arena, synth_crop_place *p)
{
    const uint64_t stream = lt_rng_mix(PLACE, (uint64_t)p->number);
    lt_rng r = lt_rng_make(p->seed, stream);
    synth_room *room = synth_room_new(arena, p->seed, stream, 0.1);

    for (int i = 0; room && i < room->n_instances; i++)
        if (room->instance[i].material.texture && !synth_texture_paint(room->instance[i].material.texture))
            room = NULL;
    if (!room)
        return lt_error(LT_ENOMEM, "synth: no memory for a room");
    p->room = room;
    for (int i = 0; i < SYNTH_BODY_PEOPLE; i++) {
        const int number = (int)p->number * SYNTH_BODY_PEOPLE + i;
        const lt_status st = synth_appearance_draw(arena, p->hand, p->seed, number, &p->look[i]);

        if (st)
            return st;
        for (int k = 0; k < BODY_SHAPES; k++)
            p->shape[i][k] = fmax(-2.5, fmin(2.5, lt_rng_normal(&r)));
    }
    return draw_grips(p, &r);
}
