/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Results of a tracker on a sequence of MOTChallenge, counted by the challenge's rules.
 *
 * Source: JonathonLuiten/TrackEval, trackeval/datasets/mot_challenge_2d_box.py.
 */
#ifndef EVAL_SCORERS_MOT_H
#define EVAL_SCORERS_MOT_H

#include "data/mot/mot.h"
#include "eval/metrics/track.h"

/**
 * mot_count - what counts for track_scores_of
 *
 *   name             of the sequence: those of MOT20 have rules of their own
 *   looks            who is whose twin
 *   truth, results   (frames)
 *
 * Results that belong, at IoU 0.5, to what a tracker may see or not (people on vehicles, static ones, distractors,
 * reflections; in MOT20 vehicles too) count for nothing. Of the truth pedestrians count that are flagged so. Errors:
 * those of track_count.
 */
lt_status mot_count(const char *name, const mot_looks *looks, const mot_frame *truth, const mot_frame *results,
                    int64_t frames, track_counts *out);

#endif
