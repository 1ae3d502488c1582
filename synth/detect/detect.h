/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Single pictures for detectors: persons, hands and the 21 objects, with boxes and masks of what is seen of them, as
 * COCO has them.
 *
 *   train/000001.jpg ...        320 x 320
 *   evaluation/000001.jpg ...
 *   annotations/instances_train.json, instances_evaluation.json
 *   stats.json, manifest.json
 *
 * Picture i is a function of the seed and i. The first fifth, 1,000 at most, is for evaluation; all pictures of seed
 * DETECT_EVALUATION_SEED are, whose first 1,000 are the set on which detectors are compared.
 */
#ifndef SYNTH_DETECT_DETECT_H
#define SYNTH_DETECT_DETECT_H

#include "synth/generate.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { DETECT_PICTURES = 5000, DETECT_EVALUATION = 1000, DETECT_EVALUATION_SEED = 1000 };

/* synth_detect_evaluation - how many of so many pictures are for evaluation */
int64_t synth_detect_evaluation(uint64_t seed, int64_t pictures);

/**
 * synth_detect - write the dataset into an empty folder
 *
 *   figures      (*n) of stats.json
 *
 * Errors: LT_ENUMERIC where a figure of DETECT_EVALUATION pictures or more is outside its range: the folder is then
 * without a manifest; LT_EIO, LT_ENOMEM; LT_ESTOPPED when progress said so.
 */
lt_status synth_detect(const synth_options *options, synth_figure figures[SYNTH_FIGURES], int *n);

#ifdef __cplusplus
}
#endif
#endif
