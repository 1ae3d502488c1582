/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Clips of what persons did before cameras: of a world that `palmar synth --preset world` made, which knows it, with
 * the skeletons that are true or those that were seen.
 */
#ifndef DATA_RECORDING_CLIPS_H
#define DATA_RECORDING_CLIPS_H

#include "data/action/action.h"

#ifdef __cplusplus
extern "C" {
#endif

/* recording_clips_probe - whether root is a recording with the truth beside it */
bool recording_clips_probe(const char *root);

/**
 * recording_clips_open - a clip for each thing that each person did, into the arena
 *
 *   root     a recording with truth.ndjson
 *   seen     a file of lines as palmar watch prints them, whose skeletons are taken in place of the true ones: at each
 *            moment that of the nearest person; NULL or "": the true ones
 *
 * Joints are in data/action's axes, forward towards the robot. Hands with objects are not looked at. What took less
 * than half a second is left out, as is what nobody was seen at. out->whole: clips are all for scoring, whoever acts.
 *
 * Errors: those of the recording and of the lines, with file and line; no clip is left. LT_ENOMEM.
 */
lt_status recording_clips_open(lt_arena *arena, const char *root, const char *seen, action_set *out);

#ifdef __cplusplus
}
#endif
#endif
