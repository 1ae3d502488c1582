/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes frames, sequences and calibration as a DexYCB tree, in its axes, orders and keys.
 *
 * Poses are in OpenCV camera axes and metres, as DexYCB has them. A left hand's picture is a left hand's: its
 * pose is that of the mirrored hand model.
 */
#ifndef SYNTH_WRITE_DEXYCB_H
#define SYNTH_WRITE_DEXYCB_H

#include "synth/render/render.h"
#include "synth/take/picture.h"
#include "synth/write/manifest.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SYNTH_DEXYCB_FILES = 3, SYNTH_DEXYCB_OBJECTS = 5, SYNTH_DEXYCB_CAMERAS = 8 };

/* The serial numbers that DexYCB's cameras have, and its toolkit expects. */
extern const char *const synth_dexycb_serial[SYNTH_DEXYCB_CAMERAS];

/* What lies on the table in a sequence, and what is in the hand. */
typedef struct {
    const char *folder;             /* "20260101-subject-01/20260101_100000" */
    bool left;
    int frames, cameras;
    int n_objects, id[SYNTH_DEXYCB_OBJECTS], grasped;
    const char *extrinsics, *mano;  /* names of calibrations */
} synth_dexycb_sequence;

/* One frame as one camera sees it. */
typedef struct {
    const synth_dexycb_sequence *sequence;
    const lt_hand_model *hand;      /* the right hand */
    const synth_picture *picture;
    int camera;
    double R[SYNTH_DEXYCB_OBJECTS][9], t[SYNTH_DEXYCB_OBJECTS][3];      /* of all objects, camera axes */
} synth_dexycb_frame;

/* synth_dexycb_mirror - a right hand's picture into a left one's: planes, poses, camera, in place */
void synth_dexycb_mirror(synth_picture *p, uint8_t *rgb, float *depth, uint8_t *label);

/* synth_dexycb_pose - pose_m (51): root, 45 coefficients of the side's components, translation */
void synth_dexycb_pose(const synth_dexycb_frame *f, float pose[51]);

/**
 * synth_dexycb_write_frame - color, depth (millimetres) and labels of one frame under root
 *
 *   files    what was written, SYNTH_DEXYCB_FILES of them
 *
 * The folders must be there: synth_dexycb_make_folders. May run on many threads for different frames.
 */
lt_status synth_dexycb_write_frame(const char *root, const synth_dexycb_frame *f, int quality, synth_file *files);

/* synth_dexycb_make_folders - a sequence's, one for each camera */
lt_status synth_dexycb_make_folders(const char *root, const synth_dexycb_sequence *q);

/**
 * synth_dexycb_write_sequence - meta.yml and pose.npz
 *
 *   pose_m   (frames, 51)              both in world axes, which are the first camera's
 *   pose_y   (frames, n_objects, 7)    quaternion x y z w, translation
 */
lt_status synth_dexycb_write_sequence(const char *root, const synth_dexycb_sequence *q, const float *pose_m,
                                      const float *pose_y, synth_manifest *manifest);

/* synth_dexycb_write_intrinsics - calibration/intrinsics of n cameras, by their serials */
lt_status synth_dexycb_write_intrinsics(const char *root, const synth_camera *camera, int n, synth_manifest *manifest);

/* synth_dexycb_write_extrinsics - calibration/extrinsics_<id>: each camera to the first one, and the table, whose
 * axes the cameras' R_cam_world starts from, as the tag */
lt_status synth_dexycb_write_extrinsics(const char *root, const char *id, const synth_camera *camera, int n,
                                        synth_manifest *manifest);

/* synth_dexycb_write_mano - calibration/mano_<id> */
lt_status synth_dexycb_write_mano(const char *root, const char *id, const double beta[LT_HAND_BETAS],
                                  synth_manifest *manifest);

#ifdef __cplusplus
}
#endif
#endif
