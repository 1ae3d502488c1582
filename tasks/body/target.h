/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From what is known of a picture to what the model's losses compare with (models/body/osx.h, osx_losses.h).
 */
#ifndef TASKS_BODY_TARGET_H
#define TASKS_BODY_TARGET_H

#include "tasks/body/batch.h"

/* Where a picture goes: pixel scale u + shift */
typedef struct { double scale, shift[2]; } body_window;

void body_target_make(const body_row *row, const body_window *w, body_target *out);

#endif
