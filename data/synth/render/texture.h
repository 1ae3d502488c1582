/* SPDX-License-Identifier: Apache-2.0 */
/* Textures as the shader reads them. */
#ifndef DATA_SYNTH_RENDER_TEXTURE_H
#define DATA_SYNTH_RENDER_TEXTURE_H

#include "data/synth/render.h"
#include "data/synth/render/small.h"

/* The texture's linear colour at uv, averaged over the pixel's footprint: one step to the right in the
 * picture moves uv by dx, one step down by dy. */
v4 texture_sample(const synth_texture *t, v4 uv, v4 dx, v4 dy);

/* linear_to_srgb - of 0..1, in 0..255 with the fraction kept */
float linear_to_srgb(float linear);

#endif
