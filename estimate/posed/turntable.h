/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Gaussians on a turntable: once around what a frame shows.
 */
#ifndef ESTIMATE_POSED_TURNTABLE_H
#define ESTIMATE_POSED_TURNTABLE_H

#include "estimate/posed/posed.h"

/* turntable_draw - `views` pictures (height, width, 3), each a step further about the vertical axis through the middle
 * of the frame's Gaussians, as the frame's camera sees them; the first is the frame's own. Errors: those of visit,
 * memory. */
lt_status turntable_draw(const posed_frame *f, int views, lt_status (*visit)(void *ctx, const uint8_t *rgb), void *ctx);

#endif
