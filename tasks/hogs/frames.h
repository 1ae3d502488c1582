/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Frames as HOGS takes them: an image with masks of what is seen of hand and object, and poses to begin with.
 */
#ifndef TASKS_HOGS_FRAMES_H
#define TASKS_HOGS_FRAMES_H

#include "data/dataset.h"
#include "data/loader.h"
#include "data/poses/initial_poses.h"
#include "models/hogs/hogs.h"
#include "tasks/hogs/config.h"
#include "tasks/hogs/rig.h"

/* Poses of a frame, camera axes, metres */
typedef struct {
    float rotation[LT_HAND_JOINTS][9], root[3];         /* the hand as a dataset_sample has it, its wrist */
    float R[9], t[3];                                   /* the object */
} hogs_poses;

typedef struct {
    bool there;                     /* false: it could not be read, or nothing is seen; the rest is undefined */
    int64_t index, number;          /* in the dataset, among the source's frames */
    int subject, object;            /* numbers of their sets, among hands, among objects */
    int data_object;                /* of the dataset's objects */
    lt_camera camera;
    double crop[6];                 /* the image to the crop, as vision/crop.h has it */
    hogs_poses initial, truth;
    bool known;                     /* there is a true pose of the object */
    bool hand_known;                /* there is one of the hand */
    const float (*vertices)[3];     /* (778) of the true hand, camera, the dataset's; NULL: it has none */
    uint64_t draw;                  /* stream of what training draws for it */
    float *image;                   /* (3, S, S) in [0, 1] */
    float *target;                  /* (12, H, W) */
    uint8_t *segments;              /* (H, W), as dataset_sample has them */
    float box[HOGS_IMAGES][4];      /* around each mask: x0 y0 x1 y1, ends exclusive; zeros: it is empty */
} hogs_frame;

/* What a loader makes of them */
typedef struct {
    int count, capacity;
    hogs_frame *frame;              /* (capacity) */
    lt_arena *memory;
} hogs_batch;

/* Where frames come from. Borrowed. */
typedef struct {
    const dataset *data;
    const initial_poses *poses;
    const model *m;
    hogs_masks masks;
    const lt_hand_model *hand;
    bool jitter, training;          /* draws of colours are of the epoch in training, always the same elsewhere */
    uint64_t seed;
    const int64_t *index;           /* (count) of the dataset's frames */
    int64_t count;
    const dataset *shown;           /* whose frame show_as[i] the networks see in the place of frame i's own image, */
    const int64_t *show_as;         /* in its own crop. (count), -1: the frame is not there; NULL: each its own */
} hogs_source;

/* hogs_frames_loader - s outlives the loader's. A frame fails where it cannot be read, is of another size than the
 * model draws, shows a left hand, or a subject or object that has no set; it is not there where nothing is seen. */
loader_source hogs_frames_loader(const hogs_source *s);

/* hogs_frames_of - the dataset's frames that have initial poses of hand and object, in arena memory. LT_ENOMEM; an
 * error where there is none. */
lt_status hogs_frames_of(lt_arena *arena, const dataset *data, const initial_poses *poses, const int64_t **index,
                         int64_t *count);

/* hogs_frames_check - look into each sequence: an error that names one whose frames have no mask, or empty ones */
lt_status hogs_frames_check(const hogs_source *s);

#endif
