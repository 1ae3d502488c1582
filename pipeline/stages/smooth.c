/* SPDX-License-Identifier: Apache-2.0 */
/* smooth: a film's hands and objects go to where their filters have them. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

static lt_status run(void *state, predict_frame *f)
{
    (void)state;
    return f->film ? predict_follow(f->film, f->arena, f->view, f->result, f->n) : LT_OK;
}

static void miss(void *state, predict_frame *f)
{
    (void)state;
    if (f->film)
        predict_follow_missed(f->film);
}

const stage smooth_stage = {
    .name = "smooth", .needs = FRAME_VIEWS | FRAME_POSES, .gives = FRAME_POSES, .run = run, .miss = miss,
};
