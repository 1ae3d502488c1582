/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Poses of hand and object that HOGS begins from: an estimator's, by files, or the truth with noise. Whatever a file
 * has, they come out in dataset_sample's convention: OpenCV's camera axes, metres, right hands, axis-angle of a flat
 * hand.
 */
#ifndef DATA_POSES_INITIAL_POSES_H
#define DATA_POSES_INITIAL_POSES_H

#include "data/dataset.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    bool has_hand, has_object;      /* what is not there is zero */
    double pose[48], beta[LT_HAND_BETAS];
    double trans[3];                /* MANO's: what is added to a posed vertex; the wrist is trans + J0(beta) */
    double wrist[3];
    int object;                     /* index into the dataset's objects; -1: the file does not say */
    double R[9], t[3];              /* x_cam = R x_model + t; of a mirrored sample, as its own R and t */
} initial_pose;

typedef struct {
    const char *path;               /* a file, in a format of docs/formats.md; or the truth of data: "truth",
                                       "truth+independent", "truth+correlated" (pose_noise.h); or a dataset's folder,
                                       whose truth is taken for frames of the same names */
    const char *list;               /* HOISDF on DexYCB: the annotation list that its keys are of; else NULL */
    const dataset *data;            /* whose frames they are for */
    const dataset *other;           /* the other split of a file that has both, or NULL: its names are not unknown.
                                       Frames that a filter leaves out of data are, unless they are here */
    const lt_hand_model *hand;      /* the right hand */
    uint64_t seed;                  /* of the noise */
} initial_poses_options;

typedef struct initial_poses initial_poses;

/**
 * initial_poses_read - the poses of data's frames
 *
 * A frame goes by its name in the dataset, or by the path of its image or label, however much stands before. Where a
 * file has no place for hands, the wrist is that of the annotation, and how says so.
 *
 * Errors, a line each: a file of no known format, or a broken one, with the frame; left hands; a frame that comes
 * twice; objects that the dataset has not; more than one name in twenty that the dataset does not know; no frame of
 * data's at all; hands or objects that are not in front of the camera (z > 0.05 m), or not within 0.5 m of each other,
 * in more than one frame in twenty: the line names the slip that they look like. LT_EIO, LT_ENOMEM. The caller frees
 * *out; it borrows nothing.
 */
lt_status initial_poses_read(const initial_poses_options *options, initial_poses **out);
void initial_poses_free(initial_poses *p);

/* initial_poses_at - of a sample of the dataset; NULL: there is none, so that the frame is not used */
const initial_pose *initial_poses_at(const initial_poses *p, int64_t index);

/* initial_pose_rotations - pose as dataset_sample.rotation, for hand_pose_at with the wrist as root */
void initial_pose_rotations(const initial_pose *p, float rotation[LT_HAND_JOINTS][9]);

/* What came together: frames of data with a pose and without; names in the file of the other split, and of nobody. */
typedef struct { int64_t matched, missed, other, unknown; } initial_poses_counts;
initial_poses_counts initial_poses_count(const initial_poses *p);

/* initial_poses_how - how they were made, for protocols: "HOISDF (pred_ho_pose.json), wrists from the annotation" */
const char *initial_poses_how(const initial_poses *p);

#ifdef __cplusplus
}
#endif
#endif
