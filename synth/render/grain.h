/* SPDX-License-Identifier: Apache-2.0 */
/* The fine unevenness of skin: blood that shines through in spots, and furrows finer than any mesh. */
#ifndef SYNTH_RENDER_GRAIN_H
#define SYNTH_RENDER_GRAIN_H

/* grain_apply - mottle the albedo and tilt the normal at the point q of the undeformed body (metres)
 *
 *   strength   0..1
 *   pixel      size of a pixel there, metres: what is finer fades away
 */
void grain_apply(const float q[3], float strength, float pixel, float albedo[3], float normal[3]);

#endif
