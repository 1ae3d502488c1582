/* SPDX-License-Identifier: Apache-2.0 */
/* Every draw stands in a statement of its own, as C leaves the order of arguments open. */
#include "synth/body/appearance.h"

#include "synth/room/pattern.h"
#include "synth/room/room.h"

#include <math.h>
#include <string.h>

enum { LOOK = 0x4c4f4f4b };

static void linear(float rgb[3])
{
    for (int k = 0; k < 3; k++)
        rgb[k] = powf(rgb[k], 2.2f);
}

static void draw_color(lt_rng *r, double hue_lo, double hue_hi, double saturation, double value, float rgb[3])
{
    const double hue = lt_rng_range(r, hue_lo, hue_hi);

    pattern_hsv(hue, saturation, value, rgb);
    linear(rgb);
}

static void draw_hair(lt_rng *r, synth_appearance *l)
{
    static const double napes[3] = { 1.55, 1.52, 1.44 };
    const double dark = lt_rng_uniform(r), saturation = lt_rng_range(r, 0.1, 0.6);

    draw_color(r, 0.03, 0.11, saturation, 0.06 + 0.65 * dark * dark, l->hair);
    l->nape = napes[lt_rng_below(r, 3)];
    l->fringe = lt_rng_range(r, 1.635, 1.668);
    l->hair_depth = lt_rng_below(r, 12) ? lt_rng_range(r, 0.008, 0.026) : 0;
}

/* Short sleeves, long ones, and what is between them. */
static void draw_cut(lt_rng *r, synth_appearance *l)
{
    const double pushed = lt_rng_range(r, 0.4, 0.70), length = lt_rng_uniform(r);

    l->sleeve = length < 0.3 ? lt_rng_range(r, 0.29, 0.42) : length < 0.6 ? pushed : lt_rng_range(r, 0.70, 0.735);
    l->hem = lt_rng_range(r, 0.86, 0.93);
    l->cuff = lt_rng_below(r, 5) ? lt_rng_range(r, 0.05, 0.12) : lt_rng_range(r, 0.42, 0.6);
    l->loose = lt_rng_range(r, 0.006, 0.016);
    l->folds = lt_rng_u32(r);
}

lt_status synth_appearance_draw(lt_arena *arena, const lt_hand_model *hand, uint64_t seed, int number,
                                synth_appearance *out)
{
    const uint64_t stream = lt_rng_mix(LOOK, (uint64_t)number);
    lt_rng r = lt_rng_make(seed, stream);
    synth_appearance l = { 0 };
    float rgb[3];

    /* Neighbours in number differ in tone, so that a small set already varies. */
    synth_hand_colors(hand, (2 * number + number / 3) % SYNTH_HAND_TONES, l.hand);
    for (int i = 0; i < SYNTH_HAND_WRIST_LOOP; i++)
        for (int k = 0; k < 3; k++)
            l.skin[k] += l.hand[synth_hand_wrist_loop[i]][k] / SYNTH_HAND_WRIST_LOOP;
    draw_hair(&r, &l);
    draw_color(&r, 0.05, 0.6, 0.5, 0.4, l.iris);
    draw_cut(&r, &l);
    l.shirt = synth_arm_cloth(arena, seed, stream);
    pattern_draw_color(&r, 0, 0.5, 0.08, 0.6, rgb);
    l.trousers = pattern_weave(arena, &r, rgb);
    pattern_draw_color(&r, 0, 0.5, 0.05, 0.8, l.shoes);
    linear(l.shoes);
    if (!l.shirt || !l.trousers || !synth_texture_paint(l.shirt) || !synth_texture_paint(l.trousers))
        return lt_error(LT_ENOMEM, "synth: no memory for a person's clothes");
    *out = l;
    return LT_OK;
}
