/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From what is known of a picture to what the model's losses compare with (models/body/osx.h, osx_losses.h).
 */
#ifndef TASKS_BODY_TARGET_H
#define TASKS_BODY_TARGET_H

#include "tasks/body/batch.h"
#include "vision/person_window.h"

/* body_target_make - of the row's picture as w changes it */
void body_target_make(const body_row *row, const person_window *w, body_target *out);

#endif
