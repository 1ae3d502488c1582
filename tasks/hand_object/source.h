/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Opens what a run learns from: the hand, the training samples and those that validation looks at.
 */
#ifndef TASKS_HAND_OBJECT_SOURCE_H
#define TASKS_HAND_OBJECT_SOURCE_H

#include "assets/hands.h"
#include "data/hand_object.h"
#include "tasks/hand_object/config.h"

typedef struct {
    hands hands;                    /* of the files, or embedded; hand is the right one */
    const lt_hand_model *hand;
    const lt_hand_layer *layer;
    dataset *train, *evaluation;    /* evaluation: NULL when validation takes the end of training */
    hand_object_feed train_feed, check_feed;
    int64_t train_count;            /* samples 0 .. train_count - 1 are trained on */
    int64_t check_first, check_count;   /* samples of check_feed that are validated on; none: 0 */
    double tips_rms_mm;             /* how far the hand's finger tips are from the annotated ones */
} run_source;

/**
 * source_open - open hand and data as the configuration says
 *
 *   arena   owns the hand
 *
 * End with source_close, also after a failure. Errors: no data folder given; those of dataset_open,
 * dataset_check_tips and hands_open.
 */
lt_status source_open(lt_arena *arena, const train_config *c, run_source *out);
void source_close(run_source *s);

/* source_sizes - the sides of crops and masks, once the model is made */
void source_sizes(run_source *s, const model *m);

/* source_loader, source_checker - what a loader needs for the two sets of samples; s must
 * outlive it */
loader_source source_loader(const run_source *s);
loader_source source_checker(const run_source *s);

#endif
