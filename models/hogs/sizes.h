/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The sizes of HOGS's networks: the paper's, and those of a CPU.
 */
#ifndef MODELS_HOGS_SIZES_H
#define MODELS_HOGS_SIZES_H

#include "models/hogs/avatar.h"
#include "models/hogs/gpm.h"
#include "models/hogs/vpm.h"

typedef struct {
    vpm_opts vpm;
    gpm_opts gpm;
    avatar_opts avatar;             /* frames: none yet */
    int skin_width;                 /* of the skinning field's hidden layers */
    int gpm_points;                 /* of an object that G-PM draws in training */
    int crop, map;                  /* sides of the image that the ViT looks at, and of its map */
} hogs_sizes;

extern const hogs_sizes hogs_full, hogs_cpu;

#endif
