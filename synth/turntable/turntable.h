/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A still scene to try splatting on: a stand-in on black, photographed from a spiral around it, 400 x 400.
 *
 *   images/0000.png, masks/0000.png, ..      masks: white where the object is
 *   points.ply                               its vertices, each in the colour of its texture
 *   transforms.json                          as nerfstudio has it, all keys in every frame
 *   manifest.json
 *
 * Metres; z up; the seed chooses the object and where the lamps stand.
 */
#ifndef SYNTH_TURNTABLE_TURNTABLE_H
#define SYNTH_TURNTABLE_TURNTABLE_H

#include "synth/generate.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { TURNTABLE_VIEWS = 60, TURNTABLE_SIDE = 400 };

/* synth_turntable - write options->frames views, or TURNTABLE_VIEWS, into an empty folder; *n = 0 figures. Errors:
 * LT_EINVAL for more than 9999; LT_EIO, LT_ENOMEM; LT_ESTOPPED when progress said so. */
lt_status synth_turntable(const synth_options *options, synth_figure figures[SYNTH_FIGURES], int *n);

#ifdef __cplusplus
}
#endif
#endif
