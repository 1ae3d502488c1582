/* SPDX-License-Identifier: Apache-2.0 */
/* How long a tracker takes for a frame, once the network has looked. */
#ifndef EVAL_BENCH_TRACKS_H
#define EVAL_BENCH_TRACKS_H

#include "libtensor/base/status.h"

enum { BENCH_TRACKS = 20 };

/* bench_tracks - DeepSORT's bookkeeping of 20 tracks that walk through each other and remember 100 looks each, the
 * median of 200 frames. *tracks: how many there were in the last. LT_ENOMEM. */
lt_status bench_tracks(double *median_ms, int *tracks);

#endif
