/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pictures of persons for networks for whole bodies, with the pose of the synthetic body that is in each.
 *
 *   train/000001.jpg ...        192 x 256
 *   evaluation/000001.jpg ...
 *   train.npz, evaluation.npz   a row for each picture: set.c's table
 *   body.npz                    the synthetic body, as body_file_read reads it
 *   stats.json, manifest.json
 *
 * The first fifth, 1,000 at most, is for evaluation; nobody in it is in another picture. A picture is a function of the
 * seed, of its number, and of how many are for evaluation.
 */
#ifndef SYNTH_BODY_SET_H
#define SYNTH_BODY_SET_H

#include "synth/generate.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { BODY_PICTURES = 10000, BODY_EVALUATION = 1000 };

/**
 * synth_body_set - write the dataset into an empty folder
 *
 *   figures      (*n) of stats.json
 *
 * Errors: LT_EIO, LT_ENOMEM; LT_ESTOPPED when progress said so.
 */
lt_status synth_body_set(const synth_options *options, synth_figure figures[SYNTH_FIGURES], int *n);

#ifdef __cplusplus
}
#endif
#endif
