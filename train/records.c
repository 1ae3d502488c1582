/* SPDX-License-Identifier: Apache-2.0 */
#include "train/records.h"

#include <stdlib.h>
#include <string.h>

/* Room for `more` behind n elements; false without memory */
static bool grow(void **array, size_t size, size_t n, size_t more, size_t *room)
{
    const size_t want = n + more > 2 * *room ? n + more : 2 * *room;
    void *longer;

    if (n + more <= *room)
        return true;
    longer = realloc(*array, want * size);
    if (!longer)
        return false;
    *array = longer;
    *room = want;
    return true;
}

lt_status records_add(records *r, int64_t sample, const void *record, size_t bytes)
{
    size_t places = (size_t)r->places;
    void *data = r->data, *place = r->place;
    const bool ok = grow(&data, 1, r->bytes, bytes, &r->room)
        && grow(&place, sizeof(*r->place), (size_t)r->n, 1, &places);

    r->data = data;
    r->place = place;
    r->places = (int64_t)places;
    if (!ok)
        return lt_error(LT_ENOMEM, "no memory for the scores of %lld samples", (long long)r->n + 1);
    memcpy(r->data + r->bytes, record, bytes);
    r->place[r->n++] = (record_place){ sample, r->bytes, bytes };
    r->bytes += bytes;
    return LT_OK;
}

/* By sample, then as they were added: where a record lies in data says when that was. */
static int in_order(const void *a, const void *b)
{
    const record_place *x = a, *y = b;

    if (x->sample != y->sample)
        return x->sample < y->sample ? -1 : 1;
    return x->at < y->at ? -1 : x->at > y->at;
}

void records_sort(records *r)
{
    qsort(r->place, (size_t)r->n, sizeof(*r->place), in_order);
}

const void *records_at(const records *r, int64_t i, size_t *bytes)
{
    if (bytes)
        *bytes = r->place[i].bytes;
    return r->data + r->place[i].at;
}

void records_free(records *r)
{
    free(r->data);
    free(r->place);
    *r = (records){ 0 };
}
