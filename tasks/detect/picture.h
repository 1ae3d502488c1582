/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A picture as a detector learns from it: one of the dataset's, or four put together, of another size, at another place
 * and in other colours, with the boxes and masks of what is left of its objects.
 */
#ifndef TASKS_DETECT_PICTURE_H
#define TASKS_DETECT_PICTURE_H

#include "data/detection/detection.h"
#include "libtensor/base/rng.h"
#include "models/detect/csp_seg.h"
#include "tasks/detect/config.h"

/* Where a picture goes, in one slot of a batch */
typedef struct {
    int size;                       /* a side in pixels */
    float *image;                   /* (3, size, size) in [0, 1] */
    float *objects;                 /* (DETECT_MAX_OBJECTS, OBJECT_NUMBERS), as csp_seg.h has them */
    int32_t *masks;                 /* (DETECT_MAX_OBJECTS, words) */
    int n;                          /* objects there */
} picture;

/* picture_words - words of a mask of a picture of this size */
int picture_words(int size);

/* picture_plain - image i of *width x *height pixels, fitted in as letterbox_of says. Errors: those of detection_read
 * and detection_mask. */
lt_status picture_plain(const detection_set *set, int64_t i, lt_arena *scratch, picture *out, int *width, int *height);

/* picture_augmented - image i, and with `mosaic` three others that rng draws */
lt_status picture_augmented(const detection_set *set, int64_t i, const detect_config *how, bool mosaic, lt_rng *rng,
                            lt_arena *scratch, picture *out);

#endif
