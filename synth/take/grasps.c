/* SPDX-License-Identifier: Apache-2.0 */
/* How the subject of a take holds its prop. */
#include "synth/take/stage.h"

#include <string.h>

enum {
    TRIES = 4,                      /* drawn for a round at most: the first that can be taken from the table */
    GRASP = 0x47524153,
};

static const double APART = 0.0008;     /* metres between skin and object where they must share no space */

/* A grasp that can be taken from the table, where one of a few can; else the first. */
static lt_status choose(const synth_grasp_ctx *ctx, const synth_stage_spec *take, uint64_t seed, synth_grasp *out)
{
    bool found = false;
    synth_grasp grasp;
    synth_sequence_spec spec = { .grasp = &grasp, .object = &take->prop->mesh };

    memcpy(spec.rest_wrist, take->subject->rest_wrist, sizeof(spec.rest_wrist));
    for (int i = 0; i < TRIES; i++) {
        const lt_status st = synth_grasp_sample(ctx, lt_rng_mix(seed, (uint64_t)i), NULL, &grasp);

        if (st)
            return lt_error_prefix(st, "%s", take->prop->name);
        if (take->setting.apart && !synth_grasp_clear(ctx, APART, &grasp))
            continue;
        if (!found)
            *out = grasp;
        found = true;
        if (synth_fits_table(&spec)) {
            *out = grasp;
            return LT_OK;
        }
    }
    return found ? LT_OK : lt_error(LT_ENUMERIC, "%s: no grasp lies on it", take->prop->name);
}

lt_status synth_choose_grasps(lt_arena *arena, const synth_stage_spec *take, synth_grasp *out)
{
    const synth_prop *what = take->prop;
    const uint64_t seed = lt_rng_mix(take->seed, GRASP);
    synth_grasp_ctx *ctx;
    lt_status st = synth_grasp_ctx_new(arena, what->id, &what->mesh, &what->sdf, take->hand, take->subject->beta,
                                       &ctx);

    if (!st && what->mirrored)
        synth_grasp_ctx_mirror(ctx);
    for (int i = 0; !st && i < take->n_grasps; i++)
        st = choose(ctx, take, lt_rng_mix(seed, synth_round_stream(take->stream, i)), &out[i]);
    return st;
}
