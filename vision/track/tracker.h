/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Identities for the detections of a film, frame by frame: DeepSORT, DeepSORT with ByteTrack's second step, or overlap
 * alone. One tracker for each camera; things of different classes are never taken for one another.
 *
 * Source: Wojke et al. 2017, "Simple online and realtime tracking with a deep association metric"; Zhang et al. 2022,
 * "ByteTrack: multi-object tracking by associating every detection box", algorithm 1.
 */
#ifndef VISION_TRACK_TRACKER_H
#define VISION_TRACK_TRACKER_H

#include "libtensor/base/status.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    TRACK_DEEPSORT,                 /* by appearance, then by overlap */
    TRACK_BYTE,                     /* the same, then what is less sure by overlap; without embeddings by overlap
                                     * alone */
    TRACK_IOU,                      /* by overlap alone */
    TRACK_METHODS,
} track_method;

extern const char *const track_method_names[TRACK_METHODS];     /* "deepsort", "byte", "iou" */

/* An age is in frames of the film's rate, whatever was dropped of them. */
typedef struct {
    track_method method;
    int embedding;                  /* floats of one; 0: there are none, which DeepSORT cannot do without */
    double fps;                     /* of the camera */
    double min_conf;                /* least score of a detection that starts a track */
    double low_conf;                /* byte: least score of one that continues a track */
    double look_conf;               /* least score of one whose embedding counts: what is half hidden looks like what
                                       hides it */
    double max_cosine;              /* largest cosine distance of an appearance */
    double max_iou;                 /* largest 1 - IoU */
    double overlap_cosine;          /* largest cosine distance of an appearance where overlap makes the pair; 2: any,
                                       and of confirmed tracks overlap pairs those alone that the last frame showed */
    double unsure_iou;              /* largest 1 - IoU of a detection below look_conf, where there are embeddings */
    int max_age;                    /* a confirmed track ends that was missed in more frames */
    int n_init;                     /* a track is confirmed at this hit, and until then ends at its first miss */
    int budget;                     /* appearances remembered of a track */
} tracker_options;

/* tracker_defaults - DeepSORT, embeddings of 128, 30 frames a second, 0.3, 0.1, 0.6, 0.2, 0.7, 0.5, 0.4, 30,
 * 3, 100. tracker_as_published - the same with a look_conf of 0, an overlap_cosine of 2 and an unsure_iou of 1:
 * DeepSORT takes what is where a track should be, whatever it looks like. */
extern const tracker_options tracker_defaults, tracker_as_published;

/* tracker_look_conf - the least score of a detection whose embedding is looked at: what is too unsure to begin a track
 * is matched by overlap alone */
double tracker_look_conf(const tracker_options *o);

/* Something found in a frame. One whose box has no area, or any number of which is not finite, is passed over. */
typedef struct {
    float box[4];                   /* x0 y0 x1 y1 in pixels, edges */
    float score;
    int cls;
    const float *embedding;         /* (options.embedding) of any length; NULL, all zero or not finite: none known */
} track_detection;

/* A confirmed track that was seen, or missed in this frame alone */
typedef struct {
    int64_t id;                     /* from 1, each once */
    int cls;
    int detection;                  /* which of this frame's it is; -1: missed, and box is where it should be */
    float score;                    /* of its last detection */
    float box[4];                   /* filtered */
} tracked_box;

typedef struct tracker tracker;

/**
 * tracker_new - one that has seen nothing
 *
 * Freed by tracker_free, of which NULL is fine. Errors: LT_EINVAL for options that cannot be, LT_ENOMEM.
 */
lt_status tracker_new(const tracker_options *options, tracker **out);
void tracker_free(tracker *t);

/**
 * tracker_step - the next frame
 *
 *   time     seconds. The tracks move on by round(elapsed * fps) frames, at least one: also where time stands still,
 *            runs backwards or is not finite
 *   found    (n) all that the detector is at least slightly sure of, in any order
 *   out      (*n_out) the confirmed tracks, by id; valid until the next step
 *
 * Memory is asked for where there are more tracks, or detections in a frame, than ever before. Errors: LT_ENOMEM; that
 * frame then counts as far as it was dealt with, and the next may follow.
 */
lt_status tracker_step(tracker *t, double time, const track_detection *found, int n, const tracked_box **out,
                       int *n_out);

/**
 * tracker_doubts - of which detections of the next frame a look would tell more than their place does
 *
 *   found    (n) as tracker_step will be given them, without embeddings
 *   doubt    (n) out. False: the detection has a track that was seen in the last frame where it is, and nothing else of
 *            the class overlaps with either by as much as max_iou asks; it is matched by overlap alone just as well.
 *            Each track's is in doubt again at every tenth hit, so that the tracker knows how it looks of late
 */
void tracker_doubts(const tracker *t, const track_detection *found, int n, bool *doubt);

#ifdef __cplusplus
}
#endif
#endif
