/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Classifiers whose speed other programs publish: a backbone, the mean over the map, one linear layer.
 */
#ifndef MODELS_CLASSIFIERS_CLASSIFIER_H
#define MODELS_CLASSIFIERS_CLASSIFIER_H

#include "libtensor/nn/layers.h"
#include "models/model.h"

extern const model_class resnet50_class, efficientnet_b0_class, pointnet2_class;

/* classifier_variants - there is one: "full" */
extern const char *const classifier_variants[];

/* classifier_image - the input "image" (B, 3, size, size) */
lt_tensor *classifier_image(model_record *r, int size);

/*
 * classifier_record - features (B, C, h, w) to the output "logits"; with losses "loss", the mean squared
 * distance to the input "target" (1 for the class, 0 elsewhere)                [Hui and Belkin 2021]
 */
void classifier_record(const lt_linear_layer *fc, double dropout, lt_tensor *features, bool losses,
                       model_record *r);

#endif
