/* SPDX-License-Identifier: Apache-2.0 */
/*
 * HOLD's protocol for objects, on data in HO3D's layout: which frames of each sequence are scored, and the mean of
 * sequences that they come to.                                                                        [HOGS, Table 3]
 */
#ifndef TASKS_HOGS_RESULTS_HOLD_H
#define TASKS_HOGS_RESULTS_HOLD_H

#include "tasks/hogs/results/evaluate.h"

/* hogs_same_sequence - of two frames' names, "SYN0MB00/0012" */
bool hogs_same_sequence(const char *a, const char *b);

/* hogs_hold_choose - e's sequences and frames that are held; none in other layouts, or without surfaces. LT_ENOMEM. */
lt_status hogs_hold_choose(hogs_evaluation *e);

/* hogs_hold_average - the model's means of what HOLD scores: a sequence's counts as much as another's */
void hogs_hold_average(hogs_evaluation *e);

#endif
