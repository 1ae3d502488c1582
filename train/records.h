/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is kept of each sample that is scored, of any length: scores such as average precision are no means of batches.
 */
#ifndef TRAIN_RECORDS_H
#define TRAIN_RECORDS_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

typedef struct {
    int64_t sample;
    size_t at, bytes;               /* in data */
} record_place;

typedef struct {
    uint8_t *data;
    size_t bytes, room;
    record_place *place;
    int64_t n, places;
} records;

/* records_add - a copy; several of one sample stay in their order. LT_ENOMEM */
lt_status records_add(records *r, int64_t sample, const void *record, size_t bytes);

/* records_sort - by sample, whoever added them in which order */
void records_sort(records *r);

/* records_at - the i-th record, as it was added, anywhere in memory: copy it out */
const void *records_at(const records *r, int64_t i, size_t *bytes);

void records_free(records *r);

#endif
