/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pictures of hands from near by as samples: left and right, mostly bare, in rooms with people. They are those that
 * `palmar synth --preset detect --near` draws, each with the pose of the hand that shows most.
 */
#ifndef SYNTH_STREAM_NEAR_H
#define SYNTH_STREAM_NEAR_H

#include "data/dataset.h"
#include "synth/detect/layout.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * near_sample - picture number n of a place's seed
 *
 * A left hand comes as a right one, in the mirror. A bare one is of no object (-1, no SAMPLE_OBJECT). Objects are
 * counted as the place's props are. Where no hand can be told in a picture, another one takes its place.
 *
 *   want, arena, out     as for dataset_read; the name stays as it is
 *
 * Errors: LT_ENOMEM; LT_ENUMERIC: no hand was seen in 64 pictures.
 */
lt_status near_sample(const dataset *d, const detect_place *place, int64_t n, unsigned want, lt_arena *arena,
                      dataset_sample *out);

#ifdef __cplusplus
}
#endif
#endif
