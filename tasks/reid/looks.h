/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What identities are learnt from: boxes of the truth in films, each with who it is. Ids of sets of `palmar synth` are
 * of the whole set, for persons, hands and objects apart; those of others are of a sequence.
 */
#ifndef TASKS_REID_LOOKS_H
#define TASKS_REID_LOOKS_H

#include "data/mot/mot.h"
#include "tasks/reid/config.h"

typedef struct {
    int sequence;
    int64_t frame;
    int identity;                   /* 0 .. identities - 1 */
    float box[4];                   /* x0 y0 x1 y1 in pixels */
} look;

typedef struct {
    mot_set set;
    const look *look;
    int64_t n;
    int identities;
} looks;

/**
 * looks_open - those of a split
 *
 *   every     frames from one that is looked at to the next
 *   visible   least share of a box that is seen
 *
 * Lives in the arena. Errors: those of mot_open and mot_read; no box that counts.
 */
lt_status looks_open(lt_arena *arena, const char *root, const char *split, int every, double visible, looks *out);

/* looks_person - whether a sequence's boxes are persons': not of a set's folders of hands and objects */
bool looks_person(const mot_sequence *s);

/* A source of samples; how NULL: as they are, without noise */
typedef struct {
    const looks *of;
    const reid_data_config *how;
    uint64_t seed;
    int64_t count;                  /* the first so many are looked at */
} look_feed;

/* A batch, as look_source makes them */
typedef struct {
    int count;
    int64_t *index;
    bool *there;
    float *image;                   /* (capacity, 3, 128, 64) in [0, 1] */
} look_batch;

/* look_source - feed outlives it; sample i of an epoch is a function of both and of the seed */
loader_source look_source(const look_feed *feed);

#endif
