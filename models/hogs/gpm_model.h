/* SPDX-License-Identifier: Apache-2.0 */
#ifndef MODELS_HOGS_GPM_MODEL_H
#define MODELS_HOGS_GPM_MODEL_H

#include "models/model.h"

/* gpm_class - G-PM by itself, which nothing trains: for bench */
extern const model_class gpm_class;

#endif
