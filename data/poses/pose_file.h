/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: files of initial poses, whichever of the formats they have, as one kind of record. What needs a dataset or
 * a hand model is done by initial_poses.c.
 */
#ifndef DATA_POSES_POSE_FILE_H
#define DATA_POSES_POSE_FILE_H

#include "libtensor/base/arena.h"
#include "libtensor/base/status.h"

struct cJSON;

/* One frame of a file. Metres, axis-angle; OpenCV's axes unless opengl is set. */
typedef struct {
    const char *frame;              /* as the file names it: a dataset's name, or the path of an image or a label */
    bool has_hand, has_object;
    double pose[48], beta[10];
    double trans[3], wrist[3];      /* of the hand: which of them is known, placed says */
    enum { POSE_BY_TRANS, POSE_BY_WRIST, POSE_BY_ANNOTATION } placed;
    bool pca, add_mean;             /* pose[3 ..] are coefficients; the mean pose is to be added */
    bool opengl;
    int object_id;                  /* YCB's; 0: not said */
    const char *object_name;        /* or NULL */
    double R[9], t[3];              /* R is a rotation */
} pose_record;

/* pose_record_fn - takes a record, which lives until it returns; its error ends the reading */
typedef lt_status pose_record_fn(void *ctx, const pose_record *r);

/* The text of a file, n bytes with a NUL behind them, and its path for error lines. */
typedef struct { const char *path, *text; size_t n; } pose_text;

/**
 * pose_file_parse - all records of a file
 *
 *   list    HOISDF's annotation list, where that format's keys are a list's; its text is NULL where there is none
 *   format  "palmar.poses/1", "palmar.frame/1", "HOISDF": set as soon as it is known
 *
 * Errors: no format of these; whatever is wrong with it, with the frame's name; one of the callback.
 */
lt_status pose_file_parse(pose_text file, pose_text list, pose_record_fn *take, void *ctx, const char **format);

/* ---- what the formats share ---- */

typedef struct {
    pose_text file;
    pose_record_fn *take;
    void *ctx;
    lt_arena *scratch;              /* emptied behind every frame */
    char name[512];                 /* path, and frame, for error lines */
} pose_reader;

/* pose_reader_at - name becomes `path, "frame"` */
void pose_reader_at(pose_reader *r, const char *frame);

/* pose_numbers - n finite numbers below 1e4, in lists of any depth: Python writes (1, 3) as well as (3). Errors name
 * what, "hand.pose". */
lt_status pose_numbers(const pose_reader *r, const struct cJSON *list, const char *what, int n, double *out);

/* pose_rotation - R becomes the rotation next to it. Errors: it is a mirror, or no rotation to 1e-2. */
lt_status pose_rotation(const pose_reader *r, const char *what, double R[9]);

lt_status pose_read_palmar(pose_reader *r);
lt_status pose_read_frames(pose_reader *r);
lt_status pose_read_hoisdf(pose_reader *r, pose_text list);

#endif
