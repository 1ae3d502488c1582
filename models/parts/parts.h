/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Parts of models as models of their own: to measure beside other programs, and to see what a file of published weights
 * has for them.
 */
#ifndef MODELS_PARTS_PARTS_H
#define MODELS_PARTS_PARTS_H

#include "models/model.h"

extern const model_class vit_class, lpips_class;

#endif
