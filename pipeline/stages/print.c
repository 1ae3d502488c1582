/* SPDX-License-Identifier: Apache-2.0 */
/* print: the numbers as a line, to whoever waits for them at the other end of a pipe. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

static lt_status run(void *state, predict_frame *f)
{
    (void)state;
    return predict_print_json(f, f->o->lines);
}

const stage print_stage = { .name = "print", .needs = FRAME_VIEWS | FRAME_VERDICT, .run = run };
