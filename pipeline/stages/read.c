/* SPDX-License-Identifier: Apache-2.0 */
/* read: a file or a film's frame, upright, with a camera. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

static lt_status run(void *state, predict_frame *f)
{
    (void)state;
    return predict_scene_open(f);
}

/* What cannot be read, and a lens that none can have. */
static bool forgives(lt_status st)
{
    return st == LT_EFORMAT || st == LT_EINVAL || st == LT_EIO;
}

const stage read_stage = { .name = "read", .gives = FRAME_SCENE, .forgives = forgives, .run = run };
