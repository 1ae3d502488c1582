/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The 21 shapes in millimetres, each in its own frame around the origin, before yaw and fit.
 */
#ifndef DATA_SYNTH_SHAPES_H
#define DATA_SYNTH_SHAPES_H

#include "data/synth/loft.h"

/* Where the parts of an object find their colours in the texture; flat ones are set to size by a shape. */
typedef enum { CHART_SIDE, CHART_TOP, CHART_BOTTOM, CHART_SECOND, CHART_THIRD, CHART_COUNT } synth_chart;

extern const loft_chart synth_charts[CHART_COUNT];

/* synth_shape_build - add the parts of object ycb_id, 1 .. 21 */
void synth_shape_build(loft_builder *b, int ycb_id);

#endif
