/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How well things were followed: HOTA with its detection and association accuracy, MOTA and switches, IDF1.
 *
 * Source: Luiten et al. 2021, "HOTA: a higher order metric for evaluating multi-object tracking"; Bernardin and
 * Stiefelhagen 2008, "Evaluating multiple object tracking performance: the CLEAR MOT metrics"; Ristani et al. 2016,
 * "Performance measures and a data set for multi-target, multi-camera tracking". Matching is TrackEval's
 * (JonathonLuiten/TrackEval, trackeval/metrics).
 */
#ifndef EVAL_METRICS_TRACK_H
#define EVAL_METRICS_TRACK_H

#include "libtensor/base/status.h"

enum { TRACK_ALPHAS = 19 };

typedef struct {
    int64_t id;                     /* any, but each once in a frame */
    int64_t look;                   /* of the truth: what twins share; any */
    double box[4];                  /* x0 y0 x1 y1, edges */
} track_scored;

typedef struct {
    const track_scored *truth, *found;
    int n_truth, n_found;
} track_scored_frame;

/* track_iou - of two boxes; 0 where one has no area */
double track_iou(const double a[4], const double b[4]);

/* What is counted; counts of sequences add up. */
typedef struct {
    double tp[TRACK_ALPHAS], fn[TRACK_ALPHAS], fp[TRACK_ALPHAS];        /* HOTA's, at IoU 0.05, 0.10 .. 0.95 */
    double associated[TRACK_ALPHAS];            /* sum over its tp of the association's Jaccard index */
    double clear_tp, clear_fn, clear_fp, switches;      /* CLEAR's, at IoU 0.5 */
    double taken;                   /* ids that went from somebody to another of another look, in CLEAR's pairs */
    double id_tp, id_fn, id_fp;                 /* of one pairing of identities for the sequence, at IoU 0.5 */
} track_counts;

enum { TRACK_COUNTS = sizeof(track_counts) / sizeof(double) };

typedef struct { double hota, deta, assa, mota, idf1, switches, taken; } track_scores;

/**
 * track_count - the counts of one sequence
 *
 *   frame    (n) in their order, those too in which nothing is or nothing was found
 *
 * Errors: LT_EINVAL for an id twice in a frame, a box that is not finite, and so many identities that their pairs are
 * above 2^26; LT_ENOMEM.
 */
lt_status track_count(const track_scored_frame *frame, int64_t n, track_counts *out);

/* track_counts_add - the counts of one more sequence */
void track_counts_add(track_counts *sum, const track_counts *more);

/* track_scores_of - shares, and how many switches. HOTA, DetA and AssA are means over the 19 thresholds; without truth
 * shares are 0, but for MOTA, which then counts what was found against nothing. */
track_scores track_scores_of(const track_counts *c);

#endif
