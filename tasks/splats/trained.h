/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A trained scene at work: its views drawn one at a time.
 */
#ifndef TASKS_SPLATS_TRAINED_H
#define TASKS_SPLATS_TRAINED_H

#include "estimate/compiled.h"
#include "tasks/splats/run.h"

typedef struct {
    task_run run;
    model m;
    lt_params *params;
    const splats_source *views;     /* held out, or all that there are where none is */
    compiled drawing;
} splats_trained;

/* splats_trained_load - the Gaussians alone; splats_trained_open - and the views of the configuration's folder. split:
 * "train" for those that were learnt from. splats_trained_close follows either, also a failed one. Errors: those of
 * checkpoints and splats_open_views; a picture that is larger than the run's. */
lt_status splats_trained_load(lt_arena *arena, train_config *config, const char *checkpoint, splats_trained *o);
lt_status splats_trained_open(lt_arena *arena, train_config *config, const char *checkpoint, const char *split,
                              splats_trained *o);
void splats_trained_close(splats_trained *o);

/* splats_trained_draw - a view of the folder, with all harmonics; splats_trained_picture - it as bytes, RGB, into an
 * image whose rows are `row` bytes long */
void splats_trained_draw(const splats_trained *o, int view);
void splats_trained_picture(const splats_trained *o, int view, int64_t row, uint8_t *out);

#endif
