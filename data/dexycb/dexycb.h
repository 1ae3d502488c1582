/* SPDX-License-Identifier: Apache-2.0 */
/*
 * DexYCB as downloaded: a folder for each subject, calibration/, models/; setups s0 to s3.
 *
 * Source: Chao et al. 2021, "DexYCB"; files as NVlabs/dex-ycb-toolkit reads them.
 */
#ifndef DATA_DEXYCB_DEXYCB_H
#define DATA_DEXYCB_DEXYCB_H

#include "data/dataset.h"
#include "data/dexycb/split.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { DEXYCB_WIDTH = 640, DEXYCB_HEIGHT = 480, DEXYCB_MAX_OBJECTS = 8 };

/* Which samples of a split papers use. */
typedef enum {
    DEXYCB_VALID,                   /* with a hand: joints are annotated (the toolkit's) */
    DEXYCB_EVERY,                   /* the toolkit's whole list; some have no hand */
    DEXYCB_HFL,                     /* HFL-Net: valid, and in training the joints' box, grown by half, is in
                                       the image; in the other parts such a sample has the image as its box */
    DEXYCB_HOISDF,                  /* AlignSDF, gSDF, HOISDF: valid right hands within 5 mm of the object, every
                                       fifth frame */
} dexycb_filter;

extern const dataset_kind dexycb_kind;

/* The names of setups, and of filters in their order; end with NULL. */
extern const char *const dexycb_setups[], *const dexycb_filters[];

/* dexycb_parse_filter - one of dexycb_filters */
lt_status dexycb_parse_filter(const char *name, dexycb_filter *out);

typedef struct {
    const char *root;               /* the folder with calibration/ and the subjects' folders */
    const char *setup, *split;      /* as dexycb_split_parse takes them */
    const char *models;             /* the folder of the YCB models; NULL: root/models */
    dexycb_filter filter;
    const lt_hand_model *hand;      /* the right hand that the data were made with: its pose components */
    const lt_hand_model *left;      /* the left one; NULL: the right one's mirror image */
    bool no_objects;                /* hand only: models are not needed, samples have no object */
} dexycb_options;

/**
 * dexycb_open - the samples of a split: by subject, sequence, camera, frame, the last fastest
 *
 * Left hands come mirrored (dataset.h). A hand's pose is its mean and 45 components, so that the same
 * hand model as in training the annotation is needed; it is not kept. Both hands' tips are the toolkit's.
 * What a filter needs is read from all labels of the split; an unreadable label passes, and fails when it
 * is read as a sample. A dataset by `palmar synth` says its own numbers of subjects and sequences in
 * synthetic.json; the rules of the splits are the same.
 *
 * A subject that is not there is left out, and partial says so.
 *
 * Errors: missing folders, calibration or models, no subject of the split there, sequences that are not 100, an
 * empty split; the line says what to do. The caller frees *out with dataset_free.
 */
lt_status dexycb_open(const dexycb_options *options, dataset **out);

/* Names of folders, sorted, in an arena. */
typedef struct { const char **name; int n; } dexycb_folders;

/* dexycb_list_subjects - those of subjects in a tree; none is no error. dexycb_list_sequences - a subject's. Errors:
 * LT_EIO, LT_ENOMEM. */
lt_status dexycb_list_subjects(lt_arena *arena, const char *root, dexycb_folders *out);
lt_status dexycb_list_sequences(lt_arena *arena, const char *root, const char *subject, dexycb_folders *out);

/* dexycb_subject_number - "20200709-subject-01" is 0, as dexycb_has_subject counts; dexycb_find_subject - the folder of
 * that number, or NULL */
int dexycb_subject_number(const char *folder);
const char *dexycb_find_subject(const dexycb_folders *subjects, int number);

/* Where a sample stands in the official lists. */
typedef struct {
    int64_t index;                  /* in the toolkit's list of the split, before any filter: HPE files count so. Of
                                       what is there, where the split is partial */
    int scene, image;               /* BOP's ids: sequence and camera within the split; frame */
    bool keyframe;                  /* a BOP target: every fourth frame */
    int n_targets, target[DEXYCB_MAX_OBJECTS];      /* YCB ids on the table; target[grasped] is in the hand */
    int grasped;
} dexycb_place;

/* dexycb_place_of - of sample index of d, which dexycb_open opened; dexycb_list_length - of the list that index counts
 * in */
dexycb_place dexycb_place_of(const dataset *d, int64_t index);
int64_t dexycb_list_length(const dataset *d);

/* x_cam = R x_model + t */
typedef struct {
    bool known;                     /* false: not annotated */
    float R[9], t[3];
} dexycb_pose;

/* A frame's depth and the objects on its table, for whom left and right are as they were: nothing is mirrored. */
typedef struct {
    lt_camera camera;
    const float *depth;             /* (DEXYCB_HEIGHT, DEXYCB_WIDTH) metres, 0 where unknown */
    dexycb_pose pose[DEXYCB_MAX_OBJECTS];       /* in the order of dexycb_place's targets */
    const dataset_object *model[DEXYCB_MAX_OBJECTS];        /* of what is annotated */
} dexycb_scene;

/**
 * dexycb_read_scene - of sample index of d, which dexycb_open opened with its objects
 *
 *   arena   owns the depth
 *
 * Errors: a broken depth image or label, an annotated object whose model is not there. Thread-safe.
 */
lt_status dexycb_read_scene(const dataset *d, int64_t index, lt_arena *arena, dexycb_scene *out);

/**
 * dexycb_models_info - the path, in arena, of what BOP says of the models; *out is NULL where it is not there
 *
 * bop/s0/models_eval/models_info.json in the dataset's folder, as the toolkit has it for each setup, else
 * bop/models_info.json in the models' folder. d was opened with its objects.
 */
lt_status dexycb_models_info(const dataset *d, lt_arena *arena, const char **out);

#ifdef __cplusplus
}
#endif
#endif
