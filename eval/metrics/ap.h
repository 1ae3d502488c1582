/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Average precision of detections, as COCO counts it.
 *
 * Source: cocodataset/cocoapi, PythonAPI/pycocotools/cocoeval.py: 101 recalls, IoU 0.50 to 0.95, at most 100 of a class
 * in an image, objects outside a range of areas and crowds ignored.
 */
#ifndef EVAL_METRICS_AP_H
#define EVAL_METRICS_AP_H

#include "libtensor/base/status.h"

#include <stdbool.h>
#include <stdint.h>

enum { AP_THRESHOLDS = 10, AP_RECALLS = 101, AP_MOST = 100 };

typedef struct {
    int cls;
    double score, area;
} ap_found;

typedef struct {
    int cls;
    double area;
    bool crowd;
} ap_truth;

typedef struct {
    const ap_found *found;
    const ap_truth *truth;
    int n_found, n_truth;
    const float *iou;               /* (n_found, n_truth); of a crowd the share of what was found that it covers. Only
                                     * pairs of one class are looked at */
} ap_image;

/* Areas from lo to hi */
typedef struct { double lo, hi; } ap_range;

/**
 * ap_measure - the average precision of each class at each threshold 0.50, 0.55 .. 0.95
 *
 *   out      (classes, AP_THRESHOLDS); NaN for a class of which no object counts
 *
 * Where scores are equal, earlier images and findings come first. Errors: LT_ENOMEM.
 */
lt_status ap_measure(const ap_image *image, int64_t n, int classes, ap_range area, double *out);

/* ap_curves - of each class at each threshold the best precision at each of the recalls 0, 0.01 .. 1 and beyond, whose
 * mean is the average precision; out (classes, AP_THRESHOLDS, AP_RECALLS), NaN and errors as ap_measure has them */
lt_status ap_curves(const ap_image *image, int64_t n, int classes, ap_range area, double *out);

/* ap_mean - of classes first .. end - 1 at the first `thresholds` of them, classes without objects left out; NaN: none
 * has any */
double ap_mean(const double *ap, int first, int end, int thresholds);

#endif
