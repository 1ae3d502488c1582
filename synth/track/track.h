/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Films for trackers: 14 halls in which persons walk, 6 tables over which hands and objects move, as MOTChallenge has
 * them, a folder for each class:
 *
 *   train/hall-01_person/img1/000001.jpg, gt/, det/, seqinfo.ini, times.csv      (synth/write/mot.h)
 *   train/table-01_hand/, train/table-01_object/           the second's imDir is the first's
 *   evaluation/...
 *   identities.csv, stats.json, manifest.json
 *
 * Ids are of the whole dataset. 32 persons are there to train on, 10 others in the evaluation; objects of the
 * evaluation are none of the training's.
 */
#ifndef SYNTH_TRACK_TRACK_H
#define SYNTH_TRACK_TRACK_H

#include "synth/generate.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { TRACK_FRAMES = 300, TRACK_FIGURES = 9 };

/**
 * synth_track - write the dataset into an empty folder
 *
 *   figures      (*n) of stats.json
 *
 * Errors: LT_EINVAL for frames that give a film less than one or more than 3,000; LT_ENUMERIC where a figure of films
 * of full length is outside its range: the folder is then without a manifest; LT_EIO, LT_ENOMEM; LT_ESTOPPED when
 * progress said so.
 */
lt_status synth_track(const synth_options *options, synth_figure figures[SYNTH_FIGURES], int *n);

#ifdef __cplusplus
}
#endif
#endif
