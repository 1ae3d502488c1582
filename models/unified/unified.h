/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The unified estimator: hand mesh and 6D object pose from colour and depth of one crop.
 *
 * Source: Bandi and Thomas 2025, "Action recognition via multi-view perception feature tracking for human-robot
 * interaction", Robotics 14(4), 53, section 3. README.md beside this file says what we decided where the paper
 * is silent.
 */
#ifndef MODELS_UNIFIED_UNIFIED_H
#define MODELS_UNIFIED_UNIFIED_H

#include "models/backbones/efficientnet.h"
#include "models/heads/hand_object.h"
#include "models/unified/encoder.h"
#include "models/unified/fusion.h"
#include "models/unified/hourglass.h"

/* Rows of Table 8, last to first */
typedef enum { UNIFIED_FULL, UNIFIED_NO_CROSS_ATTENTION, UNIFIED_NO_AAF, UNIFIED_NO_DEPTH } unified_variant;

typedef struct {
    int variant;                    /* unified_variant */
    int image_size;                 /* pixels, a multiple of 32; a cell is 8 */
    int width;                      /* channels behind the encoders; their tokens have twice as many */
    int layers, heads, points;      /* of the deformable encoders */
    double dropout, stochastic_depth;
    int stage5_dilation;
    bool aaf_spatial_sigmoid, up3_relu, depth_fit;
    hand_object_weights w;
} unified_config;

typedef struct {
    unified_config config;
    int cells;
    efficientnet rgb, depth;
    adaptive_attention rgb_attention, depth_attention;
    deformable_encoder hand_encoder, object_encoder;
    cross_attention cross;
    unified_hourglass hourglass;
    mesh_encoder mesh;
    mano_regressor mano;
    object_head object;
} unified;

extern const model_class unified_class;

#endif
