/* SPDX-License-Identifier: Apache-2.0 */
/* What making a stage and filming it share. */
#ifndef SYNTH_TAKE_INTERNAL_H
#define SYNTH_TAKE_INTERNAL_H

#include "synth/take/stage.h"

/* Uses of a stage's stream. */
enum { MOTION = 1, VIEW, ROOM, ARM, SENSOR, NOISE, DEPTH_NOISE, SHUTTER, TABLE };

static const double ARM_LENGTH = 0.6;           /* metres */

#endif
