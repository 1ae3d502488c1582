/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Group "data" of the configuration of a hand-object model.
 */
#ifndef TASKS_HAND_OBJECT_CONFIG_H
#define TASKS_HAND_OBJECT_CONFIG_H

#include "train/config.h"

/* Where samples come from: a dataset's folder, or made while training */
typedef enum { HAND_OBJECT_FOLDER, HAND_OBJECT_STREAM } hand_object_data;

typedef struct {
    train_data_config common;
    int kind;                       /* hand_object_data */
    int pictures, shrink;           /* of a stream: how many, and 640 x 480 over what */
    double near;                    /* of a stream: share of hands from near by */
    int keep_mb;                    /* of a stream: memory for pictures of earlier epochs */
    const char *objects;            /* folder of the object models; "": in the dataset's, or beside it */
    const char *hand;               /* hand model file; "": the embedded hand */
    const char *hand_left;          /* DexYCB: left hand model file; "": the right one's mirror image */
    int setup, filter;              /* DexYCB: hand_object_setup, hand_object_filter */
    bool augment, bilinear;
    double contact_mm;              /* train where the hand comes this close to the object; 0: everywhere */
    double centre_jitter, scale_jitter, rotation_deg, rotation_chance;
    double blur, brightness, contrast, saturation, hue;
    double background;              /* chance of another background */
} hand_object_config;

extern const lt_config_key hand_object_keys[];

/* hand_object_config_of - of a configuration of this task */
const hand_object_config *hand_object_config_of(const train_config *c);

/* hand_object_setup, hand_object_filter - as dataset_open takes them */
const char *hand_object_setup(const hand_object_config *d);
const char *hand_object_filter(const hand_object_config *d);

#endif
