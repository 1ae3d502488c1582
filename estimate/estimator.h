/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A trained model at work: batches in, hands and object poses in camera coordinates out.
 */
#ifndef ESTIMATE_ESTIMATOR_H
#define ESTIMATE_ESTIMATOR_H

#include "data/hand_object.h"
#include "libtensor/geometry/box21.h"
#include "libtensor/geometry/pose.h"
#include "models/model.h"

typedef struct estimator estimator;

/* estimator_new - compiles the model for batches of up to `batch`; the model must outlive it */
lt_status estimator_new(const model *m, int batch, estimator **out);

/* estimator_new_alone - the same where nothing else uses the model's weights, now or later: less memory */
lt_status estimator_new_alone(const model *m, int batch, estimator **out);
void estimator_free(estimator *e);

/* What is seen in one image. Camera axes (x right, y down, z forward), metres, simple order. */
typedef struct {
    float joints[LT_HAND_KEYPOINTS][3], vertices[LT_HAND_VERTICES][3];      /* wrist added */
    float rotation[LT_HAND_JOINTS][9], beta[LT_HAND_BETAS];
    float joints2d[LT_HAND_KEYPOINTS][2];       /* of the heat maps, crop pixels */
    float peak[LT_HAND_KEYPOINTS];              /* their highest cells, in [0, 1] */
    lt_pose object;               /* R = I, t = (0, 0, 1) when no pose was found */
    int object_inliers;             /* 0: no pose was found */
    float object_error_px;          /* of the inliers, mean, in pixels of what the pose was found in (protocol_pose) */
    float object_confidence;        /* the mean over points of the best cell's */
    float control2d[LT_BOX_POINTS][2];          /* where its cells see each point of the object's box, crop pixels;
                                                 * NaN: no cell above 0.5 does */
} estimate;

/**
 * estimator_run - estimate for the samples of a batch
 *
 *   object   (b->count) what each sample's hand holds; a sample without gets no pose, and of a model of hands alone
 *            none does
 *   out      (b->count)
 *
 * The wrist is taken from b->wrist, as the papers' protocols do.
 *
 * Source for the object: HOCAT section 3.4; Semi-Hand-Object utils/metric.py: the ten most confident
 * cells of every control point above 0.5, then EPnP in RANSAC. Bandi and Thomas 2025, section 3: those of a model
 * with POSE_REFINED, in the image, and then refined; of one with depth_fit, laid on the measured depth at last, which
 * no paper has.
 */
void estimator_run(estimator *e, const hand_object_batch *b, const object_shape *object, estimate *out);

#endif
