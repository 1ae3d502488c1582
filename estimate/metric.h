/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is measured, under one name everywhere: in logs, tables, claims and `palmar eval --require`.
 */
#ifndef ESTIMATE_METRIC_H
#define ESTIMATE_METRIC_H

#include <stdbool.h>

typedef struct {
    const char *key;                /* "pa_mpjpe_mm" */
    const char *name, *unit;        /* "PA-MPJPE", "mm" */
    bool higher;                    /* is better */
    const char *meaning, *source;
} metric;

/* metric_find - by key; NULL: there is none of that name */
const metric *metric_find(const char *key);

/* metric_at - the dictionary, in its order; NULL behind its end */
const metric *metric_at(int i);

/* metric_better - whether a is better than b; what is not a number is better than nothing */
bool metric_better(const metric *m, double a, double b);

#endif
