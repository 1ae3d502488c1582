/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A body's 65 nodes with the bones between them, drawn over a picture.
 */
#ifndef VISION_DRAWING_BODY_H
#define VISION_DRAWING_BODY_H

#include "assets/body/body.h"
#include "vision/drawing/draw.h"

/* body_draw - what is left of the body blue, what is right orange, the middle green; a node that is not finite is left
 * out, with its bones. width: of the fingers, in pixels; 1 for a picture of some 200. */
void body_draw(draw_canvas *c, const float (*node)[2], float width);

#endif
