/* SPDX-License-Identifier: Apache-2.0 */
/* How ImageNet's networks want their pictures: each channel minus its mean, over its deviation. */
#ifndef MODELS_BACKBONES_IMAGENET_H
#define MODELS_BACKBONES_IMAGENET_H

#include "libtensor/ops/ops.h"

/* imagenet_mean, imagenet_deviation - of its images in [0, 1], by which torchvision's weights have them */
extern const double imagenet_mean[3], imagenet_deviation[3];

/* image_normalise - image (B, 3, H, W), each channel minus its mean, over its deviation */
lt_tensor *image_normalise(lt_tensor *image, const double mean[3], const double deviation[3]);

/* imagenet_normalise - image (B, 3, H, W) in [0, 1] */
lt_tensor *imagenet_normalise(lt_tensor *image);

#endif
