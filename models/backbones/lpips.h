/* SPDX-License-Identifier: Apache-2.0 */
/*
 * LPIPS: how far two pictures are from each other in the features of AlexNet, weighed by what people find different.
 *
 * Source: Zhang et al. 2018, "The unreasonable effectiveness of deep features as a perceptual metric", section 3,
 * version 0.1; richzhang/PerceptualSimilarity.
 */
#ifndef MODELS_BACKBONES_LPIPS_H
#define MODELS_BACKBONES_LPIPS_H

#include "models/backbones/alexnet.h"

enum { LPIPS_MOST = 4096 };         /* the largest side of an image in pixels; the smallest is AlexNet's */

typedef struct {
    alexnet trunk;
    lt_param *lin[ALEXNET_TAPS];    /* (1, C, 1, 1): what a channel counts */
    lt_real drawn[ALEXNET_TAPS];    /* the first weight of each convolution, as lpips_init drew it */
} lpips;

/* What the values in [0, 1] of the images become first: LPIPS_SYM 2 x - 1, as it was made; LPIPS_RAW01 nothing, as some
 * programs feed it by mistake, for figures beside theirs */
typedef enum { LPIPS_SYM, LPIPS_RAW01 } lpips_range;

/* lpips_new - registers the parameters, frozen; prefix "" gives the published files' own names */
void lpips_new(lpips *m, lt_params *set, const char *prefix);

/* lpips_init - without published weights: the same random trunk for every seed of a run, and all channels alike. What
 * is measured with it is no LPIPS, and stands under the name that lpips_name returns. */
void lpips_init(lpips *m);

/* lpips_is_random - whether any part of the network is still as lpips_init made it;  lpips_name - "lpips" or "lpips
 * (random trunk)" */
bool lpips_is_random(const lpips *m);
const char *lpips_name(const lpips *m);

/**
 * lpips_distance - of each image from the one that it should be: (B)
 *
 *   image, truth   (B, 3, H, W)    red, green and blue in [0, 1]; sides of 31 to 4096 pixels
 *   boxes          (B, 4)          x0 y0 x1 y1 in pixels, ends exclusive, rounded outwards; or NULL: whole images
 *
 * Only what is in the box counts, as if both images were cut there: the convolutions' zeros stand around it, and means
 * are over what it has. A box is data: it may be another one in each run. Of a side below 31 pixels it grows to these,
 * within the image; an empty one, and one that is not finite, is at distance 0. The gradient reaches image.
 *
 * The weights are read where they are: m must outlive the graph's plans, and they get no gradient.
 *
 * Errors: images of different shapes, or smaller or larger; boxes of another shape.
 */
lt_tensor *lpips_distance(const lpips *m, lpips_range range, lt_tensor *image, lt_tensor *truth, lt_tensor *boxes);

#endif
