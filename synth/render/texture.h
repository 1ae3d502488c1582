/* SPDX-License-Identifier: Apache-2.0 */
/* Textures as the shader reads them. */
#ifndef SYNTH_RENDER_TEXTURE_H
#define SYNTH_RENDER_TEXTURE_H

#include "synth/render/render.h"
#include "synth/render/small.h"

/* What a pixel covers of a texture. */
typedef struct {
    int probes;                     /* along axis, one colour each; 0: it covers no finite part */
    v4 axis;                        /* its longer side in uv */
    int level, next;                /* of the mip chain */
    float mix;                      /* share of the second one */
} texture_footprint;

/* texture_cover - one step to the right in the picture moves uv by dx, one step down by dy */
texture_footprint texture_cover(const synth_texture *t, v4 dx, v4 dy);

/* The texture's linear colour at uv, averaged over the footprint. */
v4 texture_sample(const synth_texture *t, v4 uv, const texture_footprint *f);

/* linear_to_srgb - of 0..1, in 0..255 with the fraction kept */
float linear_to_srgb(float linear);

#endif
