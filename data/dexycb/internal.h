/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the parts of the DexYCB reader share.
 */
#ifndef DATA_DEXYCB_INTERNAL_H
#define DATA_DEXYCB_INTERNAL_H

#include "data/dexycb/dexycb.h"

enum { DEXYCB_MAX_FRAMES = 10000 };

/* A sequence of the split. */
typedef struct {
    const char *folder;             /* "20200709-subject-01/20200709_141754" */
    int frames;
    int n_objects, object[DEXYCB_MAX_OBJECTS], grasped;     /* YCB ids; index of the one in the hand */
    bool left;
    const char *extrinsics;         /* calibration/extrinsics_<this> */
    float beta[LT_HAND_BETAS];
    int64_t first;                  /* number of its first sample in the whole list */
} dexycb_sequence;

/* The pose space of a hand: pose = mean + coefficients * component. */
typedef struct {
    float mean[LT_HAND_PCA], component[LT_HAND_PCA][LT_HAND_PCA];
} dexycb_pose_space;

typedef struct {
    dataset base;                   /* first: a dataset * is a dexycb * */
    lt_arena *arena;                /* of everything, this struct included */
    dexycb_split split;
    dexycb_filter filter;
    const char *models;
    dexycb_pose_space hand[2];      /* right, left */
    int n_serials;
    const char *serial[DEXYCB_CAMERAS];
    lt_camera intrinsics[DEXYCB_CAMERAS];
    int n_cameras, camera[DEXYCB_CAMERAS];      /* of the split: indices into serial */
    dexycb_sequence *sequence;
    int n_sequences;
    int64_t total;                  /* samples before the filter */
    uint32_t *kept;                 /* base.count numbers in the whole list; NULL: all of it */
    const char **name;              /* base.count of them: "SUBJECT/SEQUENCE/SERIAL/000012" */
} dexycb;

/* Which file a sample is in. */
typedef struct {
    const dexycb_sequence *sequence;
    int position, camera, frame;    /* of the sequence in the split; of the camera in serial */
} dexycb_spot;

/* dexycb_find - where number `at` of the whole list is */
dexycb_spot dexycb_find(const dexycb *d, int64_t at);

/* What a label file says of the hand and the object in it. */
typedef struct {
    bool hand;                      /* false: not annotated */
    float pose[51];                 /* root axis-angle, 45 coefficients, translation */
    float joints[LT_HAND_KEYPOINTS][3], joints2d[LT_HAND_KEYPOINTS][2];
    dexycb_pose object;
} dexycb_label;

/* dexycb_label_path - of its file; NULL without memory */
const char *dexycb_label_path(const dexycb *d, dexycb_spot spot, lt_arena *arena);

/* dexycb_read_label - without the segmentation. Errors name file and array. */
lt_status dexycb_read_label(const dexycb *d, dexycb_spot spot, dexycb_label *out);

/* dexycb_read_poses - of all objects on the table, in the order of the sequence's ids */
lt_status dexycb_read_poses(const dexycb *d, dexycb_spot spot, dexycb_pose out[DEXYCB_MAX_OBJECTS]);

/* dexycb_read_segments - the segmentation, (DEXYCB_HEIGHT, DEXYCB_WIDTH) in arena: SEGMENT_HAND, SEGMENT_OBJECT where
 * it has the object in the hand, 0 elsewhere, also at the table's other objects; a left hand as it is */
lt_status dexycb_read_segments(const dexycb *d, dexycb_spot spot, lt_arena *arena, uint8_t **out);

/* dexycb_fill_hand - rotations, beta, joints and root of a label with a hand; left hands as they are */
void dexycb_fill_hand(const dexycb *d, dexycb_spot spot, const dexycb_label *label, dataset_sample *s);

/* dexycb_box_is_empty - the box of the joints, grown by half about its middle and cut to the image, holds nothing */
bool dexycb_box_is_empty(const dexycb_label *label);

/* dexycb_open_tree - sequences, cameras and their calibration, for d's root and split */
lt_status dexycb_open_tree(dexycb *d);

/* dexycb_apply_filter - d->kept and base.count, by d->filter; hand: for the filter that poses it */
lt_status dexycb_apply_filter(dexycb *d, const lt_hand_model *hand);

#endif
