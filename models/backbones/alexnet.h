/* SPDX-License-Identifier: Apache-2.0 */
/*
 * AlexNet's convolutions on crops of any sizes side by side, with frozen weights; torchvision's parameter names.
 *
 * A map of channels has all crops' positions in each of its rows, crop after crop, so that a layer is one product for
 * all of them. Each crop is as if it were alone: the zeros around it are its own, and nothing is computed that it does
 * not have.
 *
 * Source: Krizhevsky 2014, "One weird trick for parallelizing convolutional neural networks"; torchvision
 * models/alexnet.py.
 */
#ifndef MODELS_BACKBONES_ALEXNET_H
#define MODELS_BACKBONES_ALEXNET_H

#include "libtensor/nn/layers.h"

enum { ALEXNET_TAPS = 5, ALEXNET_LEAST = 31 };      /* a tap behind each convolution's relu; the smallest side in pixels
                                                     * that has a value at each of them */

/* One convolution, behind a 3 x 3 pool with stride 2 where there is one */
typedef struct {
    int c, o, k, stride, pad;
    bool pool;
} alexnet_layer;

extern const alexnet_layer alexnet_layers[ALEXNET_TAPS];

typedef struct {
    lt_conv_layer conv[ALEXNET_TAPS];
} alexnet;

/* alexnet_new - registers the parameters; prefix "" gives torchvision's own names */
void alexnet_new(alexnet *m, lt_params *set, const char *prefix);

/* alexnet_init - He et al.'s draws, without biases: features of some use, though not those of ImageNet */
void alexnet_init(const alexnet *m, uint64_t seed);

/* Where a crop's map is: its sides, and the column of its first position */
typedef struct { int64_t h, w, at; } alexnet_map;

/* A crop's maps before and behind each convolution; sides of 0: there is no crop */
typedef struct { alexnet_map in[ALEXNET_TAPS], out[ALEXNET_TAPS]; } alexnet_crop;

/* n crops, and the columns that all of them have */
typedef struct {
    alexnet_crop *crop;
    int n;
    int64_t in[ALEXNET_TAPS], out[ALEXNET_TAPS];
} alexnet_crops;

/* alexnet_lay_out - all maps of n crops whose sides are in crop[i].in[0] already */
void alexnet_lay_out(alexnet_crops *crops);

/* Numbers that go through the network: in[l] (c, columns) of layer l, tap[l] (o, columns). in[l] is tap[l - 1] where no
 * pool stands between. where[l] are the places of in[l]'s maxima for the first crops; NULL where nobody goes back. */
typedef struct {
    lt_real *in[ALEXNET_TAPS], *tap[ALEXNET_TAPS];
    int32_t *where[ALEXNET_TAPS];
} alexnet_maps;

/* alexnet_columns_count - elements of the scratch that forward and backward take */
int64_t alexnet_columns_count(void);

/* alexnet_forward - in[0] to all taps; work is scratch. Places of maxima are kept for the first `back` crops. */
void alexnet_forward(const alexnet *m, const alexnet_crops *crops, int back, const alexnet_maps *maps, lt_real *work);

/**
 * alexnet_backward - one layer back, for the first n crops
 *
 *   dtap   (o, crops->out[l])   the gradient behind the layer's relu; becomes that before it
 *   din    (c, crops->in[l])    is overwritten with the gradient of in[l] in their columns
 */
void alexnet_backward(const alexnet *m, const alexnet_crops *crops, int n, int l, const lt_real *tap, lt_real *dtap,
                      lt_real *din, lt_real *work);

/* alexnet_pool_backward - dtap of layer l - 1 += what reaches it through the pool from din of layer l */
void alexnet_pool_backward(const alexnet_crops *crops, int n, int l, const int32_t *where, const lt_real *din,
                           lt_real *dtap);

#endif
