/* SPDX-License-Identifier: Apache-2.0 */
/* print: the numbers as a line, to whoever waits for them at the other end of a pipe. */
#include "pipeline/internal.h"
#include "pipeline/stages/stages.h"

static lt_status run(void *state, predict_frame *f)
{
    predict_mesh_files *none = lt_arena_array(f->arena, (size_t)f->n, sizeof(*none));

    (void)state;
    return none ? predict_print_json(f, none, f->o->lines) : lt_error(LT_ENOMEM, "%s: no memory", f->view->path);
}

const stage print_stage = {
    .name = "print", .needs = FRAME_VIEWS | FRAME_POSES | FRAME_VERDICT, .run = run,
};
