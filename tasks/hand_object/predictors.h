/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Predictors that look at no image: what a model must beat. Their rows stand beside a model's.
 *
 * Camera axes (x right, y down, z forward), metres, joints in simple order.
 */
#ifndef TASKS_HAND_OBJECT_PREDICTORS_H
#define TASKS_HAND_OBJECT_PREDICTORS_H

#include "libtensor/base/status.h"
#include "libtensor/geometry/hand/model.h"
#include "libtensor/geometry/pose.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { PREDICTOR_OBJECTS = 32 };

/* Labels of a training set. Objects are numbers below PREDICTOR_OBJECTS. */
typedef struct {
    int64_t n;
    const float *joints;            /* (n, 21, 3) camera */
    const float *rotation;          /* (n, 16, 3, 3) of the hand layer, the wrist's first */
    const float *beta;              /* (n, 10) */
    const int32_t *object;          /* (n) which one, -1 for none; NULL when the set has no objects */
    const float *R, *t;             /* (n, 3, 3), (n, 3) of the object in the camera; NULL likewise */
} predictor_labels;

/* The mean of a training set. Everything is relative to the wrist. */
typedef struct {
    float joints[LT_HAND_KEYPOINTS][3];         /* the hand model at mean rotations and mean shape */
    float vertices[LT_HAND_VERTICES][3];
    struct {
        int64_t n;                              /* training samples of the object */
        lt_pose pose;                         /* mean rotation, and mean place from the wrist */
    } object[PREDICTOR_OBJECTS];
} mean_predictor;

/**
 * mean_predictor_fit - the means of labels
 *
 * Rotations are averaged as matrices and brought to the nearest rotation (the chordal mean).
 *
 *   model    the hand whose mesh is posed
 *   tips     five of its vertices, as in lt_hand_keypoints
 *   out      the caller's
 *
 * Sums run in the order of the samples. Errors: LT_EINVAL: no samples, a label that is not
 * finite, an object that is no number below PREDICTOR_OBJECTS; the line names the sample.
 */
lt_status mean_predictor_fit(const predictor_labels *labels, const lt_hand_model *model, const int tips[5],
                             mean_predictor *out);

/* mean_predictor_hand - joints (21, 3) and vertices (778, 3) for a sample with this wrist */
void mean_predictor_hand(const mean_predictor *m, const float wrist[3], float *joints,
                         float *vertices);

/* mean_predictor_object - the object's pose for a sample with this wrist; that of the zero
 * predictor for an object that was not in training */
lt_pose mean_predictor_object(const mean_predictor *m, int object, const float wrist[3]);

/* zero_predictor_hand - all zeros, the sample submission of the HO3D challenge */
void zero_predictor_hand(float *joints, float *vertices);

/* zero_predictor_object - R = I, t = (0, 0, 1): what Semi-Hand-Object gives where PnP finds no
 * pose */
lt_pose zero_predictor_object(void);

#ifdef __cplusplus
}
#endif
#endif
