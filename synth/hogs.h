/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a dataset for HOGS has besides frames: the light of each frame, and poses to begin from. Light is in
 * SPLIT/SEQUENCE/light.csv; poses in poses/truth.json, independent.json and correlated.json (docs/formats.md).
 *
 * Initial poses are the truth and noise as large as HOISDF's errors (data/poses/pose_noise.h).
 */
#ifndef SYNTH_HOGS_H
#define SYNTH_HOGS_H

#include "synth/stats.h"
#include "synth/write/growing.h"
#include "synth/write/layout.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SYNTH_POSE_FILES = 3 };          /* one for each pose_noise_kind */

/* The sum of n things that are measured. */
typedef struct { double sum; int64_t n; } synth_mean;

typedef struct {
    synth_growing light, poses[SYNTH_POSE_FILES];
    double part[2];                     /* of the change of pixels: global, local */
    synth_mean both, inside, contact;   /* frames that show hand and object; with the hand in it; touching it */
    synth_mean centre_mm, corners_mm;   /* errors of independent poses */
} synth_hogs;

/* What one frame adds. */
typedef struct {
    const synth_shot *shot;
    const synth_visibility *seen;
    const double *part;                 /* (2) synth_stage_light_parts */
} synth_hogs_frame;

/* synth_hogs_open - begin; synth_hogs_fini frees h in any case. LT_ENOMEM. */
lt_status synth_hogs_open(synth_hogs *h);
void synth_hogs_fini(synth_hogs *h);

/* synth_hogs_record - a frame, in the frames' order, after it was written; the last of its sequence writes light.csv */
lt_status synth_hogs_record(synth_hogs *h, synth_session *s, const synth_hogs_frame *f);

/* synth_hogs_close - write the poses, and add what was measured to the figures */
lt_status synth_hogs_close(synth_hogs *h, synth_session *s, synth_stats *stats);

#ifdef __cplusplus
}
#endif
#endif
