/* SPDX-License-Identifier: Apache-2.0 */
/* Internal: what is kept of an image that is scored. */
#ifndef TASKS_DETECT_KEPT_H
#define TASKS_DETECT_KEPT_H

#include "data/detection/detection.h"
#include "train/records.h"

/* A record is a head, n_found findings, n_truth objects, and twice n_found * n_truth overlaps: of boxes, of masks. */
typedef struct { int32_t n_found, n_truth; } kept_head;
typedef struct { int32_t cls; float score, box_area, mask_area, box[4]; } kept_found;
typedef struct { int32_t cls; float area, box[4]; int32_t crowd; } kept_truth;

typedef struct {
    kept_head head;
    kept_found *found;
    kept_truth *truth;
    float *box_iou;                 /* (n_found, n_truth); of a crowd the share of what was found that it covers */
    float *mask_iou;                /* likewise, of pairs of one class */
} kept;

/* kept_read - the i-th record, in the arena. LT_ENOMEM */
lt_status kept_read(lt_arena *arena, const records *all, int64_t i, kept *out);

#endif
