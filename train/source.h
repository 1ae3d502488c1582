/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Opens what a run learns from: the hand, the training samples and those that validation looks at.
 */
#ifndef TRAIN_SOURCE_H
#define TRAIN_SOURCE_H

#include "assets/hands.h"
#include "data/hand_object.h"
#include "train/config.h"

typedef struct {
    hands hands;                    /* of the files, or embedded; hand is the right one */
    const lt_hand_model *hand;
    const lt_hand_layer *layer;
    dataset *train, *evaluation;    /* evaluation: NULL when validation takes the end of training */
    hand_object_feed train_feed, check_feed;
    int64_t train_count;            /* samples 0 .. train_count - 1 are trained on */
    int64_t check_first, check_count;   /* samples of check_feed that are validated on; none: 0 */
    double tips_rms_mm;             /* how far the hand's finger tips are from the annotated ones */
} train_source;

/**
 * train_source_open - open hand and data as the configuration says
 *
 *   arena   owns the hand
 *
 * End with train_source_close, also after a failure. Errors: no data folder given; those of dataset_open,
 * dataset_check_tips and hands_open.
 */
lt_status train_source_open(lt_arena *arena, const train_config *c, train_source *out);
void train_source_close(train_source *s);

/* train_source_sizes - the sides of crops and masks, once the model is made */
void train_source_sizes(train_source *s, const model *m);

/* train_source_loader, train_source_checker - what a loader needs for the two sets of samples; s must
 * outlive it */
loader_source train_source_loader(const train_source *s);
loader_source train_source_checker(const train_source *s);

#endif
