/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the re-identification network is put together of: convolutions with norm and ELU, and residual units that are
 * activated before they convolve.
 *
 * Source: He et al. 2016, "Identity mappings in deep residual networks".
 */
#ifndef MODELS_REID_UNIT_H
#define MODELS_REID_UNIT_H

#include "libtensor/nn/layers.h"

/* reid_norm_new - batch norm; compat: with the eps of TensorFlow's file */
lt_batch_norm_layer reid_norm_new(lt_params *set, const char *prefix, int channels, bool compat);

/* reid_conv_new - 3 x 3 without bias, padded to keep the map's size; compat: strides of 2 pad as TensorFlow does */
typedef struct {
    lt_conv_layer conv;
    lt_batch_norm_layer bn;
    bool compat;
} reid_conv;

reid_conv reid_conv_new(lt_params *set, const char *prefix, int in, int out, int stride, bool compat);
lt_tensor *reid_conv_forward(const reid_conv *m, lt_tensor *x);

/* Norm and ELU but for the first unit, two convolutions, and the map itself added; halved, and through a 1 x 1
 * convolution, where the channels double. */
typedef struct {
    bool first, doubles;
    lt_batch_norm_layer pre;
    reid_conv conv1;
    lt_conv_layer conv2, projection;
    double dropout;
} reid_unit;

reid_unit reid_unit_new(lt_params *set, const char *prefix, int in, int out, bool first, double dropout, bool compat);
lt_tensor *reid_unit_forward(const reid_unit *m, lt_tensor *x);

#endif
