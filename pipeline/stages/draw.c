/* SPDX-License-Identifier: Apache-2.0 */
/* draw: the meshes of the hands, and the picture with everything that was found. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

static lt_status run(void *state, predict_frame *f)
{
    lt_status st = LT_OK;

    (void)state;
    f->hand = lt_arena_array(f->arena, (size_t)f->n, sizeof(*f->hand));
    if (!f->hand)
        return lt_error(LT_ENOMEM, "%s: no memory", f->scene.path);
    for (int i = 0; i < f->n && !st && (f->has & FRAME_POSES); i++)
        st = predict_hand_mesh(f, i, &f->hand[i]);
    return st ? st : predict_draw_overlay(f, &f->overlay);
}

const stage draw_stage = {
    .name = "draw", .needs = FRAME_VIEWS, .gives = FRAME_DRAWING, .run = run,
};
