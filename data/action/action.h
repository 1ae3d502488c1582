/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Clips of actions on skeletons, as ST-GCN's readers have them: a folder with
 *
 *   body.npy           (N, 3, T, 65, 1) f4   joints in the world, metres; x right, y down, z forward
 *   hand_object.npy    (N, 3, T, 30, 1) f4   a hand and the object in it; may be missing
 *   valid.npy          (N, T) u1             1: hand and object are known; with the former
 *   label.json         {"names": [], "labels": [], "classes": [], "subject": [], "onset": [], "frames": []}
 *
 * T is the length of the longest clip; what is behind a clip's last frame is not looked at.
 *
 * Body: pelvis, hips, knees, ankles (left first), neck, shoulders, elbows, wrists, then of each foot big toe, small toe
 * and heel, ears, eyes, nose, and of each hand 4 joints of thumb, index, middle, ring and little finger, base to tip.
 * Hand and object: the wrist and 20 such joints, the corners of the object's cuboid, x fastest, and its centre.
 *
 * Source: Bandi and Thomas 2025, "Action recognition via multi-view perception feature tracking for human-robot
 * interaction", section 5.
 */
#ifndef DATA_ACTION_ACTION_H
#define DATA_ACTION_ACTION_H

#include "libtensor/base/arena.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    ACTION_CLASSES = 10, ACTION_WITH_OBJECT = 6,        /* classes from here on have an object */
    ACTION_BODY = 65, ACTION_HAND_OBJECT = 30,
    ACTION_MOST_FRAMES = 10000, ACTION_MOST_SUBJECTS = 10000,
};

extern const char *const action_classes[ACTION_CLASSES];

typedef struct {
    const char *name;
    int cls, subject, frames;
    int onset;                      /* the frame in which the act begins; -1: not known */
} action_clip;

typedef struct {
    const char *root;
    const action_clip *clip;
    int64_t n;
    int length;                     /* T */
    int subjects;                   /* 1 + the largest number */
    const float *body;              /* (n, 3, T, 65); zeros with no_body */
    bool no_body;                   /* skeletons are not known */
    bool whole;                     /* all of it is for scoring, whoever acts */
    const float *hand_object;       /* (n, 3, T, 30), or NULL */
    const uint8_t *valid;           /* (n, T), or NULL */
    bool synthetic;                 /* its manifest says so */
    double difficulty;              /* of what is synthetic; NaN: not told */
} action_set;

/**
 * action_open - the clips in a folder, into the arena
 *
 * A frame with a joint that is not finite is one in which nobody was seen: it holds the last one that was, or, at the
 * beginning, the first. Where hand or object are not finite, they are not valid.
 *
 * Errors: a file is missing or has another shape; labels that are no class, fewer or more of them than clips; a clip
 * without frames, or in which nobody is ever seen. LT_EIO, LT_EFORMAT, LT_ENOMEM.
 */
lt_status action_open(lt_arena *arena, const char *root, action_set *out);

/* action_hold_body - in a clip's (3, length, 65) a frame that is not finite becomes the last one that was, or at the
 * beginning the first; false: there is none */
bool action_hold_body(const action_clip *c, float *body, int length);

/* action_probe - whether root is such a folder */
bool action_probe(const char *root);

/* action_parse_labels - what label.json says of n clips of `length` frames, from so many characters; *clip: (n) */
lt_status action_parse_labels(lt_arena *arena, const char *path, const char *text, size_t bytes, int64_t n, int length,
                              const action_clip **clip);

#ifdef __cplusplus
}
#endif
#endif
