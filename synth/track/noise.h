/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Detections as a detector would give them: truth with misses, false boxes and corners that are off. So trackers are
 * compared without a detector, and never on the truth.
 */
#ifndef SYNTH_TRACK_NOISE_H
#define SYNTH_TRACK_NOISE_H

#include "libtensor/base/rng.h"
#include "synth/write/mot.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What came of it. */
typedef struct {
    int64_t boxes, missed, false_boxes;         /* boxes: that might be detected */
    double corners;                             /* sum of squares of what a coordinate is off, as a share of the side */
    int64_t n_corners;
} track_noise;

/**
 * track_detect - the detections of a frame, best first
 *
 *   truth    (n) what is less than a tenth visible is never detected
 *   out      room for 2 n
 *
 * 8 % are missed; there are 3 % as many false boxes as true ones, anywhere, and each of a box's corners is off by 3 %
 * of its sides (deviation). Scores are 0.2 + 0.75 times the visible share, and noise; of false boxes, 0.1 to 0.7.
 * Returns how many.
 */
int track_detect(lt_rng *r, const synth_mot_truth *truth, int n, int width, int height, synth_mot_detection *out,
                 track_noise *noise);

#ifdef __cplusplus
}
#endif
#endif
