/* SPDX-License-Identifier: Apache-2.0 */
/*
 * HOCAT: hand mesh and 6D object pose from one image, with a decoupled feature pyramid and hand-object
 * cross-attention.
 *
 * Source: Cai, Pan, Yang, Liu, Gao, Wang 2025, "Geometry-aware 3D hand-object pose estimation under
 * occlusion via hierarchical feature decoupling", Electronics 14(5), 1029. README.md beside this file
 * says what we decided where the paper is silent.
 */
#ifndef MODELS_HOCAT_HOCAT_H
#define MODELS_HOCAT_HOCAT_H

#include "models/backbones/resnet.h"
#include "models/heads/hand_object.h"
#include "models/hocat/attention.h"
#include "models/hocat/fpn.h"
#include "models/model.h"

typedef enum { HOCAT_FULL, HOCAT_DUAL, HOCAT_BASE } hocat_variant;     /* rows of Table 5, last to first */
typedef enum { HOCAT_HFL_INIT, HOCAT_DEFAULT_INIT } hocat_init;
typedef enum { HOCAT_C2, HOCAT_C5UP } hocat_base_feat;

typedef struct {
    int variant;                    /* hocat_variant */
    int image_size;                 /* pixels; a multiple of 32 */
    int width;                      /* planes of the first stage; features have 4 width channels */
    int blocks[RESNET_STAGES];
    int roi;                        /* side of the pooled features; a power of two */
    int depth, heads, mlp_ratio;    /* of the cross-attention */
    bool fused;                     /* HFL-Net's one block over both features in its place */
    int base_feat;                  /* hocat_base_feat */
    int se_place;                   /* hocat_se_place */
    bool detach_minor;              /* the object's minor features are constant to the hand's loss */
    bool identity_pose;             /* start from the flat hand */
    int head_init;                  /* hocat_init */
    bool imagenet_norm;             /* subtract mean and divide by deviation of ImageNet first */
    bool depth_fit;                 /* the object's pose is laid on the depth, which the network does not see */
    hand_object_weights w;
} hocat_config;

typedef struct {
    hocat_config config;
    resnet trunk;
    lt_conv_layer c5up;
    hocat_fpn hand_fpn, object_fpn;
    hocat_attention attention;
    heatmap_head hand_head;
    fusion_encoder encoder;
    mano_regressor mano;
    object_head object;
} hocat;

extern const model_class hocat_class;

#endif
