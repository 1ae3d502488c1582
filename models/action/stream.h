/* SPDX-License-Identifier: Apache-2.0 */
/*
 * ST-GCN on a stream: one frame's work for each frame, with a ring of what went before for each unit's moments.
 *
 * A unit waits for the frames that follow the one it looks at, kernel / 2 of them; one that halves moments gives a
 * result for every second frame. There are no zeros at the ends of a window, so its results are not those of a window:
 * they are what the units say of a long clip, away from its ends, late by the sum of what they wait. The feature is the
 * mean over the last ones, as many as a window leaves.
 *
 * Source: Hedegaard et al. 2023, "Continual spatio-temporal graph convolutional networks".
 */
#ifndef MODELS_ACTION_STREAM_H
#define MODELS_ACTION_STREAM_H

#include "models/action/action.h"

typedef struct action_stream action_stream;

/* action_stream_new - m and its parameters outlive it. Errors: LT_ENOMEM. action_stream_free - NULL is fine */
lt_status action_stream_new(const model *m, action_stream **out);
void action_stream_free(action_stream *s);

/* action_stream_begin - of another person, or anew */
void action_stream_begin(action_stream *s);

/* action_stream_features - of stream 1; action_stream_delay - frames between what is seen and the last result's */
int action_stream_features(const action_stream *s);
int action_stream_delay(const action_stream *s);

/**
 * action_stream_body - one frame more
 *
 *   joint     (3, 65) in the world, metres; the pelvis of the first frame since the beginning is the origin
 *   feature   (features) of stream 1; as long as nothing has come through all units, not touched
 *
 * Returns whether there is a feature.
 */
bool action_stream_body(action_stream *s, const lt_real *joint, lt_real *feature);

/* action_stream_last - what the last unit gave last: (features, 65), borrowed; NULL: nothing yet */
const lt_real *action_stream_last(const action_stream *s);

#endif
