/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Trackers on a sequence: from the detections of det.txt, never from the truth, to boxes with identities.
 */
#ifndef TASKS_REID_FOLLOW_H
#define TASKS_REID_FOLLOW_H

#include "data/mot/mot.h"
#include "estimate/embedder.h"
#include "vision/track/tracker.h"

/**
 * follow - the results of each tracker on a sequence
 *
 *   options  (n) the trackers; the same embeddings serve all
 *   out      (n) of (frames), in the arena
 *   seen     called after each frame; may be NULL; false: LT_ESTOPPED
 *
 * Errors: no detections; a picture that cannot be read, or has another size than seqinfo.ini says; LT_ENOMEM.
 */
lt_status follow(lt_arena *arena, const mot_sequence *s, embedder *e, const tracker_options *options, int n,
                 bool (*seen)(void *ctx), void *ctx, mot_frame **out);

#endif
