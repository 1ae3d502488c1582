/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The losses of a detector's maps, with what its cells are assigned (assign.h).
 *
 * Each loss is a sum over the batch divided by what is counted over the batch, never below 1. A batch is all the parts
 * that run together (lt_compile_opts.parts), each of which returns as many times its share as there are parts, so that
 * the mean over the parts is the batch's.
 */
#ifndef MODELS_DETECT_LOSSES_H
#define MODELS_DETECT_LOSSES_H

#include "models/detect/assign.h"

/**
 * detect_class_loss - binary cross-entropy of all cells and classes with the assigned scores
 *
 * Divided by the sum of these scores.
 */
lt_tensor *detect_class_loss(const detect_maps *maps, lt_tensor *objects, lt_tensor *assigned);

/**
 * detect_box_loss - 1 - CIoU; lt_result(.., 1): cross-entropy of each side with its two nearest bins, the mean of the
 * four sides; both weighed by the assigned score, and divided by the sum of these
 *
 * alpha of the CIoU is what was assigned, and constant.
 * Source: Li et al. 2020, "Generalized focal loss", section 3.2, of the distribution of a side.
 */
lt_tensor *detect_box_loss(const detect_maps *maps, lt_tensor *objects, lt_tensor *assigned);

/**
 * detect_mask_loss - binary cross-entropy inside the object's box, the mean of its pixels
 *
 *   masks     (B, G, words) LT_I32: pixel p of the prototypes' h x w is bit p % 32 of word p / 32
 *
 * The mean over the cells that find an object whose mask is known. A logit is the cell's coefficients times the
 * prototypes. "Mean of its pixels": their sum over the box's area, in pixels of the prototypes.
 * Source: Bolya et al. 2019, "YOLACT", section 3.1.
 */
lt_tensor *detect_mask_loss(const detect_maps *maps, lt_tensor *objects, lt_tensor *masks, lt_tensor *assigned);

#define detect_class_loss(...) LT_HERE(detect_class_loss(__VA_ARGS__))
#define detect_box_loss(...) LT_HERE(detect_box_loss(__VA_ARGS__))
#define detect_mask_loss(...) LT_HERE(detect_mask_loss(__VA_ARGS__))

#endif
