/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Clips of ten actions on true skeletons, as data/action reads them: 10 subjects repeat each action 20 times, 60 to 90
 * frames at 30 a second.
 *
 *   body.npy, hand_object.npy, valid.npy, label.json      (data/action/action.h)
 *   stats.json, manifest.json
 *
 * One number, the difficulty, says how much joints are off, how often the object is missed, and how late reaching and
 * receiving part; at 0 they part at once, and nothing is off. The figures of stats.json tell how many of the last
 * subject's windows are right by the baseline (eval/metrics/speed_histogram.h), which has learnt from the others: where
 * that is 70 % stands SYNTH_DIFFICULTY (synth/generate.h).
 */
#ifndef SYNTH_ACTIONS_ACTIONS_H
#define SYNTH_ACTIONS_ACTIONS_H

#include "synth/generate.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { ACTIONS_SUBJECTS = 10, ACTIONS_REPETITIONS = 20, ACTIONS_FIGURES = 3 };

/**
 * synth_actions - write the clips into an empty folder
 *
 *   figures      (*n) of stats.json
 *
 * Errors: LT_EINVAL for a number of clips that is not 100 for each repetition, or more than 100,000; LT_EIO, LT_ENOMEM;
 * LT_ESTOPPED when progress said so.
 */
lt_status synth_actions(const synth_options *options, synth_figure figures[SYNTH_FIGURES], int *n);

#ifdef __cplusplus
}
#endif
#endif
