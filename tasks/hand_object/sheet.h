/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Contact sheets: samples of a dataset, the truth beside the prediction, in one PNG.
 */
#ifndef TASKS_HAND_OBJECT_SHEET_H
#define TASKS_HAND_OBJECT_SHEET_H

#include "data/dataset.h"
#include "estimate/estimator.h"

/* One sample; everything is borrowed. Truth that the sample does not hold (its flags) is not drawn. */
typedef struct {
    const dataset_sample *sample;
    const dataset_object *object;   /* the sample's; NULL: without object */
    const float (*vertices)[3];     /* true hand (778, 3); NULL: sample->vertices, if it has them */
    const estimate *estimate;       /* in the sample's camera, the wrist added */
    const char *title;              /* ASCII, for instance its errors; NULL: the sample's name */
} sheet_item;

/**
 * predict_sheet - write n samples, each as two pictures: true, and predicted
 *
 *   faces     (1538, 3) of the hand model; NULL draws skeletons only
 *
 * Pictures show the window around hand and object that the network looks at. Errors: LT_EINVAL for
 * n < 1 or more samples than a sheet holds, LT_ENOMEM, and those of lt_png_write.
 */
lt_status predict_sheet(const char *path, const sheet_item *item, int n, const int32_t (*faces)[3]);

#endif
