/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What people look like: skin, hair, clothes; and the meshes that show a posed body so.
 *
 * A piece of clothing is a part of the skin, cut along its hems, some millimetres outside.
 */
#ifndef SYNTH_BODY_APPEARANCE_H
#define SYNTH_BODY_APPEARANCE_H

#include "assets/body/body.h"
#include "assets/hand/hand.h"
#include "libtensor/base/rng.h"
#include "synth/render/render.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Places are on the body at rest: metres above the floor, or along the arm from the middle. */
typedef struct {
    float hand[LT_HAND_VERTICES][3];            /* albedo, linear RGB */
    float skin[3], hair[3], iris[3], shoes[3];
    double sleeve, hem, cuff;                   /* where the shirt ends at the arm and below, the trousers at the leg */
    double loose;                               /* metres off the skin */
    double nape, fringe;                        /* down to where hair grows behind and in front */
    double hair_depth;                          /* metres; 0: bald */
    synth_texture *shirt, *trousers;
    uint32_t folds;                             /* seed of the folds */
} synth_appearance;

/* synth_appearance_draw - person number `number` of the dataset with this seed; textures are painted. LT_ENOMEM. */
lt_status synth_appearance_draw(lt_arena *arena, const lt_hand_model *hand, uint64_t seed, int number,
                                synth_appearance *out);

enum { SYNTH_WORN = 9 };                        /* meshes of a person */

/**
 * synth_appearance_wear - the meshes of a posed body
 *
 *   vertices     (BODY_VERTICES, 3) posed
 *   out          instances without a label, in the world's axes, in which the vertices are; meshes live in the arena
 *
 * Errors: LT_ENOMEM.
 */
lt_status synth_appearance_wear(lt_arena *arena, const synth_body *body, const synth_appearance *look,
                                const double (*vertices)[3], synth_instance out[SYNTH_WORN], int *n);

#ifdef __cplusplus
}
#endif
#endif
