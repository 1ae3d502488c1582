/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How often windows are told right.
 */
#ifndef TASKS_ACTION_SCORES_H
#define TASKS_ACTION_SCORES_H

#include "data/action/action.h"

#include <stdio.h>

struct cJSON;

typedef struct {
    int64_t n[ACTION_CLASSES][ACTION_CLASSES];      /* windows by their class and what they are taken for */
} action_confusion;

void action_confusion_add(action_confusion *c, int cls, int found);
double action_accuracy(const action_confusion *c);              /* NaN without windows */
double action_recall(const action_confusion *c, int cls);
double action_object_recall(const action_confusion *c);         /* mean over the classes that have an object */

/* action_share_3_as_7 - of all errors those that take reaching, the paper's class 3, for receiving, its class 7; 0
 * without errors */
double action_share_3_as_7(const action_confusion *c);

typedef struct {
    action_confusion both, body_only, hand_object_only;
    double baseline;                /* of speeds (eval/metrics/speed_histogram.h); NaN: not measured */
    const char *split;              /* "subject", "random" */
    bool synthetic;
    double difficulty;              /* NaN: not told */
} action_scores;

/* action_score_keys - accuracy, accuracy_body_only, accuracy_stream2_only, object_recall, object_recall_body_only,
 * share_3_as_7; ends with NULL */
extern const char *const action_score_keys[];

/* action_scores_json - for cJSON_Delete, NULL without memory. action_scores_print - tables in text.
 * action_scores_page - the same in Markdown, table.md in a folder, for palmar report */
struct cJSON *action_scores_json(const action_scores *s);
void action_scores_print(const action_scores *s, FILE *f);
lt_status action_scores_page(const action_scores *s, const char *folder);

#endif
