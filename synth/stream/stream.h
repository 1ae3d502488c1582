/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pictures that are made while a network is trained on them, and never stored: a dataset as any other to whoever reads
 * it. Picture number n is a function of the seed and n alone.
 */
#ifndef SYNTH_STREAM_STREAM_H
#define SYNTH_STREAM_STREAM_H

#include "data/kind.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Its kind: of no folder. Opened by synth_stream_open alone. */
extern const dataset_kind synth_stream_kind;

typedef struct {
    uint64_t seed;
    int64_t count;                  /* pictures */
    int shrink;                     /* they are 640 x 480 over this, 1 to 4; of hands from near by 320 x 320 */
    size_t keep;                    /* bytes of memory in which samples stay for when they are read again */
    double near;                    /* share of takes in which hands are seen from near by, mostly bare: near.h */
} synth_stream_options;

/**
 * synth_stream_open - hands with the 21 objects and the jug, by the embedded hand, all labelled as HO3D's
 * training pictures and with masks
 *
 * Neighbours are of different takes, and of each take SYNTH_STREAM_FRAMES pictures are made: whoever reads in order has
 * few takes at hand at a time, and whoever reads elsewhere waits for one to be prepared. What is kept never shows:
 * every picture is a JPEG's (packed.h).
 * Errors: LT_ENOMEM; options that cannot be.
 */
enum { SYNTH_STREAM_FRAMES = 8 };

lt_status synth_stream_open(const synth_stream_options *options, dataset **out);

#ifdef __cplusplus
}
#endif
#endif
