/* SPDX-License-Identifier: Apache-2.0 */
#include "models/backbones/imagenet.h"

const double imagenet_mean[3] = { 0.485, 0.456, 0.406 }, imagenet_deviation[3] = { 0.229, 0.224, 0.225 };

lt_tensor *image_normalise(lt_tensor *image, const double mean[3], const double deviation[3])
{
    lt_real scale[3], shift[3];

    for (int i = 0; i < 3; i++) {
        scale[i] = (lt_real)(1 / deviation[i]);
        shift[i] = (lt_real)(-mean[i] / deviation[i]);
    }
    return lt_channel_affine(image, lt_constant(image->graph, LT_F32, LT_SHAPE(3), scale),
                             lt_constant(image->graph, LT_F32, LT_SHAPE(3), shift));
}

lt_tensor *imagenet_normalise(lt_tensor *image)
{
    return image_normalise(image, imagenet_mean, imagenet_deviation);
}
