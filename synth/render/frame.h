/* SPDX-License-Identifier: Apache-2.0 */
/* What a frame keeps from picture to picture, so that none allocates but to grow. */
#ifndef SYNTH_RENDER_FRAME_H
#define SYNTH_RENDER_FRAME_H

#include "synth/render/shade.h"

struct synth_scratch {
    raster_list list, shadow_list;
    shadow_map shadow[SYNTH_MAX_LIGHTS];
    shade_scene shade;
    float *open, *half[2];          /* at half the resolution */
};

#endif
