/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Opens what a run learns from: hands, frames, the poses they begin with, and which sets there are.
 */
#ifndef TASKS_HOGS_SOURCE_H
#define TASKS_HOGS_SOURCE_H

#include "tasks/hogs/run.h"

/* hogs_open_data - hands, and the splits with their poses; `split` alone where it is not NULL, else what training wants
 * (run->train, run->evaluation). Names of files in the configuration are made whole. */
lt_status hogs_open_data(task_run *r, train_config *c, const char *split);
void hogs_close_data(task_run *r);

/* hogs_source_of - frames of an open split as the run reads them, all of them, for scoring; r->m may be NULL as yet */
hogs_source hogs_source_of(const task_run *r, const dataset *data, const initial_poses *poses);

/* hogs_find_training_sets - of the training frames: subjects and objects, their canonical shapes; frame sizes and
 * numbers of sets into the configuration where it leaves them open */
lt_status hogs_find_training_sets(task_run *r, train_config *c);

/* hogs_open_model - r->m as a checkpoint has it, and what feeding it frames of r->train needs. Parameters in set, which
 * is empty. Errors: those of checkpoint_load_model; a model without a hand or an object. */
lt_status hogs_open_model(task_run *r, const char *checkpoint, lt_params *set);

#endif
