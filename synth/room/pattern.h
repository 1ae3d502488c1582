/* SPDX-License-Identifier: Apache-2.0 */
/* Surfaces painted from random numbers: wood, stone, plaster, cloth, tiles, printed labels. */
#ifndef SYNTH_ROOM_PATTERN_H
#define SYNTH_ROOM_PATTERN_H

#include "libtensor/base/rng.h"
#include "synth/render/render.h"

/* All repeat seamlessly but labels; NULL without memory. Colours are sRGB 0..1. They want synth_texture_paint
 * before they are drawn with. */
synth_texture *pattern_wood(lt_arena *arena, lt_rng *r);
synth_texture *pattern_stone(lt_arena *arena, lt_rng *r);
synth_texture *pattern_plaster(lt_arena *arena, lt_rng *r);
synth_texture *pattern_stripes(lt_arena *arena, lt_rng *r);
synth_texture *pattern_checks(lt_arena *arena, lt_rng *r);
synth_texture *pattern_tiles(lt_arena *arena, lt_rng *r);
synth_texture *pattern_weave(lt_arena *arena, lt_rng *r, const float rgb[3]);
synth_texture *pattern_label(lt_arena *arena, lt_rng *r);
synth_texture *pattern_page(lt_arena *arena, lt_rng *r);
synth_texture *pattern_fruit(lt_arena *arena, lt_rng *r);

/* pattern_hsv - hue, saturation and value 0..1 to sRGB; pattern_draw_color - of any hue, the others between
 * these */
void pattern_hsv(double hue, double saturation, double value, float rgb[3]);
void pattern_draw_color(lt_rng *r, double saturation_lo, double saturation_hi, double value_lo,
                        double value_hi, float rgb[3]);

#endif
