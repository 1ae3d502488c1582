/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A world as a recording (data/recording): one to three persons at a table with a robot's side, who do ten things one
 * after the other, and what one to four calibrated RGB-D cameras see of it, 30 frames a second.
 *
 *   recording.json, frames.jsonl, CAMERA/000001.jpg, .z16      as any recording
 *   masks/CAMERA/000001.png     8 bits: the thing that a pixel shows, 0 none
 *   truth.ndjson                a line for each true moment
 *   world.json                  who and what there is, light, clocks
 *   stats.json, manifest.json
 *   coco/, bop/                 where the options ask for them: export.h
 *
 * One seed is one world; a frame is a function of the seed, its number and the camera, so what is written does not
 * depend on how many are.
 */
#ifndef SYNTH_WORKPLACE_WORKPLACE_H
#define SYNTH_WORKPLACE_WORKPLACE_H

#include "synth/generate.h"
#include "synth/workplace/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WORKPLACE_SECONDS 20.0      /* where none are named */

/**
 * synth_workplace - write the recording into an empty folder
 *
 *   figures      (*n) of stats.json
 *
 * Errors: LT_EINVAL for more than four cameras or more than an hour; LT_EIO, LT_ENOSPC, LT_ENOMEM; LT_ESTOPPED when
 * progress said so.
 */
lt_status synth_workplace(const synth_options *options, synth_figure figures[SYNTH_FIGURES], int *n);

/* What a film is made with; prop: (YCB_COUNT) by number less one, those of workplace_cast are there. */
typedef struct {
    const synth_body *body;
    const lt_hand_model *hand;
    const synth_prop_pair *prop;
} workplace_means;

/* workplace_film - the same with means that are there already, and pictures shrunk so many times */
lt_status workplace_film(const synth_options *options, const workplace_means *means, int shrink,
                         synth_figure figures[SYNTH_FIGURES], int *n);

#ifdef __cplusplus
}
#endif
#endif
