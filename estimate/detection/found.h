/* SPDX-License-Identifier: Apache-2.0 */
/* What a detector's graph found in the pictures of a batch. */
#ifndef ESTIMATE_DETECTION_FOUND_H
#define ESTIMATE_DETECTION_FOUND_H

#include "estimate/compiled.h"
#include "vision/detection/detection.h"

/**
 * detect_found_in - in slot i of the last run of a csp_seg, of the width x height picture that is there
 *
 * The surest first, in the arena. LT_ENOMEM.
 */
lt_status detect_found_in(const compiled *c, const model *m, int i, int width, int height, const detection_rules *rules,
                          lt_arena *arena, detect_found **out, int *n);

#endif
