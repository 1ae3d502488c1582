/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the parts of the reader of initial poses share.
 */
#ifndef DATA_POSES_INTERNAL_H
#define DATA_POSES_INTERNAL_H

#include "data/poses/initial_poses.h"
#include "data/poses/pose_file.h"

/* ---- names.c: the frames of a dataset by name ---- */

typedef struct { const char *name; int64_t index; } frame_name;
typedef struct { frame_name *frame; size_t n; } frame_names;

/* frame_names_make - of d, which they borrow from; none where d is NULL. LT_ENOMEM. */
lt_status frame_names_make(lt_arena *arena, const dataset *d, frame_names *out);

/* frame_names_find - the frame that a name or path is of; -1: none */
int64_t frame_names_find(const frame_names *names, const char *path);

/* ---- initial_poses.c ---- */

struct initial_poses {
    lt_arena *arena;
    int64_t frames, *at;            /* of the dataset; which pose each has, or -1 */
    initial_pose *pose;
    size_t n, room;
    initial_poses_counts counts;
    const char *how;
};

/* initial_poses_add - a frame's pose, once. Errors: it has one; LT_ENOMEM. who is for the line. */
lt_status initial_poses_add(initial_poses *p, int64_t frame, const initial_pose *pose, const char *who);

/* ---- truth.c ---- */

/* initial_pose_of_sample - from an annotation: of a right hand, or one that was mirrored */
void initial_pose_of_sample(const dataset_sample *s, const lt_hand_model *hand, initial_pose *out);

/* initial_poses_of_truth - of data itself, by path "truth...", or of the dataset in a folder */
lt_status initial_poses_of_truth(const initial_poses_options *o, initial_poses *out);

/* ---- check.c ---- */

/* initial_poses_check - in front of the camera, and near each other. Errors name the slip that it looks like. */
lt_status initial_poses_check(const initial_poses *p, const char *path);

#endif
