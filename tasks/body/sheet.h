/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures with the true nodes in them, beside the estimated ones. */
#ifndef TASKS_BODY_SHEET_H
#define TASKS_BODY_SHEET_H

#include "data/body/set.h"
#include "libtensor/base/arena.h"

enum { SHEET_MOST = 12 };

typedef struct {
    lt_arena *arena;                            /* of the pictures that are drawn */
    uint8_t (*rgb[2 * SHEET_MOST])[3];          /* of the size of a set's pictures, true and estimated in turn */
    const char *title[2 * SHEET_MOST];
    int n;
} body_sheet;

/**
 * body_sheet_add - one more sample, as long as there are fewer than SHEET_MOST. LT_ENOMEM
 *
 *   image        (3, BODY_PICTURE_HEIGHT, BODY_PICTURE_WIDTH) in [0, 1]
 *   true_nodes, nodes    (BODY_NODES, 2) pixels
 */
lt_status body_sheet_add(body_sheet *s, const float *image, const float (*true_nodes)[2], const float (*nodes)[2],
                         const char *name, double error_mm);

/* body_sheet_write - as a PNG */
lt_status body_sheet_write(body_sheet *s, const char *path);

#endif
