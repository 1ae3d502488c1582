/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A contact sheet of a scored split: what is true beside what the model sees.
 */
#ifndef TASKS_HAND_OBJECT_PICTURES_H
#define TASKS_HAND_OBJECT_PICTURES_H

#include "tasks/hand_object/evaluate.h"

/**
 * evaluate_pictures - draw n samples, spread evenly over o's split, as one PNG
 *
 * Of o the model, the data and the hand are used. Errors: those of reading samples, and of predict_sheet.
 */
lt_status evaluate_pictures(const evaluate_options *o, int n, const char *path);

#endif
