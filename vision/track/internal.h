/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A tracker from inside: its tracks, and one frame being matched to them.
 */
#ifndef VISION_TRACK_INTERNAL_H
#define VISION_TRACK_INTERNAL_H

#include "libtensor/base/arena.h"
#include "vision/track/gallery.h"
#include "vision/track/motion.h"
#include "vision/track/tracker.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    int64_t id;
    int cls;
    bool confirmed;
    int hits;
    int age;                        /* frames since it was seen */
    int detection;                  /* of this frame, or -1 */
    float score;
    box_motion motion;
    gallery look;                   /* zeroed where there are no embeddings */
} track;

typedef struct {
    const tracker_options *options;
    lt_arena *scratch;              /* lives as long as the frame */
    track *tracks;
    const track_detection *found;
    const float **unit;             /* (n_found) embeddings at length 1, NULL: none that counts */
    int n_tracks, n_found;
    int elapsed;                    /* frames since the last one */
    int *found_of;                  /* (n_tracks) out: the detection of each track, or -1 */
    int *track_of;                  /* (n_found) out: the track of each detection, or -1 */
} track_frame;

/* track_match - which detection belongs to which track; found_of and track_of are -1 before. LT_ENOMEM. */
lt_status track_match(track_frame *f);

/* track_alone - the one of n tracks that was seen last where detection j is, with nothing else of its class that
 * overlap might take for either; NULL: there is none */
const track *track_alone(const tracker_options *o, const track *tracks, int n, const track_detection *found,
                         int n_found, int j);

/* track_usable - whether a detection counts at all */
bool track_usable(const track_detection *d);

/* track_appearance - whether tracks are compared by their embeddings */
bool track_appearance(const tracker_options *o);

#ifdef __cplusplus
}
#endif
#endif
