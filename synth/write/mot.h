/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes a sequence as MOTChallenge has it: SEQUENCE/gt/gt.txt, det/det.txt, seqinfo.ini; besides gt/masks.txt, as MOTS
 * has masks, and times.csv. Frames, ids and the corners of boxes count from 1.
 */
#ifndef SYNTH_WRITE_MOT_H
#define SYNTH_WRITE_MOT_H

#include "synth/world/seen.h"
#include "synth/write/growing.h"
#include "synth/write/manifest.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    const char *split;
    char name[40];
    synth_growing gt, det, masks;
} synth_mot;

/* One thing in one frame. */
typedef struct {
    int id;
    synth_pixels box;               /* hidden parts included */
    double visible;                 /* share */
    const char *counts;             /* lt_rle_encode of what is seen */
} synth_mot_truth;

/* Pixels, x1 and y1 past the last. */
typedef struct { double x0, y0, x1, y1, score; } synth_mot_detection;

/* synth_mot_open - begin a sequence; synth_mot_fini frees m in any case. LT_ENOMEM. */
lt_status synth_mot_open(synth_mot *m, const char *split, const char *name);
void synth_mot_fini(synth_mot *m);

/* synth_mot_add_truth, synth_mot_add_detection - of frame k, from 0; what is less than a tenth visible is not scored,
 * and has no mask */
void synth_mot_add_truth(synth_mot *m, int k, const synth_mot_truth *t, int width, int height);
void synth_mot_add_detection(synth_mot *m, int k, const synth_mot_detection *d);

/**
 * synth_mot_close - write the sequence's files under root, whose folders are made here
 *
 *   images       the folder of its pictures, from the sequence's: "img1"
 *   time         (frames) seconds
 */
lt_status synth_mot_close(synth_mot *m, const char *root, const char *images, const double *time, int frames, int width,
                          int height, synth_manifest *manifest);

#ifdef __cplusplus
}
#endif
#endif
