/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Light as a variable that is written down: what changes the whole picture alike (global: exposure, white balance,
 * tint), and what changes each surface by where it is (local: where the lamp stands, how strong it is beside the sky,
 * how surfaces shine; shadows follow from it).
 */
#ifndef SYNTH_TAKE_LIGHT_H
#define SYNTH_TAKE_LIGHT_H

#include "synth/render/render.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    double exposure;                /* factor on all light */
    double warmth, tint;            /* gains of red, green, blue: exp(warmth), exp(tint), exp(-warmth) */
} synth_light_global;

typedef struct {
    double toward[3];               /* unit, from the action to the lamp; in the camera's axes, so that light at rest is
                                     * one light to whoever sees the pictures */
    double key;                     /* the lamp's share of the light on a white surface that faces it */
    double highlight;               /* factor on reflections of hand and object */
} synth_light_local;

/* One frame's. */
typedef struct {
    synth_light_global global;
    synth_light_local local;
    double jitter[3];               /* factors on the finished picture's red, green, blue; 1: none */
} synth_light_state;

typedef struct {
    bool varied, jitter;            /* both off: synth_light_still */
    uint64_t seed, stream;          /* of the take */
    int frames;                     /* that it keeps */
} synth_light_spec;

/* synth_light_still - the light that nothing moves: exposure 1, no cast, a lamp behind the camera, high, on its left */
extern const synth_light_state synth_light_still;

/* synth_light_at - of frame k: drawn for the take, drifting through it; jitter is drawn for each frame */
synth_light_state synth_light_at(const synth_light_spec *spec, int k);

/* synth_light_up - put lamp and sky of `local` into the scene, and its highlights on the n instances of hand and
 * object; lamp must live as long as the scene */
void synth_light_up(const synth_light_local *local, synth_scene *scene, synth_light *lamp, synth_instance *instance);

/* synth_light_sensor - sees as `global` says, and else is the same for all frames; without noise's seed */
synth_sensor synth_light_sensor(const synth_light_global *global);

/* synth_light_jitter - multiply the channels of n pixels, cut at 255 */
void synth_light_jitter(const double jitter[3], uint8_t (*rgb)[3], int64_t n);

#ifdef __cplusplus
}
#endif
#endif
