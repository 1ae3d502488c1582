/* SPDX-License-Identifier: Apache-2.0 */
/*
 * csp_seg: finds objects of any number of classes in an image, with a box and a mask each.
 */
#ifndef MODELS_DETECT_CSP_SEG_H
#define MODELS_DETECT_CSP_SEG_H

#include "models/detect/losses.h"
#include "models/model.h"

enum { DETECT_MAX_OBJECTS = 64, DETECT_OUTPUTS = 3 * DETECT_LEVELS + 1 };

extern const model_class csp_seg_class;

typedef struct {
    int variant, image_size, classes;
    double w_box, w_class, w_sides, w_mask;
} csp_seg_config;

/* csp_seg_config_of - of a model of this class */
const csp_seg_config *csp_seg_config_of(const model *m);

/* csp_seg_output - the name of output i of DETECT_OUTPUTS: boxes of three levels, classes, masks, prototypes */
extern const char *const csp_seg_output[DETECT_OUTPUTS];

/**
 * csp_seg_record - as model_class.record; the loss is multiplied by scale
 *
 * Inputs: "image" (B, 3, S, S) in [0, 1]; for losses "objects" (B, 64, 6) and "masks" (B, 64, words), as
 * detect_assign and detect_mask_loss have them.
 * Outputs, for each level "box8", "box16", "box32" (B, 64, H, W), "class8" .. (B, classes, H, W), "mask8" ..
 * (B, 32, H, W); "prototypes" (B, 32, S / 4, S / 4): vision/detection/detection.h makes boxes and masks of them.
 * Losses: "box", "class", "sides", "mask".
 */
void csp_seg_record(const model *m, bool losses, double scale, model_record *r);

#endif
