/* SPDX-License-Identifier: Apache-2.0 */
/* Draws a frame's light, and puts it into scene and sensor. */
#include "synth/take/light.h"

#include "libtensor/base/rng.h"
#include "libtensor/geometry/mat3.h"

#include <math.h>

enum { LIGHT = 0x4c494748, JITTER = 0x4a495454 };

/* How far each variable goes to either side of its middle. Tuned so that some 60 % of the change of pixels of hand and
 * object is global: stats.json says what it came to. */
static const double STOPS = 1.1, WARMTH = 0.26, TINT = 0.09;
static const double AZIMUTH = 1.1, ELEVATION = 0.35, KEY = 0.17, HIGHLIGHT = 1.3;

static const double UP = 0.8, LEFT = -0.3;              /* the lamp at rest, radians from behind the camera */
static const double KEY_AT_REST = 0.6;
static const double LAMP_FAR = 1.7, LAMP_RADIUS = 0.06; /* metres */
static const double LIGHT_SUM = 1;                   /* lamp and sky together on a white surface */
static const double GROUND = 0.55;                      /* of the sky's light comes from below */
static const double LEAST_JITTER = 0.7, MOST_JITTER = 1.3;
static const double TWO_PI = 6.283185307179586;

/* 0, 0 is behind the camera; to the right and up from there. */
static void point_at(double azimuth, double elevation, double toward[3])
{
    toward[0] = cos(elevation) * sin(azimuth);
    toward[1] = -sin(elevation);
    toward[2] = -cos(elevation) * cos(azimuth);
}

/* toward: cos(.8) sin(-.3), -sin(.8), -cos(.8) cos(-.3) */
const synth_light_state synth_light_still = {
    .global = { .exposure = 1 },
    .local = { .toward = { -0.205890, -0.717356, -0.665589 }, .key = 0.6, .highlight = 1 },
    .jitter = { 1, 1, 1 },
};

/* -1..1: where the take stands, and a slow wave through it. */
static double drift(lt_rng *rng, double share)
{
    const double place = lt_rng_range(rng, -1, 1), turns = lt_rng_range(rng, 0.4, 1.3);
    const double phase = lt_rng_range(rng, 0, TWO_PI);

    return 0.6 * place + 0.4 * sin(phase + TWO_PI * turns * share);
}

static void draw_jitter(const synth_light_spec *spec, int k, double out[3])
{
    lt_rng rng = lt_rng_make(spec->seed, lt_rng_mix(lt_rng_mix(spec->stream, JITTER), (uint64_t)k));

    for (int c = 0; c < 3; c++)
        out[c] = lt_rng_range(&rng, LEAST_JITTER, MOST_JITTER);
}

synth_light_state synth_light_at(const synth_light_spec *spec, int k)
{
    const double share = (double)k / (spec->frames > 1 ? spec->frames - 1 : 1);
    lt_rng rng = lt_rng_make(spec->seed, lt_rng_mix(spec->stream, LIGHT));
    synth_light_state s = synth_light_still;

    if (spec->varied) {
        double azimuth, elevation;
        s.global.exposure = exp2(STOPS * drift(&rng, share));
        s.global.warmth = WARMTH * drift(&rng, share);
        s.global.tint = TINT * drift(&rng, share);
        azimuth = LEFT + AZIMUTH * drift(&rng, share);
        elevation = UP + ELEVATION * drift(&rng, share);
        point_at(azimuth, elevation, s.local.toward);
        s.local.key = KEY_AT_REST + KEY * drift(&rng, share);
        s.local.highlight = exp(HIGHLIGHT * drift(&rng, share));
    }
    if (spec->jitter)
        draw_jitter(spec, k, s.jitter);
    return s;
}

void synth_light_up(const synth_light_local *local, synth_scene *scene, synth_light *lamp, synth_instance *instance)
{
    double to_world[9], toward[3];

    lt_mat3_transpose(scene->camera.R_cam_world, to_world);
    lt_mat3_mulvec(to_world, local->toward, toward);
    *lamp = (synth_light){ .radius = LAMP_RADIUS };
    for (int k = 0; k < 3; k++) {
        lamp->position[k] = scene->focus[k] + LAMP_FAR * toward[k];
        lamp->color[k] = (float)(LIGHT_SUM * local->key);
        scene->sky[k] = (float)(LIGHT_SUM * (1 - local->key));
        scene->ground[k] = (float)(GROUND * scene->sky[k]);
    }
    scene->light = lamp;
    scene->n_lights = 1;
    for (int i = 0; i < scene->n_instances; i++)
        if (instance[i].label == SYNTH_LABEL_HAND || instance[i].label == scene->target)
            instance[i].material.specular *= (float)local->highlight;
}

synth_sensor synth_light_sensor(const synth_light_global *global)
{
    return (synth_sensor){
        .exposure = (float)global->exposure,
        .white = { (float)exp(global->warmth), (float)exp(global->tint), (float)exp(-global->warmth) },
        .gamma = 1, .softness = 0.4f, .vignette = 0.05f, .noise = 1.5f,
    };
}

void synth_light_jitter(const double jitter[3], uint8_t (*rgb)[3], int64_t n)
{
    for (int64_t i = 0; i < n; i++)
        for (int c = 0; c < 3; c++)
            rgb[i][c] = (uint8_t)fmin(255, rint(jitter[c] * rgb[i][c]));
}
