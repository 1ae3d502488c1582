/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The mean pose of a dataset's labels.
 */
#ifndef TASKS_HAND_OBJECT_MEAN_LABELS_H
#define TASKS_HAND_OBJECT_MEAN_LABELS_H

#include "data/dataset.h"
#include "tasks/hand_object/predictors.h"

/**
 * mean_labels_fit - mean_predictor_fit on some hundred labels, spread over the split d
 *
 *   hand, tips   as in mean_predictor_fit
 *   found        false: no label has a hand that can be read, and *out is as it was
 *
 * A label that cannot be read, or of a frame without a hand, is passed over. Errors: LT_ENOMEM, mean_predictor_fit's.
 */
lt_status mean_labels_fit(const dataset *d, const lt_hand_model *hand, const int tips[5], mean_predictor *out,
                          bool *found);

#endif
