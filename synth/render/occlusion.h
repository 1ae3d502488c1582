/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Ambient occlusion from the depth picture: crevices and contacts see less of the sky.
 *
 * Source: Bavoil, Sainz 2009, "Image-space horizon-based ambient occlusion", the plain form: each
 * neighbour hides as much as it rises above the tangent plane.
 */
#ifndef SYNTH_RENDER_OCCLUSION_H
#define SYNTH_RENDER_OCCLUSION_H

#include "synth/render/render.h"

/* occlusion_find - open sky of every pixel, 0..1, at half resolution
 *
 *   depth    (height, width)
 *   open     ((height + 1) / 2, (width + 1) / 2)
 *   scratch  two of the size of open
 */
void occlusion_find(const synth_camera *camera, const float *depth, float *open, float *scratch[2]);

/* occlusion_at - open at a full-resolution pixel, from the half-resolution pixels of like depth */
float occlusion_at(const synth_camera *camera, const float *depth, const float *open, int x, int y);

#endif
